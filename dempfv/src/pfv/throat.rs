//! A throat: the facet shared by two pores, its fluid area, hydraulic radius,
//! conductance, and the forces that the pressure difference puts on its solids.
//!
//! The formulas are those of Chareyre et al. 2012 as used by Caulk 2020
//! (section 2.2), with walls as the exact limit of huge spheres.
//!
//! They count what two spheres cover twice, and a sphere's sector where it reaches past the
//! facet, so that they fall below zero long before spheres that overlap close the throat, and
//! where few small spheres drag, their hydraulic radius is wider than all there is. Geometry
//! sets limits to them ([`ThroatLimit`]); between these the formulas hold to the bit.

use std::f64::consts::{FRAC_PI_2, PI};

use super::frame::{Frame, Vertex};
use super::open_area::{Disc, OpenArea, Point, open_area};
use crate::{Effect, EffectKey, Family};
use crate::{Vec3, WallId};

/// What this effect says of itself.
pub const WALL_SLIP: Effect = Effect {
    name: "wall slip",
    family: Family::Fluid,
    equation: "the walls of a throat count as solid surface only where fluid sticks to them; else R_h 2^(−1/4) on one wall, 4^(−1/4) on two",
    source: "YADE's FlowEngine, option slipBoundary",
    keys: &[EffectKey { key: "slip_walls in [fluid]", unit: "", default: "true" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_network.rs, make yade-test",
};

/// Throats shorter than this share of their width are evaluated at this
/// length. The pores of a cospherical cluster (any regular lattice has them)
/// have one and the same centre up to round-off; without the bound round-off
/// would choose the conductance between them, and its logarithm.
pub(super) const MIN_LENGTH_PER_WIDTH: f64 = 1e-6;

/// Least share of the cones over the open area that is fluid.
pub(super) const LEAST_FLUID: f64 = 0.1;

/// Round-off in a fluid area that is compared with the open one.
const SAME_AREA: f64 = 1e-6;

/// What limits a throat, where the formulas leave geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThroatLimit {
    /// Nothing: the formulas hold.
    #[default]
    None,
    /// Spheres overlap so much that the formulas leave less than half of what is open: the fluid
    /// area is at least half the open area, the fluid volume a tenth of the cones between that
    /// and the two pore centres.
    Overlap,
    /// The spheres leave nothing open.
    Closed,
    /// Little drags: the throat conducts no more than a tube around the facet and its spheres.
    Tube,
}

/// Which walls stand still with respect to the fluid, and whether geometry has its say.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThroatRules {
    /// Walls do not drag (YADE's default).
    pub slip: bool,
    /// Walls with an imposed pressure never drag.
    pub open: [bool; 6],
    /// Throats keep the limits that geometry sets.
    pub limited: bool,
    /// What is pushed and what is passed make up each facet, also where a sphere reaches past the
    /// opposite edge (where the formulas count the segment beyond it as pushed, too): in a periodic
    /// cell the forces of a mean gradient then add up to what it puts on the whole volume.
    pub balanced: bool,
}

impl ThroatRules {
    fn drags(&self, wall: WallId) -> bool {
        !self.slip && !self.open[wall.index()]
    }
}

/// Everything about one throat that does not depend on the viscosity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Throat {
    /// Area left to the fluid (m²).
    pub fluid_area: f64,
    /// Fluid volume of the bipyramid between the pores (m³).
    pub fluid_volume: f64,
    /// Solid surface that drags in it (m²).
    pub solid_area: f64,
    /// Hydraulic radius (m).
    pub hydraulic_radius: f64,
    /// Distance of the pore centres (m), bounded from below.
    pub length: f64,
    /// Force per unit of pressure in the first pore on each vertex of the
    /// facet (m²); the second pore's is the opposite.
    pub force_coefficient: [Vec3; 3],
    pub limit: ThroatLimit,
}

impl Throat {
    /// A facet that nothing passes.
    pub const CLOSED: Throat = Throat {
        fluid_area: 0.0,
        fluid_volume: 0.0,
        solid_area: 0.0,
        hydraulic_radius: 0.0,
        length: 1.0,
        force_coefficient: [Vec3::new(0.0, 0.0, 0.0); 3],
        limit: ThroatLimit::Closed,
    };

