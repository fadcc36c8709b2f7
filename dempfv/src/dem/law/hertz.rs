//! Hertz's elastic contact of spheres.

use serde::Serialize;

use super::batch::Batch;
use super::geometry::{Geometry, Radii};
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::dot;
use crate::dem::error::DemError;
use crate::dem::material::{Material, WallMaterial};
use crate::effect::{Effect, EffectKey, Family};

/// Hertz's contact with Mindlin's shear stiffness, as an effect.
pub const EFFECT: Effect = Effect {
    name: "Hertz-Mindlin contacts",
    family: Family::Contacts,
    equation: "F_n = 4/3 E* √R* δ^(3/2); dF_s = 8 G* √(R* δ) ds, F_s smaller with the contact radius on \
               unloading, |F_s| ≤ μ F_n",
    source: "K. L. Johnson: Contact Mechanics (1985), ch. 4 and 7; shear on unloading: C. Thornton, S. J. \
             Cummins, P. W. Cleary: Powder Technology 233 (2013)",
    keys: &[
        EffectKey { key: "law in [contacts]", unit: "", default: "\"linear\"" },
        EffectKey { key: "poisson_ratio in [contacts]", unit: "", default: "0.25" },
        EffectKey { key: "wall_poisson_ratio in [contacts]", unit: "", default: "the spheres'" },
    ],
    needs: "",
    test: "dempfv/tests/dem_hertz.rs",
};

/// Poisson's ratios: with them a modulus of a material is Young's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hertz {
    /// Poisson's ratio of the spheres.
    pub poisson_ratio: f64,
    /// Poisson's ratio of the walls.
    pub wall_poisson_ratio: f64,
}

impl Hertz {
    pub(super) fn check(&self) -> Result<(), DemError> {
        let named = [
            ("poisson_ratio", self.poisson_ratio),
            ("wall_poisson_ratio", self.wall_poisson_ratio),
        ];
        for (name, value) in named {
            // Beyond, a material would not resist a change of shape or of volume.
            if !(value > -1.0 && value <= 0.5) {
                let expected = "above -1 and up to 0.5";
                return Err(DemError::Parameter { name, value, expected });
            }
        }
        Ok(())
    }

    /// E* (Pa) and 4 G*/E* of two spheres.
    pub(super) fn between_spheres(&self, first: &Material, second: &Material) -> (f64, f64) {
        effective([(first.young, self.poisson_ratio), (second.young, self.poisson_ratio)])
    }

    /// The same of a sphere on a wall.
    pub(super) fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> (f64, f64) {
        effective([(sphere.young, self.poisson_ratio), (wall.young, self.wall_poisson_ratio)])
    }
}

/// 1/E* = Σ (1 − ν²)/E and 1/G* = Σ (2 − ν)/G, G = E / 2(1 + ν): E* and k_t/k_n = 8 G* a / 2 E* a.
fn effective(bodies: [(f64, f64); 2]) -> (f64, f64) {
    let sum = |of: fn(f64) -> f64| bodies.iter().map(|(e, nu)| of(*nu) / e).sum::<f64>();
    let normal = sum(|nu| 1.0 - nu * nu);
    let shear = sum(|nu| 2.0 * (2.0 - nu) * (1.0 + nu));
    (1.0 / normal, 4.0 * normal / shear)
}

/// Tangent stiffness 2 E* a (N/m), a = √(R* δ), where the surfaces touch; 0 elsewhere.
#[inline(always)]
pub(super) fn stiffness(modulus: f64, reduced_radius: f64, overlap: f64) -> f64 {
    2.0 * modulus * (reduced_radius * overlap.max(0.0)).sqrt()
}

/// Overlap (m) at which the contact holds an energy (J): W = 8/15 E* √R* δ^(5/2).
pub(super) fn overlap_of_energy(modulus: f64, reduced_radius: f64, energy: f64) -> f64 {
    (15.0 / 8.0 * energy / (modulus * reduced_radius.sqrt())).powf(0.4)
}

/// The normal forces of a batch: 2/3 of the tangent stiffness times δ.
#[inline(always)]
pub(super) fn press<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let overlap = batch.geometry.overlap(l);
        let radius = batch.geometry.radii(l).reduced(1.0);
        let stiffness = stiffness(parameters(l).modulus, radius, overlap);
        terms.stiffness[l] = stiffness;
        terms.push[l] = 2.0 / 3.0 * stiffness * overlap;
    }
}

/// Factor on the force of a spring whose stiffness goes with the contact radius: where that shrinks,
/// what no longer touches takes its share along. Without it unloading would leave more energy than
/// there was. `growth` is the contact radius over what it was a step before; 0 without Hertz's contact.
#[inline(always)]
pub(super) fn kept_force(growth: f64) -> f64 {
    if growth > 0.0 { growth.min(1.0) } else { 1.0 }
}

/// What such a spring of stiffness k and force F loses, over F²/2k of now: where it grows stiffer, the
/// force stays.
#[inline(always)]
pub(super) fn lost_share(growth: f64) -> f64 {
    match growth {
        growth if growth > 1.0 => growth - 1.0,
        growth if growth > 0.0 => 1.0 / growth - 1.0,
        _ => 0.0,
    }
}

/// What of the force over the step went with the parts that no longer touch, over the force of now: it
/// has done half the work of the step.
#[inline(always)]
pub(super) fn gone_share(growth: f64) -> f64 {
    if growth > 0.0 && growth < 1.0 { 1.0 / growth - 1.0 } else { 0.0 }
}

/// How the contact radius has grown in the step: a² = R* δ, and δ was the rate of separation times
/// the step larger.
#[inline(always)]
pub(super) fn grow<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms) {
    for l in batch.lanes() {
        let separation = dot(batch.geometry.velocity(l), batch.geometry.normal(l)) * batch.dt;
        let overlap = batch.geometry.overlap(l).max(0.0);
        let before = overlap + separation;
        terms.growth[l] = if before > 0.0 { (overlap / before).sqrt() } else { 1.0 };
    }
}
