//! Throats between three spheres, several at once. The formulas are those of
//! [`throat`](super::throat::throat), which evaluates what is left: throats at
//! walls, and those with a sphere that reaches past the opposite edge.

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use super::angle::upper_angle;
use super::lanes::{
    LANES, Lane, Lanes, Lanes3, add, choose3, cross, dot, get, load3, norm, put, scale, store,
    store3, sub,
};
use super::throat::{SHORTEST, Throat};
use crate::Vec3;

/// The spheres and pores of the throats, by component; then their results.
pub(super) struct ThroatBatch {
    x: [[Lane; 3]; 3],
    r: [Lane; 3],
    p: [[Lane; 3]; 2],
    fluid_area: Lane,
    fluid_volume: Lane,
    solid_area: Lane,
    hydraulic_radius: Lane,
    length: Lane,
    push: [[Lane; 3]; 3],
    /// Not 0 where a sphere reaches past the opposite edge.
    reaches: Lane,
}

impl ThroatBatch {
    pub fn new() -> ThroatBatch {
        const ZERO: Lane = [0.0; LANES];
        ThroatBatch {
            x: [[ZERO; 3]; 3],
            r: [ZERO; 3],
            p: [[ZERO; 3]; 2],
            fluid_area: ZERO,
            fluid_volume: ZERO,
            solid_area: ZERO,
            hydraulic_radius: ZERO,
            length: ZERO,
            push: [[ZERO; 3]; 3],
            reaches: ZERO,
        }
    }

    /// Sets one throat: three spheres (centre and radius, m) that turn
    /// counterclockwise seen from outside the first pore, and the centres `p`
    /// of both pores.
    #[inline(always)]
    pub fn set(&mut self, l: usize, spheres: [(Vec3, f64); 3], p: [Vec3; 2]) {
        for (k, (x, r)) in spheres.into_iter().enumerate() {
            put(&mut self.x[k], l, x.into());
            self.r[k][l] = r;
        }
        for (lanes, p) in self.p.iter_mut().zip(p) {
            put(lanes, l, p.into());
        }
    }

    /// The result for one throat; `None` where a sphere reaches past the
    /// opposite edge.
    #[inline(always)]
    pub fn throat(&self, l: usize) -> Option<Throat> {
        (self.reaches[l] == 0.0).then(|| Throat {
            fluid_area: self.fluid_area[l],
            fluid_volume: self.fluid_volume[l],
            solid_area: self.solid_area[l],
            hydraulic_radius: self.hydraulic_radius[l],
            length: self.length[l],
            push: [0, 1, 2].map(|k| get(&self.push[k], l).into()),
        })
    }

    /// Evaluates all throats.
    pub fn evaluate(&mut self) {
        pulp::Arch::new().dispatch(Evaluate(self));
    }
}

/// The evaluation, compiled for each kind of vector unit.
struct Evaluate<'a>(&'a mut ThroatBatch);

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
fn evaluate<S: Simd>(simd: S, b: &mut ThroatBatch, step: usize) {
    let (zero, one, three) = (Lanes::all(simd, 0.0), Lanes::all(simd, 1.0), Lanes::all(simd, 3.0));
    let x = [load3(simd, &b.x[0], step), load3(simd, &b.x[1], step), load3(simd, &b.x[2], step)];
    let p = [load3(simd, &b.p[0], step), load3(simd, &b.p[1], step)];
    let r = load3(simd, &b.r, step);
    let area_vector = scale(0.5 * one, cross(sub(x[1], x[0]), sub(x[2], x[0])));
    let area = norm(area_vector);
    let p = separate(area_vector, area, p[0], p[1]);
    let (sectors, reaches) = sectors(x, r, area);
    let solid = [solid(x, r, p, 0), solid(x, r, p, 1), solid(x, r, p, 2)];
    let solid_area = solid[0] + solid[1] + solid[2];
    let solid_volume = dot(r, solid) / three;
    let between = sub(p[0], p[1]);
    let fluid_volume = dot(area_vector, between).abs() / three - solid_volume;
    let some = solid_area.above(zero);
    let radius = some.choose(fluid_volume / solid_area, zero);
    let fluid_area = (area - (sectors[0] + sectors[1] + sectors[2])).abs();
    let share = some.choose(fluid_area / solid_area, zero);
    let normal = scale(area.above(zero).choose(one / area, zero), area_vector);
    let (distance, shortest) = (norm(between), 2e-6 * radius);
    for k in 0..3 {
        let push = scale(share * solid[k] + sectors[k], normal);
        store3(&mut b.push[k], step, push);
    }
    store(&mut b.length, step, shortest.above(distance).choose(shortest, distance));
    store(&mut b.fluid_area, step, fluid_area);
    store(&mut b.fluid_volume, step, fluid_volume);
    store(&mut b.solid_area, step, solid_area);
    store(&mut b.hydraulic_radius, step, radius);
    store(&mut b.reaches, step, reaches);
}