    /// Conductance (m³/(Pa·s)): Poiseuille flow through the hydraulic radius.
    pub fn conductance(&self, viscosity: f64) -> f64 {
        let diameter = 2.0 * self.hydraulic_radius;
        self.fluid_area * diameter * diameter / (8.0 * viscosity * self.length)
    }
}

/// Evaluates the facet with these vertices, turning counterclockwise seen from
/// outside the first pore, between pores centred at `p1` and `p2`. `None` for
/// a facet of three walls.
pub(super) fn throat(
    frame: &Frame,
    rules: ThroatRules,
    facet: [u32; 3],
    p1: Vec3,
    p2: Vec3,
) -> Option<Throat> {
    let facet = Facet::new(frame, facet)?;
    let (p1, p2) = separate(&facet, p1, p2);
    let mut solid = [0.0; 3];
    let mut solid_volume = 0.0;
    for s in 0..facet.spheres {
        let (_, x, r) = facet.sphere[s];
        let omega = facet
            .partners(frame, s)
            .map(|q| solid_angle(q - x, p1 - x, p2 - x))
            .iter()
            .sum::<f64>();
        solid[facet.sphere[s].0] = r * r * omega;
        solid_volume += r * r * r * omega / 3.0;
    }
    for &(k, wall) in &facet.wall[..3 - facet.spheres] {
        if rules.drags(wall) {
            let edge = if facet.spheres == 2 {
                facet.sphere[0].1 - facet.sphere[1].1
            } else {
                facet.sphere[0].1 - p2
            };
            solid[k] = (0.5 * (p1 - p2).cross(&edge))[wall.axis()].abs();
        }
    }
    let solid_area: f64 = solid.iter().sum();
    let area = facet.area_vector.norm();
    let apart = (p1 - p2).norm();
    let Shares { fluid: fluid_area, spheres, mut limit } = match rules.limited {
        true => facet.shares(frame, area, rules.balanced),
        false => facet.formula_shares(frame, area),
    };
    let mut fluid_volume = facet.area_vector.dot(&(p1 - p2)).abs() / 3.0 - solid_volume;
    let cones = LEAST_FLUID * fluid_area * apart / 3.0;
    if rules.limited && fluid_volume < cones {
        (fluid_volume, limit) = (cones, limit.or(ThroatLimit::Overlap));
    }
    let widening = if rules.slip {
        [1.0, 0.5f64.sqrt().sqrt(), 0.5f64.sqrt()][3 - facet.spheres]
    } else {
        1.0
    };
    let mut hydraulic_radius =
        if solid_area > 0.0 { fluid_volume / solid_area * widening } else { 0.0 };
    let tube = facet.tube_radius(frame);
    if rules.limited && fluid_area * (2.0 * hydraulic_radius).powi(2) > PI * tube.powi(4) {
        hydraulic_radius = 0.5 * tube * tube * (PI / fluid_area).sqrt();
        limit = limit.or(ThroatLimit::Tube);
    }
    Some(Throat {
        fluid_area,
        fluid_volume,
        solid_area,
        hydraulic_radius,
        length: apart.max(1e-6 * 2.0 * hydraulic_radius),
        force_coefficient: force_coefficients(
            &facet, area, fluid_area, &spheres, &solid, solid_area,
        ),
        limit,
    })
}

/// Area times the normal of the facet with these vertices (m²), on the side from which they turn
/// counterclockwise. `None` for a facet of three walls.
pub(super) fn area_vector(frame: &Frame, facet: [u32; 3]) -> Option<Vec3> {
    Facet::new(frame, facet).map(|facet| facet.area_vector)
}

impl ThroatLimit {
    /// The first of two limits that there is.
    fn or(self, other: ThroatLimit) -> ThroatLimit {
        if self == ThroatLimit::None { other } else { self }
    }
}

