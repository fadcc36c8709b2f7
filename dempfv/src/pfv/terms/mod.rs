//! What the balance of a pore has beside the flow through its throats and the motion of its
//! vertices: one file per effect.
//!
//! The balance of pore i is Σ_j g_ij (p_j − p_i) = V̇_i + Σ_terms u_i: what flows in through throats
//! is what its growth and the terms take up (m³/s). A term that stores fluid takes up
//! S_i (p_i − p_i') / Δt, p' the pressure when the step began: S/Δt on the diagonal of the matrix. It
//! is there when the matrix is made ([`StepTerms`]). Forces between the two spheres of an edge need
//! spins and contacts: they are in `coupling/edges`.

mod compressibility;
mod source;

use std::fmt;

use super::storage::Storage;

pub use compressibility::{Compressibility, EFFECT as COMPRESSIBILITY};
pub use source::{EFFECT as SOURCES, PoreSource, Sources};

/// A term in the balance of the pores. Without one a flow allocates and computes nothing for it.
pub trait FluidTerm: fmt::Debug + Send + Sync {
    /// Its name among the effects of a simulation.
    fn name(&self) -> &'static str;

    /// Adds what each pore takes up whatever its pressure (m³/s), one entry per pore.
    fn add_uptake(&self, _uptake: &mut [f64]) {}

    /// Whether pores store fluid by this term.
    fn stores(&self) -> bool {
        false
    }

    /// Adds what each pore stores per unit of its pressure (m³/Pa), one entry per pore, each 0 or
    /// more. `void` has the volume of fluid in each pore (m³).
    fn add_capacity(&self, _void: &[f64], _capacity: &mut [f64]) {}
}

/// Terms that a network's matrix is made with.
#[derive(Debug, Default)]
pub struct StepTerms {
    /// The terms.
    pub terms: Vec<Box<dyn FluidTerm>>,
    /// Length of the first step (s); of no account where no term stores fluid.
    pub time_step: f64,
}

/// The terms of a flow.
#[derive(Debug, Default)]
pub(super) struct Terms {
    terms: Vec<Box<dyn FluidTerm>>,
    /// Sources whose rates may change; not among the others.
    sources: Option<Sources>,
    /// What each pore takes up in all; empty without terms.
    uptake: Vec<f64>,
}

impl Terms {
    pub fn new(terms: Vec<Box<dyn FluidTerm>>) -> Terms {
        Terms { terms, ..Terms::default() }
    }

    /// Whether a term stores fluid.
    pub fn store(&self) -> bool {
        self.terms.iter().any(|term| term.stores())
    }

    /// Adds up what pores with these void volumes (m³) store per unit of pressure (m³/Pa).
    pub fn write_capacity(&self, void: &[f64], capacity: &mut [f64]) {
        for term in &self.terms {
            term.add_capacity(void, capacity);
        }
    }

    /// The terms that store fluid: they know no numbers of pores.
    pub fn into_storing(self) -> Vec<Box<dyn FluidTerm>> {
        self.terms.into_iter().filter(|term| term.stores()).collect()
    }

    /// Takes a term in, in the place of one of the same name.
    pub fn set(&mut self, term: Box<dyn FluidTerm>) {
        self.remove(term.name());
        self.terms.push(term);
    }

    /// Takes sources in, in the place of others.
    pub fn set_sources(&mut self, sources: Sources) {
        self.remove(Sources::NAME);
        self.sources = Some(sources);
    }

    pub fn sources_mut(&mut self) -> Option<&mut Sources> {
        self.sources.as_mut()
    }

    /// Takes a term out. Returns whether there was one of this name.
    pub fn remove(&mut self, name: &str) -> bool {
        let before = self.names().count();
        self.terms.retain(|term| term.name() != name);
        self.sources = self.sources.take().filter(|_| name != Sources::NAME);
        if self.is_empty() {
            self.uptake = vec![];
        }
        self.names().count() < before
    }

    fn is_empty(&self) -> bool {
        self.terms.is_empty() && self.sources.is_none()
    }

    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        let sources = self.sources.iter().map(|sources| sources.name());
        self.terms.iter().map(|term| term.name()).chain(sources)
    }

    /// What the throats of each pore must bring (m³/s): its growth, and what the terms take up.
    pub fn demand<'a>(&'a mut self, volume_rate: &'a [f64]) -> &'a [f64] {
        if self.is_empty() {
            return volume_rate;
        }
        self.uptake.clear();
        self.uptake.extend_from_slice(volume_rate);
        for term in &self.terms {
            term.add_uptake(&mut self.uptake);
        }
        if let Some(sources) = &self.sources {
            sources.add_uptake(&mut self.uptake);
        }
        &self.uptake
    }

    /// Adds what is stored at the pressures (Pa) that were solved for.
    pub fn settle(&mut self, storage: Option<&Storage>, pressure: &[f64]) {
        if let Some(storage) = storage {
            storage.add_uptake(pressure, &mut self.uptake);
        }
    }

    /// What each pore took up in the last solve (m³/s); empty without terms.
    pub fn taken(&self) -> &[f64] {
        &self.uptake
    }

    /// Takes what each pore took up in a step before (m³/s).
    pub fn restore(&mut self, taken: &[f64]) {
        self.uptake = taken.to_vec();
    }

    /// What the throats of each pore brought in the last solve (m³/s).
    pub fn last_demand<'a>(&'a self, volume_rate: &'a [f64]) -> &'a [f64] {
        if self.uptake.len() == volume_rate.len() { &self.uptake } else { volume_rate }
    }
}