/// Pore centres apart by at least [`SHORTEST`] of the throat's width.
#[inline(always)]
fn separate<S: Simd>(
    area_vector: Lanes3<S>,
    area: Lanes<S>,
    p1: Lanes3<S>,
    p2: Lanes3<S>,
) -> [Lanes3<S>; 2] {
    let shortest = SHORTEST * area.sqrt();
    let zero = Lanes::all(area.0, 0.0);
    let apart = norm(sub(p2, p1)).above_or_at(shortest).or(zero.above_or_at(area));
    let half = scale(0.5 * shortest / area, area_vector);
    let middle = scale(Lanes::all(area.0, 0.5), add(p1, p2));
    let (near, far) = (sub(middle, half), add(middle, half));
    [choose3(apart, p1, near), choose3(apart, p2, far)]
}

/// Area of each sphere's sector of the triangle, and whether (not 0) one of
/// the spheres reaches past the opposite edge.
#[inline(always)]
fn sectors<S: Simd>(x: [Lanes3<S>; 3], r: Lanes3<S>, area: Lanes<S>) -> (Lanes3<S>, Lanes<S>) {
    let edge = [sub(x[2], x[1]), sub(x[0], x[2]), sub(x[1], x[0])];
    // Products of the edges that meet in each corner.
    let at = [-dot(edge[1], edge[2]), -dot(edge[2], edge[0]), -dot(edge[0], edge[1])];
    let twice = 2.0 * area;
    let (first, second) = (upper_angle(twice, at[0]), upper_angle(twice, at[1]));
    let angle = [first, second, Lanes::all(area.0, PI) - first - second];
    let zero = Lanes::all(area.0, 0.0);
    let mut reaches = zero;
    for k in 0..3 {
        let near = (r[k] * r[k] * dot(edge[k], edge[k])).above_or_at(twice * twice);
        // The opposite edge is met between its ends: both angles there are
        // at most right.
        let (before, after) = (at[(k + 1) % 3], at[(k + 2) % 3]);
        let inside = before.above_or_at(zero).and(after.above_or_at(zero));
        reaches = near.and(inside).choose(Lanes::all(area.0, 1.0), reaches);
    }
    let half = [0.5 * r[0] * r[0], 0.5 * r[1] * r[1], 0.5 * r[2] * r[2]];
    ([half[0] * angle[0], half[1] * angle[1], half[2] * angle[2]], reaches)
}

/// Surface of sphere `k` inside the bipyramid: the solid angles of the two
/// triangles that the pores' centres span with each of the other spheres,
/// added as angles of complex numbers.
#[inline(always)]
fn solid<S: Simd>(x: [Lanes3<S>; 3], r: Lanes3<S>, p: [Lanes3<S>; 2], k: usize) -> Lanes<S> {
    let (u, v) = (sub(p[0], x[k]), sub(p[1], x[k]));
    let (c1, s1) = half_angle(sub(x[(k + 1) % 3], x[k]), u, v);
    let (c2, s2) = half_angle(sub(x[(k + 2) % 3], x[k]), u, v);
    let (c, s) = (c1 * c2 - s1 * s2, s1 * c2 + s2 * c1);
    let upper = upper_angle(s.abs(), c);
    let (zero, turn) = (Lanes::all(c.0, 0.0), Lanes::all(c.0, 2.0 * PI));
    r[k] * r[k] * (2.0 * zero.above(s).choose(turn - upper, upper))
}

/// Cosine and sine, times a length, of half the solid angle of a triangle seen
/// from the origin (Van Oosterom and Strackee 1983).
#[inline(always)]
fn half_angle<S: Simd>(a: Lanes3<S>, u: Lanes3<S>, v: Lanes3<S>) -> (Lanes<S>, Lanes<S>) {
    let (na, nu, nv) = (norm(a), norm(u), norm(v));
    let below = na * nu * nv + dot(a, u) * nv + dot(a, v) * nu + dot(u, v) * na;
    (below, dot(a, cross(u, v)).abs())
}