/// Viscous part: the fluid's share of the facet, given to the facet's solids in
/// proportion to their surface in the throat. Pressure part: each sphere's own
/// share of the facet.
fn force_coefficients(
    facet: &Facet,
    area: f64,
    fluid_area: f64,
    spheres: &[f64; 3],
    solid: &[f64; 3],
    solid_area: f64,
) -> [Vec3; 3] {
    let normal = if area > 0.0 { facet.area_vector / area } else { Vec3::zeros() };
    let mut coefficients = [Vec3::zeros(); 3];
    for k in 0..3 {
        let share = if solid_area > 0.0 { solid[k] / solid_area } else { 0.0 };
        coefficients[k] = normal * (fluid_area * share + spheres[k]);
    }
    coefficients
}

/// Pore centres apart by at least [`MIN_LENGTH_PER_WIDTH`] of the throat's width. The line
/// between them is the radical axis, normal to the facet, so the direction is
/// known even where the distance is round-off.
fn separate(facet: &Facet, p1: Vec3, p2: Vec3) -> (Vec3, Vec3) {
    let area = facet.area_vector.norm();
    let shortest = MIN_LENGTH_PER_WIDTH * area.sqrt();
    if (p2 - p1).norm() >= shortest || area == 0.0 {
        return (p1, p2);
    }
    let middle = 0.5 * (p1 + p2);
    let half = facet.area_vector * (0.5 * shortest / area);
    (middle - half, middle + half)
}

/// How a facet is shared out.
struct Shares {
    /// Area left to the fluid (m²).
    fluid: f64,
    /// Area of the sphere at each vertex (m²); none for walls.
    spheres: [f64; 3],
    limit: ThroatLimit,
}

/// The facet's spheres and walls, with their places among its three vertices.
struct Facet {
    sphere: [(usize, Vec3, f64); 3],
    spheres: usize,
    wall: [(usize, WallId); 2],
    /// Area times the normal that points out of the first pore (m²): triangle,
    /// trapezoid (two spheres and their projections) or rectangle.
    area_vector: Vec3,
}

impl Facet {
    fn new(frame: &Frame, vertices: [u32; 3]) -> Option<Facet> {
        let mut sphere = [(0, Vec3::zeros(), 0.0); 3];
        let mut wall = [(0, WallId::XMin); 2];
        let (mut spheres, mut walls) = (0, 0);
        for (k, v) in vertices.into_iter().enumerate() {
            match frame.vertex(v) {
                Vertex::Sphere { x, r } => {
                    sphere[spheres] = (k, x, r);
                    spheres += 1;
                }
                Vertex::Wall(w) if walls < 2 => {
                    wall[walls] = (k, w);
                    walls += 1;
                }
                Vertex::Wall(_) => return None,
            }
        }
        let mut facet = Facet { sphere, spheres, wall, area_vector: Vec3::zeros() };
        facet.area_vector = facet.area_vector(frame);
        Some(facet)
    }

    fn area_vector(&self, frame: &Frame) -> Vec3 {
        let [(ka, a, _), (kb, b, _), (_, c, _)] = self.sphere;
        let [(k1, w1), (k2, w2)] = self.wall;
        let outward = |w: WallId| -w.inward_normal();
        match self.spheres {
            3 => 0.5 * (b - a).cross(&(c - a)),
            2 => {
                let height = 0.5 * (frame.distance(w1, &a) + frame.distance(w1, &b));
                let turns = (kb + 3 - ka) % 3 == 1;
                let along = if turns { b - a } else { a - b };
                height * along.cross(&outward(w1))
            }
            _ => {
                let turns = (k2 + 3 - k1) % 3 == 1;
                let normal = outward(w1).cross(&outward(w2));
                let area = frame.distance(w1, &a) * frame.distance(w2, &a);
                if turns { area * normal } else { -area * normal }
            }
        }
    }

    /// The other two vertices as seen from a sphere: centres, or the sphere's
    /// own projections on the walls.
    fn partners(&self, frame: &Frame, s: usize) -> [Vec3; 2] {
        let x = self.sphere[s].1;
        match self.spheres {
            3 => [self.sphere[(s + 1) % 3].1, self.sphere[(s + 2) % 3].1],
            2 => [self.sphere[1 - s].1, frame.project(self.wall[0].1, &x)],
            _ => [frame.project(self.wall[0].1, &x), frame.project(self.wall[1].1, &x)],
        }
    }

