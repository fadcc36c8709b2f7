//! Throats between three spheres, several at once. The formulas are those of
//! [`throat`](super::throat::throat), which evaluates what is left: throats at
//! walls, those with a sphere that reaches past the opposite edge, and those that geometry
//! may limit.

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use super::angle::upper_angle;
use super::lanes::{
    LANES, Lane, Lanes, Lanes3, add, choose3, cross, dot, get, load3, norm, put, scale, store,
    store3, sub,
};
use super::throat::{LEAST_FLUID, MIN_LENGTH_PER_WIDTH, Throat, ThroatLimit, ThroatRules};
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
    force_coefficient: [[Lane; 3]; 3],
    /// Not 0 where a sphere reaches past the opposite edge.
    reaches: Lane,
    /// Not 0 where geometry may limit the throat.
    limited: Lane,
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
            force_coefficient: [[ZERO; 3]; 3],
            reaches: ZERO,
            limited: ZERO,
        }
    }

    /// Sets sphere `k` of one throat (centre and radius, m); its three spheres
    /// turn counterclockwise seen from outside the first pore.
    #[inline(always)]
    pub fn set_sphere(&mut self, l: usize, k: usize, x: &Vec3, r: f64) {
        put(&mut self.x[k], l, x);
        self.r[k][l] = r;
    }

    /// Sets the centre of pore `k` of one throat (m).
    #[inline(always)]
    pub fn set_pore(&mut self, l: usize, k: usize, center: &Vec3) {
        put(&mut self.p[k], l, center);
    }

    /// Whether a throat has to be evaluated on its own, under these rules: there is no result
    /// for it.
    #[inline(always)]
    pub fn is_special(&self, l: usize, rules: &ThroatRules) -> bool {
        self.reaches[l] != 0.0 || (rules.limited && self.limited[l] != 0.0)
    }

    /// Writes the result for one throat.
    #[inline(always)]
    pub fn throat(&self, l: usize, out: &mut Throat) {
        out.fluid_area = self.fluid_area[l];
        out.fluid_volume = self.fluid_volume[l];
        out.solid_area = self.solid_area[l];
        out.hydraulic_radius = self.hydraulic_radius[l];
        out.length = self.length[l];
        out.force_coefficient = [
            get(&self.force_coefficient[0], l),
            get(&self.force_coefficient[1], l),
            get(&self.force_coefficient[2], l),
        ];
        out.limit = ThroatLimit::None;
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
    let edge = [sub(x[2], x[1]), sub(x[0], x[2]), sub(x[1], x[0])];
    let (sectors, reaches) = sectors(edge, r, area);
    let solid = [solid(x, r, p, 0), solid(x, r, p, 1), solid(x, r, p, 2)];
    let solid_area = solid[0] + solid[1] + solid[2];
    let solid_volume = dot(r, solid) / three;
    let between = sub(p[0], p[1]);
    let fluid_volume = dot(area_vector, between).abs() / three - solid_volume;
    let some = solid_area.above(zero);
    let radius = some.choose(fluid_volume / solid_area, zero);
    let left = area - (sectors[0] + sectors[1] + sectors[2]);
    let fluid_area = left.abs();
    let share = some.choose(fluid_area / solid_area, zero);
    let normal = scale(area.above(zero).choose(one / area, zero), area_vector);
    let (distance, shortest) = (norm(between), 2e-6 * radius);
    let (counted_twice, tube) = limits(edge, r);
    let narrow = counted_twice.above(left);
    // With all that is counted twice open, the cones are no larger than this.
    let cones = (LEAST_FLUID / 3.0) * ((fluid_area + counted_twice) * distance);
    let wide = (fluid_area * (2.0 * radius) * (2.0 * radius)).above(tube);
    let limited = narrow.or(cones.above(fluid_volume)).or(wide);
    for k in 0..3 {
        let push = scale(share * solid[k] + sectors[k], normal);
        store3(&mut b.force_coefficient[k], step, push);
    }
    store(&mut b.length, step, shortest.above(distance).choose(shortest, distance));
    store(&mut b.fluid_area, step, fluid_area);
    store(&mut b.fluid_volume, step, fluid_volume);
    store(&mut b.solid_area, step, solid_area);
    store(&mut b.hydraulic_radius, step, radius);
    store(&mut b.reaches, step, reaches);
    store(&mut b.limited, step, limited.choose(one, zero));
}

