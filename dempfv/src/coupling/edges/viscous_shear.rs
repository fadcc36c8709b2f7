//! Viscous shear: the fluid between two neighbours is sheared where they move past each other.

use super::film::Film;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "viscous shear",
    family: Family::Fluid,
    equation: "F_t = μ A Δv_t / (gap + 0.45 r), A the facet between the two power cells, r the smaller radius",
    source: "D. Marzougui, B. Chareyre, J. Chauchat: Granular Matter 17 (2015); \
             the depth as YADE 2023.02a has it",
    keys: &[EffectKey { key: "viscous_shear in [fluid]", unit: "", default: "false" }],
    needs: "the edges of the triangulation",
    test: "dempfv/tests/coupling_shear.rs",
};

/// Depth of the sheared fluid between surfaces that touch, over the smaller radius: found in what YADE
/// computes, to 2e-4 of the mean force.
const DEPTH: f64 = 0.45;

/// Writes the resistance of each film. Overlaps leave at least half of the depth.
pub fn resist(films: &mut [Film], viscosity: f64) {
    for film in films {
        let touching = DEPTH * film.smaller;
        let depth = (film.gap + touching).max(0.5 * touching);
        film.viscous_shear = viscosity * film.area / depth;
    }
}
