//! Pump torque: spheres that roll on each other pump fluid through the gap between them.

use std::f64::consts::PI;

use super::film::Film;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "pump torque",
    family: Family::Fluid,
    equation: "M_t = π μ R³ (3/20 + 63/500 h/R) ln(R/h) Δω_t; 0 where h > R",
    source: "D. J. Jeffrey, Y. Onishi: J. Fluid Mech. 139 (1984); \
             D. Marzougui, B. Chareyre, J. Chauchat: Granular Matter 17 (2015)",
    keys: &[
        EffectKey { key: "pump_torque in [fluid]", unit: "", default: "false" },
        EffectKey { key: "eps in [fluid]", unit: "", default: "1e-5" },
    ],
    needs: "the edges of the triangulation, rotation, and rough surfaces",
    test: "dempfv/tests/coupling_shear.rs",
};

/// Writes the resistance of each film. The expansion for thin films is negative where one is thicker
/// than the sphere's radius.
pub fn resist(films: &mut [Film], viscosity: f64) {
    for film in films {
        let share = film.thickness / film.radius;
        let factor = -(3.0 / 20.0 + 63.0 / 500.0 * share) * share.ln();
        film.pump = PI * viscosity * film.radius.powi(3) * factor.max(0.0);
    }
}
