//! Vectors as contact kernels use them: three numbers, in an order of
//! operations that is the same on every processor.

/// A vector in a kernel.
pub type Vector = [f64; 3];

/// a · b
#[inline(always)]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b
#[inline(always)]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + s b
#[inline(always)]
pub fn add_scaled(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// s a
#[inline(always)]
pub fn scaled(s: f64, a: Vector) -> Vector {
    [s * a[0], s * a[1], s * a[2]]
}

/// The part of `a` normal to the unit vector `n`.
#[inline(always)]
pub fn tangential(a: Vector, n: Vector) -> Vector {
    add_scaled(a, -dot(a, n), n)
}

/// `a`, or a vector of its direction of the length `limit` where that is shorter.
#[inline(always)]
pub fn cut(a: Vector, limit: f64) -> Vector {
    let size2 = dot(a, a);
    scaled(if size2 > limit * limit { limit / size2.sqrt() } else { 1.0 }, a)
}
