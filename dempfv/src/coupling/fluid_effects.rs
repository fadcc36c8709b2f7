//! What a fluid does beside flowing, without weight and incompressible, between walls.

use serde::{Deserialize, Serialize};

use super::error::Result;
use crate::pfv::terms::{Compressibility, StepTerms};

/// Effects of the fluid that are off unless someone asks for them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FluidEffects {
    /// Bulk modulus of the fluid (Pa); `None`: incompressible.
    pub bulk_modulus: Option<f64>,
}

impl FluidEffects {
    /// Whether pores store fluid, so that the matrix of a network goes with the time step.
    pub fn store(&self) -> bool {
        self.bulk_modulus.is_some()
    }

    /// The terms that the matrix of a network is made with, for a first step of this length (s).
    pub(super) fn step_terms(&self, time_step: f64) -> Result<StepTerms> {
        let mut step = StepTerms { terms: vec![], time_step };
        if let Some(bulk_modulus) = self.bulk_modulus {
            step.terms.push(Box::new(Compressibility::new(bulk_modulus)?));
        }
        Ok(step)
    }
}
