//! What the balance of a pore has beside the flow through its throats and the motion of its
//! vertices: one file per effect.
//!
//! The balance of pore i is Σ_j g_ij (p_j − p_i) = V̇_i + Σ_terms u_i: what flows in through throats
//! is what its growth and the terms take up (m³/s). A term that depends on pressures adds its part
//! to the diagonal where `Operators` is built (`Operators::with_conditions`), and a force between the
//! two spheres of an edge is added where `Flow::update_force` evaluates `f = F p`; no term of today
//! needs either.

mod source;

use std::fmt;

pub use source::{PoreSource, Sources};

/// A term in the balance of the pores. Without one a flow allocates and computes nothing for it.
pub trait FluidTerm: fmt::Debug + Send + Sync {
    /// Its name among the effects of a simulation.
    fn name(&self) -> &'static str;

    /// Adds what each pore takes up (m³/s), one entry per pore.
    fn add_uptake(&self, uptake: &mut [f64]);
}

/// The terms of a flow.
#[derive(Debug, Default)]
pub(super) struct Terms {
    terms: Vec<Box<dyn FluidTerm>>,
    /// What each pore takes up in all; empty without terms.
    uptake: Vec<f64>,
}

impl Terms {
    /// Takes a term in, in the place of one of the same name.
    pub fn set(&mut self, term: Box<dyn FluidTerm>) {
        self.remove(term.name());
        self.terms.push(term);
    }

    /// Takes a term out. Returns whether there was one of this name.
    pub fn remove(&mut self, name: &str) -> bool {
        let before = self.terms.len();
        self.terms.retain(|term| term.name() != name);
        if self.terms.is_empty() {
            self.uptake = vec![];
        }
        self.terms.len() < before
    }

    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.terms.iter().map(|term| term.name())
    }

    /// What the throats of each pore must bring (m³/s): its growth, and what the terms take up.
    pub fn demand<'a>(&'a mut self, volume_rate: &'a [f64]) -> &'a [f64] {
        if self.terms.is_empty() {
            return volume_rate;
        }
        self.uptake.clear();
        self.uptake.extend_from_slice(volume_rate);
        for term in &self.terms {
            term.add_uptake(&mut self.uptake);
        }
        &self.uptake
    }

    /// The same as it was in the last solve.
    pub fn last_demand<'a>(&'a self, volume_rate: &'a [f64]) -> &'a [f64] {
        if self.uptake.len() == volume_rate.len() { &self.uptake } else { volume_rate }
    }
}
