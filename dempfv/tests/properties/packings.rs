//! Packings as nobody would choose them.

use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::{Vec3, WallId};
use nalgebra::{Rotation3, Unit};
use proptest::prelude::*;

use crate::common::{Random, Spheres, unit_box};

/// How centres lie in a box of edge 1.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Anywhere.
    Random,
    /// A thousandth of the box apart, around one point.
    Clustered,
    /// Pairs, an ulp apart along one axis.
    Coincident,
    /// On a line that is along no axis.
    Collinear,
    /// In a plane that is along no axis.
    Coplanar,
    /// On a sphere, so that one point is as near to all.
    OnSphere,
    /// On a simple cubic lattice, turned.
    Lattice,
    /// Far from each other for their size.
    Isolated,
}

const SHAPES: [Shape; 8] = [
    Shape::Random,
    Shape::Clustered,
    Shape::Coincident,
    Shape::Collinear,
    Shape::Coplanar,
    Shape::OnSphere,
    Shape::Lattice,
    Shape::Isolated,
];

/// A packing to draw: how it lies, how many spheres, from which seed.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    pub shape: Shape,
    pub count: usize,
    pub seed: u64,
}

/// Any shape; few spheres as often as many.
pub fn draws() -> impl Strategy<Value = Draw> {
    let count = prop_oneof![0..5usize, 5..60usize];
    (prop::sample::select(SHAPES.to_vec()), count, any::<u64>())
        .prop_map(|(shape, count, seed)| Draw { shape, count, seed })
}

/// The seed decides everything that the draw leaves open.
pub fn packing(draw: Draw) -> Spheres {
    let mut random = Random(draw.seed);
    let (u, v) = (random.vector(), random.vector());
    let direction = Unit::try_new(u, 1e-3).unwrap_or(Vec3::x_axis());
    let across = Unit::try_new(direction.cross(&v), 1e-3).unwrap_or(Vec3::z_axis());
    let turn = Rotation3::from_axis_angle(&direction, 6.0 * random.next());
    let middle = Vec3::repeat(0.5);
    let mut x: Vec<Vec3> = vec![];
    for i in 0..draw.count {
        let place = match draw.shape {
            Shape::Random | Shape::Isolated => middle + 0.4 * random.vector(),
            Shape::Clustered => middle + 1e-3 * random.vector(),
            Shape::Coincident if i % 2 == 1 => {
                x[i - 1].map_with_location(|row, _, c| if row == 0 { c.next_up() } else { c })
            }
            Shape::Coincident => middle + 0.4 * random.vector(),
            Shape::Collinear => middle + (0.8 * random.next() - 0.4) * direction.into_inner(),
            Shape::Coplanar => {
                let [a, b] = [0.5 * random.next() - 0.25, 0.5 * random.next() - 0.25];
                middle + a * direction.into_inner() + b * across.into_inner()
            }
            Shape::OnSphere => {
                let out = Unit::try_new(random.vector(), 1e-3).unwrap_or(Vec3::y_axis());
                middle + 0.35 * out.into_inner()
            }
            Shape::Lattice => {
                let at = [i % 4, i / 4 % 4, i / 16].map(|k| k as f64 - 1.5);
                middle + 0.15 * (turn * Vec3::from(at))
            }
        };
        x.push(place);
    }
    let largest = match draw.shape {
        Shape::Clustered | Shape::Isolated => 0.01,
        Shape::Lattice => 0.075,
        _ => 0.09,
    };
    let equal = matches!(draw.shape, Shape::Lattice | Shape::OnSphere | Shape::Coincident);
    let r = x.iter().map(|_| if equal { largest } else { largest * (0.3 + 0.7 * random.next()) });
    Spheres { r: r.collect(), x, bounds: unit_box(1.0) }
}

/// The same centres with radii that leave gaps: of at most 0.45 of the way to the nearest other
/// centre. `None` where that leaves no spheres to speak of.
pub fn packing_with_gaps(draw: Draw) -> Option<Spheres> {
    let mut s = packing(draw);
    for i in 0..s.x.len() {
        let others = s.x.iter().enumerate().filter(|&(j, _)| j != i);
        let nearest = others.map(|(_, x)| (x - s.x[i]).norm()).fold(f64::INFINITY, f64::min);
        s.r[i] = s.r[i].min(0.45 * nearest);
    }
    s.r.iter().all(|&r| r > 1e-6).then_some(s)
}

/// A pressure of 1 Pa at y_min, 0 at y_max.
pub fn through_flow() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}
