//! The weight of the fluid: pressures stay those in excess of the hydrostatic one, spheres feel
//! buoyancy.

use std::f64::consts::PI;

use super::{Flow, PfvError};
use crate::{Effect, EffectKey, Family, Vec3};

/// What this effect says of itself.
pub const BUOYANCY: Effect = Effect {
    name: "buoyancy",
    family: Family::Fluid,
    equation: "f_i = -rho_f g V_i; p_total = p + rho_f g . (x - x_0), x_0 where the box is highest",
    source: "Archimedes; Terzaghi 1943 for the critical gradient",
    keys: &[EffectKey { key: "density in [fluid]", unit: "kg/m³", default: "none: no weight" }],
    needs: "gravity in [dem]",
    test: "dempfv/tests/coupling_weight.rs",
};

impl Flow {
    /// Gives the fluid a weight per volume, ρ_f g (N/m³): spheres feel buoyancy from the next
    /// [`Flow::update_force`] on. The pressures that are solved for and imposed, and the forces on
    /// walls, stay those in excess of the hydrostatic pressure, which
    /// [`Flow::hydrostatic_pressure`] tells.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a weight that is not finite.
    pub fn set_weight(&mut self, weight: Vec3) -> Result<(), PfvError> {
        if !weight.iter().all(|w| w.is_finite()) {
            let problem = format!("[{}, {}, {}] N/m³ is not finite", weight.x, weight.y, weight.z);
            return Err(PfvError::InvalidInput { argument: "weight", index: None, problem });
        }
        self.weight = weight;
        let buoyancy = |r: &f64| -4.0 / 3.0 * PI * r.powi(3) * weight;
        self.buoyancy = self.radius.iter().map(buoyancy).collect();
        Ok(())
    }

    /// The hydrostatic pressure at a point (Pa), 0 where the box is highest: the total pressure is
    /// that of a pore and this. 0 everywhere in a fluid without weight.
    pub fn hydrostatic_pressure(&self, point: &Vec3) -> f64 {
        let bounds = self.network().bounds;
        let weight = self.weight;
        let top = Vec3::from_fn(|k, _| if weight[k] > 0.0 { bounds.min[k] } else { bounds.max[k] });
        weight.dot(&(point - top))
    }
}
