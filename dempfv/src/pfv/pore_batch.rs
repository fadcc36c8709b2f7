//! Pores between four spheres, several at once. The formulas are those of
//! [`Pore`](super::pore::Pore), which evaluates the pores at walls.

use pulp::{Simd, WithSimd};

use super::frame::FACETS;
use super::lanes::{
    LANES, Lane, Lanes, add, cross, dot, get, load, load3, put, scale, store, store3, sub,
};
use super::pore::{FLAT, Pore};
use crate::Vec3;

/// The spheres of the pores, by component; then the results.
pub(super) struct PoreBatch {
    x: [[Lane; 3]; 4],
    r: [Lane; 4],
    center: [Lane; 3],
    volume: Lane,
    gradient: [[Lane; 3]; 4],
    /// Not 0 where the four spheres lie in a plane.
    flat: Lane,
}

impl PoreBatch {
    pub fn new() -> PoreBatch {
        const ZERO: Lane = [0.0; LANES];
        PoreBatch {
            x: [[ZERO; 3]; 4],
            r: [ZERO; 4],
            center: [ZERO; 3],
            volume: ZERO,
            gradient: [[ZERO; 3]; 4],
            flat: ZERO,
        }
    }

    /// Sets sphere `k` of one pore (centre and radius, m); its four spheres are
    /// positively oriented.
    #[inline(always)]
    pub fn set(&mut self, l: usize, k: usize, x: &Vec3, r: f64) {
        put(&mut self.x[k], l, x);
        self.r[k][l] = r;
    }

    /// Evaluates all pores.
    pub fn evaluate(&mut self) {
        pulp::Arch::new().dispatch(Evaluate(self));
    }

    /// Whether a pore is flat: it has to be evaluated on its own.
    #[inline(always)]
    pub fn is_flat(&self, l: usize) -> bool {
        self.flat[l] != 0.0
    }

    /// The result for one pore.
    #[inline(always)]
    pub fn pore(&self, l: usize) -> Pore {
        Pore {
            center: get(&self.center, l),
            volume: self.volume[l],
            gradient: [
                get(&self.gradient[0], l),
                get(&self.gradient[1], l),
                get(&self.gradient[2], l),
                get(&self.gradient[3], l),
            ],
        }
    }
}

/// The evaluation, compiled for each kind of vector unit.
struct Evaluate<'a>(&'a mut PoreBatch);

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for step in 0..LANES / S::F64_LANES {
            evaluate(simd, self.0, step);
        }
    }
}

#[inline(always)]
fn evaluate<S: Simd>(simd: S, b: &mut PoreBatch, step: usize) {
    let x = [
        load3(simd, &b.x[0], step),
        load3(simd, &b.x[1], step),
        load3(simd, &b.x[2], step),
        load3(simd, &b.x[3], step),
    ];
    let r0 = load(simd, &b.r[0], step);
    let row = [sub(x[1], x[0]), sub(x[2], x[0]), sub(x[3], x[0])];
    let by = [cross(row[1], row[2]), cross(row[2], row[0]), cross(row[0], row[1])];
    let (zero, one) = (Lanes::all(simd, 0.0), Lanes::all(simd, 1.0));
    let mut sum = [zero; 3];
    let mut lengths2 = one;
    for k in 0..3 {
        let r = load(simd, &b.r[k + 1], step);
        let length2 = dot(row[k], row[k]);
        let rhs = 0.5 * (length2 + (r0 - r) * (r0 + r));
        sum = add(sum, scale(rhs, by[k]));
        lengths2 = lengths2 * length2;
    }
    let determinant = dot(row[0], by[0]);
    let flat = ((FLAT * FLAT) * lengths2).above_or_at(determinant * determinant);
    store(&mut b.flat, step, flat.choose(one, zero));
    let inverse = one / determinant;
    store3(&mut b.center, step, add(x[0], scale(inverse, sum)));
    let sixth = Lanes::all(simd, -1.0 / 6.0);
    let mut gradient = [sum; 4];
    for (k, [v0, v1, v2]) in FACETS.into_iter().enumerate() {
        gradient[k] = scale(sixth, cross(sub(x[v1], x[v0]), sub(x[v2], x[v0])));
        store3(&mut b.gradient[k], step, gradient[k]);
    }
    store(&mut b.volume, step, dot(gradient[0], sub(x[0], x[1])));
}
