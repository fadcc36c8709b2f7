//! Twist torque: the film between two spheres that turn about the line of their centres.

use std::f64::consts::PI;

use super::film::Film;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "twist torque",
    family: Family::Fluid,
    equation: "M_n = π μ R² h ln(R/h) Δω_n; 0 where h > R",
    source: "D. J. Jeffrey, Y. Onishi: J. Fluid Mech. 139 (1984); \
             D. Marzougui, B. Chareyre, J. Chauchat: Granular Matter 17 (2015)",
    keys: &[
        EffectKey { key: "twist_torque in [fluid]", unit: "", default: "false" },
        EffectKey { key: "eps in [fluid]", unit: "", default: "1e-5" },
    ],
    needs: "the edges of the triangulation, and rotation",
    test: "dempfv/tests/coupling_shear.rs",
};

/// Writes the resistance of each film: 0 in the limit of smooth surfaces that touch.
pub fn resist(films: &mut [Film], viscosity: f64) {
    for film in films {
        let share = film.thickness / film.radius;
        let factor = if share > 0.0 { -share * share.ln() } else { 0.0 };
        film.twist = PI * viscosity * film.radius.powi(3) * factor.max(0.0);
    }
}