/// More than what the sectors count twice; and less than the area of a tube around the facet and
/// its spheres times the square of its radius: its diameter is no less than the longest edge.
#[inline(always)]
fn limits<S: Simd>(edge: [Lanes3<S>; 3], r: Lanes3<S>) -> (Lanes<S>, Lanes<S>) {
    let zero = Lanes::all(r[0].0, 0.0);
    let (mut twice, mut longest) = (zero, zero);
    for k in 0..3 {
        let (a, b) = (r[(k + 1) % 3], r[(k + 2) % 3]);
        let length = norm(edge[k]);
        let depth = a + b - length;
        let width = a.above(b).choose(b, a);
        twice = depth.above(zero).choose(twice + depth * width, twice);
        longest = length.above(longest).choose(length, longest);
    }
    let upper = r[0].above(r[1]).choose(r[0], r[1]);
    let largest = r[2].above(upper).choose(r[2], upper);
    let tube = 0.5 * longest + largest;
    (twice, PI * (tube * tube) * (tube * tube))
}

/// Pore centres apart by at least [`MIN_LENGTH_PER_WIDTH`] of the throat's width.
#[inline(always)]
fn separate<S: Simd>(
    area_vector: Lanes3<S>,
    area: Lanes<S>,
    p1: Lanes3<S>,
    p2: Lanes3<S>,
) -> [Lanes3<S>; 2] {
    let shortest = MIN_LENGTH_PER_WIDTH * area.sqrt();
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
fn sectors<S: Simd>(edge: [Lanes3<S>; 3], r: Lanes3<S>, area: Lanes<S>) -> (Lanes3<S>, Lanes<S>) {
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

#[cfg(test)]
mod tests {
    use super::super::frame::Frame;
    use super::super::throat::throat;
    use super::*;

    const RULES: ThroatRules =
        ThroatRules { slip: true, open: [false; 6], limited: true, balanced: false };

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Spheres anywhere in a unit box, pore centres on both sides of the facet
    /// and on one: each lane has the size and the forces of the same throat
    /// alone, to round-off in units of the box.
    #[test]
    fn lanes_are_single_throats() {
        let mut state = 3;
        let mut evaluated = 0;
        for _ in 0..500 {
            let mut batch = ThroatBatch::new();
            let mut single = Vec::new();
            for l in 0..LANES {
                let mut point = || Vec3::from_fn(|_, _| random(&mut state));
                let (x, p) = ([point(), point(), point()], [point(), point()]);
                let r = [0; 3].map(|_| 0.15 + 0.2 * random(&mut state));
                for k in 0..3 {
                    batch.set_sphere(l, k, &x[k], r[k]);
                }
                batch.set_pore(l, 0, &p[0]);
                batch.set_pore(l, 1, &p[1]);
                let frame = Frame { x: x.to_vec(), r: &r, size: Vec3::repeat(1.0) };
                single.push(throat(&frame, RULES, [0, 1, 2], p[0], p[1]).unwrap());
            }
            batch.evaluate();
            for (l, single) in
                single.iter().enumerate().filter(|(l, _)| !batch.is_special(*l, &RULES))
            {
                let mut lane = Throat::CLOSED;
                batch.throat(l, &mut lane);
                let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
                near(lane.fluid_area, single.fluid_area);
                near(lane.fluid_volume, single.fluid_volume);
                near(lane.solid_area, single.solid_area);
                near(lane.length, single.length);
                let radius = single.hydraulic_radius;
                assert!((lane.hydraulic_radius - radius).abs() < 1e-12 * radius.abs().max(1.0));
                for k in 0..3 {
                    near((lane.force_coefficient[k] - single.force_coefficient[k]).norm(), 0.0);
                }
                evaluated += 1;
            }
        }
        assert!(evaluated > 1_000, "{evaluated} throats");
    }
}