    /// Directions from a sphere to the other two vertices.
    fn directions(&self, s: usize) -> [Vec3; 2] {
        let x = self.sphere[s].1;
        match self.spheres {
            3 => [self.sphere[(s + 1) % 3].1 - x, self.sphere[(s + 2) % 3].1 - x],
            2 => [self.sphere[1 - s].1 - x, -self.wall[0].1.inward_normal()],
            _ => [-self.wall[0].1.inward_normal(), -self.wall[1].1.inward_normal()],
        }
    }

    /// Area of each vertex's circular sector of the facet; none for walls.
    fn sectors(&self) -> [f64; 3] {
        let mut sectors = [0.0; 3];
        for s in 0..self.spheres {
            let (k, _, r) = self.sphere[s];
            let angle = if self.spheres == 1 {
                FRAC_PI_2
            } else {
                let [a, b] = self.directions(s);
                a.cross(&b).norm().atan2(a.dot(&b))
            };
            sectors[k] = 0.5 * r * r * angle;
        }
        sectors
    }

    /// What the sectors count twice where a sphere reaches past the opposite
    /// edge: the circular segment beyond it. The first such sphere counts.
    fn overlap(&self, frame: &Frame) -> f64 {
        for s in 0..self.spheres {
            let (_, x, r) = self.sphere[s];
            let Some((from, to)) = self.opposite_edge(frame, s) else { continue };
            let edge = to - from;
            let length2 = edge.norm_squared();
            let along = (x - from).dot(&edge);
            if !(0.0..=length2).contains(&along) {
                continue;
            }
            let squared = ((x - from) - edge * (along / length2)).norm_squared();
            if squared < r * r {
                let m = squared.sqrt();
                let angle = 2.0 * (m / r).acos();
                let chord = 2.0 * (r * r - squared).sqrt();
                return 0.5 * (angle * r * r - chord * m);
            }
        }
        0.0
    }

    /// The shares by the formulas alone.
    fn formula_shares(&self, frame: &Frame, area: f64) -> Shares {
        let sectors = self.sectors();
        let fluid = (area - sectors.iter().sum::<f64>() + self.overlap(frame)).abs();
        Shares { fluid, spheres: sectors, limit: ThroatLimit::None }
    }

    /// The fluid's area and each sphere's: their sectors, unless these overlap too much.
    fn shares(&self, frame: &Frame, area: f64, balanced: bool) -> Shares {
        let sectors = self.sectors();
        let reached = self.overlap(frame);
        let fluid = area - sectors.iter().sum::<f64>() + reached;
        if reached == 0.0 && fluid >= self.counted_twice(frame) {
            return Shares { fluid, spheres: sectors, limit: ThroatLimit::None };
        }
        let OpenArea { open, covered } = self.open_area(frame);
        let holds = 0.5 * open <= fluid && fluid <= (1.0 + SAME_AREA) * open;
        if holds && !(balanced && reached > 0.0) {
            return Shares { fluid, spheres: sectors, limit: ThroatLimit::None };
        }
        let fluid = if holds { fluid } else { fluid.clamp(0.5 * open, open) };
        // What is pushed and what is passed make up the facet.
        let scale = if area > open { (area - fluid) / (area - open) } else { 0.0 };
        let mut spheres = [0.0; 3];
        for (s, covered) in covered.into_iter().enumerate().take(self.spheres) {
            spheres[self.sphere[s].0] = scale * covered;
        }
        let limit = match open > 0.0 {
            true if holds => ThroatLimit::None,
            true => ThroatLimit::Overlap,
            false => ThroatLimit::Closed,
        };
        Shares { fluid, spheres, limit }
    }

    /// More than what sectors count twice or beyond a wall: the depth of each overlap times its
    /// width.
    fn counted_twice(&self, frame: &Frame) -> f64 {
        let mut most = 0.0;
        for s in 0..self.spheres {
            let (_, x, r) = self.sphere[s];
            for (_, y, q) in &self.sphere[s + 1..self.spheres] {
                most += (r + q - (x - y).norm()).max(0.0) * r.min(*q);
            }
            for &(_, wall) in &self.wall[..3 - self.spheres] {
                most += 2.0 * r * (r - frame.distance(wall, &x)).max(0.0);
            }
        }
        most
    }

