//! Linear springs as the normal part of the granular law: F_n = k_n δ, as in the linear law.

use super::batch::Batch;
use super::geometry::{Geometry, Radii};
use super::terms::{GranularParameters, Memory, Terms};
use crate::dem::material::{Material, WallMaterial};

/// k_n over the reduced radius (Pa), and k_s/k_n, of two spheres.
pub(super) fn between_spheres(first: &Material, second: &Material) -> (f64, f64) {
    let (a, b) = (first.young, second.young);
    (4.0 * a * b / (a + b), 0.5 * (first.stiffness_ratio + second.stiffness_ratio))
}

/// The same of a sphere on a wall.
pub(super) fn on_wall(sphere: &Material, wall: &WallMaterial) -> (f64, f64) {
    (2.0 * sphere.young * wall.young / (sphere.young + wall.young), sphere.stiffness_ratio)
}

/// The normal forces of a batch.
#[inline(always)]
pub(super) fn press<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let stiffness = batch.geometry.radii(l).reduced(parameters(l).modulus);
        terms.stiffness[l] = stiffness;
        terms.push[l] = stiffness * batch.geometry.overlap(l);
    }
}
