//! Several numbers at once, with the operators of one. Nothing is fused, so a
//! lane holds the bits that a single number would have.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

use crate::Vec3;

/// Pores or throats evaluated at once: a few registers full.
pub(super) const LANES: usize = 8;

/// A number of each of them.
pub(super) type Lane = [f64; LANES];

/// Numbers in the lanes of a vector register.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd>(pub S, pub S::f64s);

/// A truth for each lane.
#[derive(Clone, Copy)]
pub(super) struct Mask<S: Simd>(S, S::m64s);

impl<S: Simd> Lanes<S> {
    /// The same number in each lane.
    #[inline(always)]
    pub fn all(simd: S, value: f64) -> Self {
        Lanes(simd, simd.splat_f64s(value))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Lanes(self.0, self.0.sqrt_f64s(self.1))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Lanes(self.0, self.0.abs_f64s(self.1))
    }

    #[inline(always)]
    pub fn above(self, other: Self) -> Mask<S> {
        Mask(self.0, self.0.less_than_f64s(other.1, self.1))
    }

    #[inline(always)]
    pub fn above_or_at(self, other: Self) -> Mask<S> {
        Mask(self.0, self.0.less_than_or_equal_f64s(other.1, self.1))
    }
}

impl<S: Simd> Mask<S> {
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Mask(self.0, self.0.and_m64s(self.1, other.1))
    }

    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Mask(self.0, self.0.or_m64s(self.1, other.1))
    }

    /// The first number where true, the second where not.
    #[inline(always)]
    pub fn choose(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes(self.0, self.0.select_f64s(self.1, yes.1, no.1))
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lanes(self.0, self.0.add_f64s(self.1, other.1))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lanes(self.0, self.0.sub_f64s(self.1, other.1))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lanes(self.0, self.0.mul_f64s(self.1, other.1))
    }
}

impl<S: Simd> Mul<Lanes<S>> for f64 {
    type Output = Lanes<S>;

    #[inline(always)]
    fn mul(self, other: Lanes<S>) -> Lanes<S> {
        Lanes::all(other.0, self) * other
    }
}

impl<S: Simd> Div for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Lanes(self.0, self.0.div_f64s(self.1, other.1))
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(self.0, self.0.neg_f64s(self.1))
    }
}

/// Vectors in space, by component.
pub(super) type Lanes3<S> = [Lanes<S>; 3];

#[inline(always)]
pub(super) fn add<S: Simd>(a: Lanes3<S>, b: Lanes3<S>) -> Lanes3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn sub<S: Simd>(a: Lanes3<S>, b: Lanes3<S>) -> Lanes3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn scale<S: Simd>(s: Lanes<S>, a: Lanes3<S>) -> Lanes3<S> {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline(always)]
pub(super) fn choose3<S: Simd>(mask: Mask<S>, yes: Lanes3<S>, no: Lanes3<S>) -> Lanes3<S> {
    [mask.choose(yes[0], no[0]), mask.choose(yes[1], no[1]), mask.choose(yes[2], no[2])]
}

#[inline(always)]
pub(super) fn dot<S: Simd>(a: Lanes3<S>, b: Lanes3<S>) -> Lanes<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross<S: Simd>(a: Lanes3<S>, b: Lanes3<S>) -> Lanes3<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(super) fn norm<S: Simd>(a: Lanes3<S>) -> Lanes<S> {
    dot(a, a).sqrt()
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, lane: &Lane, step: usize) -> Lanes<S> {
    Lanes(simd, S::as_simd_f64s(lane).0[step])
}

#[inline(always)]
pub(super) fn load3<S: Simd>(simd: S, lanes: &[Lane; 3], step: usize) -> Lanes3<S> {
    [load(simd, &lanes[0], step), load(simd, &lanes[1], step), load(simd, &lanes[2], step)]
}

#[inline(always)]
pub(super) fn store<S: Simd>(lane: &mut Lane, step: usize, value: Lanes<S>) {
    S::as_mut_simd_f64s(lane).0[step] = value.1;
}

#[inline(always)]
pub(super) fn store3<S: Simd>(lanes: &mut [Lane; 3], step: usize, value: Lanes3<S>) {
    store(&mut lanes[0], step, value[0]);
    store(&mut lanes[1], step, value[1]);
    store(&mut lanes[2], step, value[2]);
}

#[inline(always)]
pub(super) fn get(lanes: &[Lane; 3], l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}

#[inline(always)]
pub(super) fn put(lanes: &mut [Lane; 3], l: usize, v: &Vec3) {
    lanes[0][l] = v[0];
    lanes[1][l] = v[1];
    lanes[2][l] = v[2];
}
