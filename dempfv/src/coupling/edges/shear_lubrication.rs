//! Shear lubrication: the film between two surfaces that slide drags both.

use std::f64::consts::PI;

use super::film::Film;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "shear lubrication",
    family: Family::Fluid,
    equation: "F_t = π/2 μ (d ln(d/h) − 2R) Δv_t, d the distance of the centres, h = max(gap, 0) + 2 ε R; \
               0 where that is negative",
    source: "N. A. Frankel, A. Acrivos: Chem. Eng. Sci. 22 (1967); \
             D. Marzougui, B. Chareyre, J. Chauchat: Granular Matter 17 (2015)",
    keys: &[
        EffectKey { key: "shear_lubrication in [fluid]", unit: "", default: "false" },
        EffectKey { key: "eps in [fluid]", unit: "", default: "1e-5" },
    ],
    needs: "the edges of the triangulation, and rough surfaces",
    test: "dempfv/tests/coupling_shear.rs",
};

/// Writes the resistance of each film. Of very rough or distant surfaces the expansion for thin films
/// is negative, which would drive them.
pub fn resist(films: &mut [Film], viscosity: f64) {
    for film in films {
        let Film { distance, thickness, radius, .. } = *film;
        let factor = distance * (distance / thickness).ln() - 2.0 * radius;
        film.shear_lubrication = 0.5 * PI * viscosity * factor.max(0.0);
    }
}