    /// What the spheres leave open of the facet, exactly.
    fn open_area(&self, frame: &Frame) -> OpenArea {
        let disc = |s: usize, center: Point| Disc { center, radius: self.sphere[s].2 };
        let [(_, a, _), (_, b, _), (_, c, _)] = self.sphere;
        let [(_, w1), (_, w2)] = self.wall;
        match self.spheres {
            3 => {
                let (along, up) = (b - a, c - a);
                let length = along.norm();
                let x = if length > 0.0 { up.dot(&along) / length } else { 0.0 };
                let y = (up.norm_squared() - x * x).max(0.0).sqrt();
                let corner = [[0.0, 0.0], [length, 0.0], [x, y]];
                open_area(&corner, &[disc(0, corner[0]), disc(1, corner[1]), disc(2, corner[2])])
            }
            2 => {
                let (ha, hb) = (frame.distance(w1, &a), frame.distance(w1, &b));
                let length = self.along_wall(w1);
                let (a, b) = ([0.0, ha], [length, hb]);
                open_area(&[[0.0, 0.0], [length, 0.0], b, a], &[disc(0, a), disc(1, b)])
            }
            _ => {
                let (d1, d2) = (frame.distance(w1, &a), frame.distance(w2, &a));
                let corner = [[0.0, 0.0], [d1, 0.0], [d1, d2], [0.0, d2]];
                open_area(&corner, &[disc(0, corner[0])])
            }
        }
    }

    /// Distance of the first two spheres along a wall.
    fn along_wall(&self, wall: WallId) -> f64 {
        let mut along = self.sphere[1].1 - self.sphere[0].1;
        along[wall.axis()] = 0.0;
        along.norm()
    }

    /// Radius of a tube around the facet, with its mirror images behind walls, and its spheres.
    fn tube_radius(&self, frame: &Frame) -> f64 {
        let [(_, a, ra), (_, b, rb), (_, c, rc)] = self.sphere;
        let [(_, w1), (_, w2)] = self.wall;
        match self.spheres {
            3 => {
                let edge = [(c - b), (a - c), (b - a)].map(|edge| edge.norm_squared());
                let (sum, longest) = (edge.iter().sum::<f64>(), edge[0].max(edge[1]).max(edge[2]));
                // The smallest circle: over the longest edge, or through all three corners.
                let around = if 2.0 * longest >= sum {
                    0.25 * longest
                } else {
                    edge.iter().product::<f64>() / (16.0 * self.area_vector.norm_squared())
                };
                around.sqrt() + ra.max(rb).max(rc)
            }
            2 => {
                let height = frame.distance(w1, &a).max(frame.distance(w1, &b));
                (0.5 * self.along_wall(w1)).hypot(height) + ra.max(rb)
            }
            _ => frame.distance(w1, &a).hypot(frame.distance(w2, &a)) + ra,
        }
    }

    /// The edge of the facet that a sphere may reach past; between a sphere and
    /// a wall it ends at the sphere's projection.
    fn opposite_edge(&self, frame: &Frame, s: usize) -> Option<(Vec3, Vec3)> {
        match self.spheres {
            3 => Some((self.sphere[(s + 1) % 3].1, self.sphere[(s + 2) % 3].1)),
            2 => {
                let other = self.sphere[1 - s].1;
                Some((other, frame.project(self.wall[0].1, &other)))
            }
            _ => None,
        }
    }
}

/// Solid angle of the triangle `a`, `b`, `c` seen from the origin, without its
/// sign (Van Oosterom and Strackee 1983).
fn solid_angle(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let (na, nb, nc) = (a.norm(), b.norm(), c.norm());
    let triple = a.dot(&b.cross(&c));
    let below = na * nb * nc + a.dot(&b) * nc + a.dot(&c) * nb + b.dot(&c) * na;
    2.0 * triple.abs().atan2(below)
}
