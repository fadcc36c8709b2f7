//! The contact law, stateless: numbers in, numbers out.

/// A vector as the kernels use it.
pub(super) type V = [f64; 3];

#[inline(always)]
pub(super) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + s b
#[inline(always)]
pub(super) fn add_scaled(a: V, s: f64, b: V) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline(always)]
pub(super) fn scaled(s: f64, a: V) -> V {
    [s * a[0], s * a[1], s * a[2]]
}

/// The part of `a` normal to the unit vector `n`.
#[inline(always)]
pub(super) fn tangential(a: V, n: V) -> V {
    add_scaled(a, -dot(a, n), n)
}

/// How a contact moved during the last step.
pub(super) struct Sliding {
    /// Unit normal now.
    pub normal: V,
    /// Half the change of the normal during the step.
    pub half_turn: V,
    /// Mean rotation of the two bodies about the normal during the step (rad).
    pub twist: f64,
    /// Relative tangential displacement of the second body at the contact (m).
    pub slip: V,
}

/// The shear force on the second body after a step: the old force `shear`
/// turns with the contact, grows against the slip with `stiffness` (N/m), and
/// is cut at `limit` (N).
#[inline(always)]
pub(super) fn shear_force(shear: V, motion: &Sliding, stiffness: f64, limit: f64) -> V {
    let (turned, ratio) = turn(shear, motion);
    grow(turned, ratio, scaled(stiffness, motion.slip), limit)
}

/// The direction of the shear force after the contact has turned, and the
/// square of the factor that its length lacks.
///
/// The turn takes the old normal n₀ to the new one n₁ along the shortest way:
/// s' = s − (s·n₁) m / (m·n₁), m = n₁ − (n₁ − n₀)/2, which is exact for s ⊥ n₀;
/// then s' turns about n₁ by the twist; then it gets back the length of s, so
/// that a contact carried around neither gains nor loses.
#[inline(always)]
pub(super) fn turn(shear: V, motion: &Sliding) -> (V, f64) {
    let n = motion.normal;
    let along = dot(shear, n);
    let middle = add_scaled(n, -1.0, motion.half_turn);
    let s = add_scaled(shear, -along, middle);
    let s = add_scaled(s, motion.twist, cross(n, s));
    let turned2 = dot(s, s);
    let ratio = if turned2 > 0.0 { dot(shear, shear) / turned2 } else { 0.0 };
    (s, ratio)
}

/// The shear force: `turned` with its length back, less `loss` (N) that the
/// slip takes, cut at `limit` (N).
#[inline(always)]
pub(super) fn grow(turned: V, ratio: f64, loss: V, limit: f64) -> V {
    let s = scaled(ratio.sqrt(), turned);
    let s = add_scaled(s, -1.0, loss);
    let size2 = dot(s, s);
    let share = if size2 > limit * limit { limit / size2.sqrt() } else { 1.0 };
    scaled(share, s)
}
