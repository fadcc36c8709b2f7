//! How a vector across a contact follows the contact as it turns.

use super::geometry::Sliding;
use super::vector::{Vector, add_scaled, cross, dot, scaled};

/// The direction of the shear force after the contact has turned, and the
/// square of the factor that its length lacks.
///
/// The turn takes the old normal n₀ to the new one n₁ along the shortest way:
/// s' = s − (s·n₁) m / (m·n₁), m = n₁ − (n₁ − n₀)/2, which is exact for s ⊥ n₀;
/// then s' turns about n₁ by the twist; then it gets back the length of s, so
/// that a contact carried around neither gains nor loses.
#[inline(always)]
pub(super) fn turn(shear: Vector, motion: &Sliding) -> (Vector, f64) {
    let n = motion.normal;
    let along = dot(shear, n);
    let middle = add_scaled(n, -1.0, motion.half_turn);
    let s = add_scaled(shear, -along, middle);
    let s = add_scaled(s, motion.twist, cross(n, s));
    let turned2 = dot(s, s);
    let ratio = if turned2 > 0.0 { dot(shear, shear) / turned2 } else { 0.0 };
    (s, ratio)
}

/// The vector after the contact has turned, as long as before.
pub(in crate::dem) fn turned(shear: Vector, motion: &Sliding) -> Vector {
    let (direction, ratio) = turn(shear, motion);
    scaled(ratio.sqrt(), direction)
}
