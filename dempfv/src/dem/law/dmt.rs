//! Adhesion of hard contacts: Derjaguin, Muller and Toporov.

use super::batch::Batch;
use super::geometry::{Geometry, Radii};
use super::terms::{Memory, Terms};
use crate::effect::{Effect, EffectKey, Family};

/// DMT adhesion, as an effect.
pub const EFFECT: Effect = Effect {
    name: "DMT adhesion",
    family: Family::Contacts,
    equation: "F_n = F_Hertz − 2π w R* while the surfaces touch, w the work of adhesion per area (twice the \
               surface energy of equal solids); friction and rolling resistance go with F_Hertz",
    source: "B. V. Derjaguin, V. M. Muller, Y. P. Toporov: J. Colloid Interface Sci. 53 (1975)",
    keys: &[
        EffectKey { key: "adhesion in [contacts]", unit: "", default: "\"none\"" },
        EffectKey { key: "work_of_adhesion in [contacts]", unit: "J/m²", default: "required" },
    ],
    needs: "Hertz-Mindlin contacts",
    test: "dempfv/tests/dem_adhesion.rs",
};

/// The pull-off force (N) of a work of adhesion (J/m²).
#[inline(always)]
pub(super) fn pull_off(work: f64, radii: impl Radii) -> f64 {
    radii.reduced(2.0 * std::f64::consts::PI * work)
}

/// The pull of a batch (N).
#[inline(always)]
pub(super) fn pull<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms, work: f64) {
    for l in batch.lanes() {
        terms.pull[l] = pull_off(work, batch.geometry.radii(l));
    }
}
