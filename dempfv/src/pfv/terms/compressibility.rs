//! A fluid that its pressure compresses: the pores store what more of it they hold.

use super::FluidTerm;
use crate::pfv::PfvError;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: Compressibility::NAME,
    family: Family::Fluid,
    equation: "sum_j g_ij (p_j - p_i) = dV_i/dt + V_void,i / K_f * dp_i/dt, implicit in time",
    source: "Caulk et al. 2020, section 2.2; Skempton 1954 for its undrained limit",
    keys: &[EffectKey {
        key: "bulk_modulus in [fluid]",
        unit: "Pa",
        default: "none: incompressible",
    }],
    needs: "the pores' void volumes; another factorization where the time step changes",
    test: "dempfv/tests/pfv_compressible.rs",
};

/// The compressibility of a fluid. Its density is ρ₀ (1 + p/K_f): linear in the pressure, so that
/// the pressure is measured from where the fluid has its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compressibility {
    bulk_modulus: f64,
}

impl Compressibility {
    /// The name of this term.
    pub const NAME: &'static str = "fluid compressibility";

    /// A fluid of this bulk modulus K_f (Pa).
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for one that is not positive and finite.
    pub fn new(bulk_modulus: f64) -> Result<Compressibility, PfvError> {
        if bulk_modulus > 0.0 && bulk_modulus.is_finite() {
            return Ok(Compressibility { bulk_modulus });
        }
        let problem = format!("{bulk_modulus} Pa; it must be positive and finite");
        Err(PfvError::InvalidInput { argument: "bulk_modulus", index: None, problem })
    }
}

impl FluidTerm for Compressibility {
    fn name(&self) -> &'static str {
        Compressibility::NAME
    }

    fn stores(&self) -> bool {
        true
    }

    fn add_capacity(&self, void: &[f64], capacity: &mut [f64]) {
        for (capacity, void) in capacity.iter_mut().zip(void) {
            *capacity += void / self.bulk_modulus;
        }
    }
}
