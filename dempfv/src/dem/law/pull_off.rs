//! Cohesion by a constant force while two surfaces touch.

use super::batch::Batch;
use super::geometry::Geometry;
use super::terms::{Memory, Terms};
use crate::effect::{Effect, EffectKey, Family};

/// A constant pull-off force, as an effect.
pub const EFFECT: Effect = Effect {
    name: "constant cohesion",
    family: Family::Contacts,
    equation: "F_n = F_contact − F_0 while the surfaces touch; friction and rolling resistance go \
               with F_n + F_0",
    source: "S. Luding: Granular Matter 10 (2008)",
    keys: &[
        EffectKey { key: "adhesion in [contacts]", unit: "", default: "\"none\"" },
        EffectKey { key: "pull_off_force in [contacts]", unit: "N", default: "required" },
    ],
    needs: "",
    test: "dempfv/tests/dem_adhesion.rs",
};

/// The pull of a batch (N).
#[inline(always)]
pub(super) fn pull<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms, force: f64) {
    for l in batch.lanes() {
        terms.pull[l] = force;
    }
}
