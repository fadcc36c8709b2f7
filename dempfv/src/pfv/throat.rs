//! A throat: the facet shared by two pores, its fluid area, hydraulic radius,
//! conductance, and the forces that the pressure difference puts on its solids.
//!
//! The formulas are those of Chareyre et al. 2012 as used by Caulk 2020
//! (section 2.2), with walls as the exact limit of huge spheres.

use std::f64::consts::FRAC_PI_2;

use super::frame::{Frame, Vertex};
use crate::{Vec3, WallId};

/// Throats shorter than this share of their width are evaluated at this
/// length. The pores of a cospherical cluster (any regular lattice has them)
/// have one and the same centre up to round-off; without the bound round-off
/// would choose the conductance between them, and its logarithm.
pub(super) const MIN_LENGTH_PER_WIDTH: f64 = 1e-6;

/// Which walls stand still with respect to the fluid.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallFriction {
    /// Walls do not drag (YADE's default).
    pub slip: bool,
    /// Walls with an imposed pressure never drag.
    pub open: [bool; 6],
}

impl WallFriction {
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
    friction: WallFriction,
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
        if friction.drags(wall) {
            let edge = if facet.spheres == 2 {
                facet.sphere[0].1 - facet.sphere[1].1
            } else {
                facet.sphere[0].1 - p2
            };
            solid[k] = (0.5 * (p1 - p2).cross(&edge))[wall.axis()].abs();
        }
    }
    let solid_area: f64 = solid.iter().sum();
    let fluid_volume = facet.area_vector.dot(&(p1 - p2)).abs() / 3.0 - solid_volume;
    let widening = if friction.slip {
        [1.0, 0.5f64.sqrt().sqrt(), 0.5f64.sqrt()][3 - facet.spheres]
    } else {
        1.0
    };
    let hydraulic_radius =
        if solid_area > 0.0 { fluid_volume / solid_area * widening } else { 0.0 };
    let area = facet.area_vector.norm();
    let sectors = facet.sectors();
    let fluid_area = (area - sectors.iter().sum::<f64>() + facet.overlap(frame)).abs();
    Some(Throat {
        fluid_area,
        fluid_volume,
        solid_area,
        hydraulic_radius,
        length: (p1 - p2).norm().max(1e-6 * 2.0 * hydraulic_radius),
        force_coefficient: force_coefficients(
            &facet, area, fluid_area, &sectors, &solid, solid_area,
        ),
    })
}

/// Viscous part: the fluid's share of the facet, given to the facet's solids in
/// proportion to their surface in the throat. Pressure part: each sphere's own
/// sector of the facet.
fn force_coefficients(
    facet: &Facet,
    area: f64,
    fluid_area: f64,
    sectors: &[f64; 3],
    solid: &[f64; 3],
    solid_area: f64,
) -> [Vec3; 3] {
    let normal = if area > 0.0 { facet.area_vector / area } else { Vec3::zeros() };
    let mut coefficients = [Vec3::zeros(); 3];
    for k in 0..3 {
        let share = if solid_area > 0.0 { solid[k] / solid_area } else { 0.0 };
        coefficients[k] = normal * (fluid_area * share + sectors[k]);
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
