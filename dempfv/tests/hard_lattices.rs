//! Hard case 1: perfect lattices in any orientation. Their pores are spheres' centres in a
//! plane, or more than four on a sphere; the triangulation splits these one way or the other.

mod common;

use common::{Random, Spheres, unit_box};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};
use nalgebra::{Rotation3, Unit};

/// Turns of each lattice that are tried.
fn turns() -> usize {
    std::env::var("DEMPFV_TURNS").ok().and_then(|n| n.parse().ok()).unwrap_or(25)
}

/// Lattice vectors and the places within a cell; nearest neighbours are 1 apart.
struct Lattice {
    name: &'static str,
    vectors: [Vec3; 3],
    places: &'static [[f64; 3]],
}

fn lattices() -> [Lattice; 4] {
    let cubic = |edge: f64| {
        [Vec3::new(edge, 0.0, 0.0), Vec3::new(0.0, edge, 0.0), Vec3::new(0.0, 0.0, edge)]
    };
    let hexagonal = [
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(0.5, 0.75f64.sqrt(), 0.0),
        Vec3::new(0.0, 0.0, (8.0f64 / 3.0).sqrt()),
    ];
    [
        Lattice { name: "simple cubic", vectors: cubic(1.0), places: &[[0.0; 3]] },
        Lattice {
            name: "body-centred cubic",
            vectors: cubic((4.0f64 / 3.0).sqrt()),
            places: &[[0.0; 3], [0.5; 3]],
        },
        Lattice {
            name: "face-centred cubic",
            vectors: cubic(2f64.sqrt()),
            places: &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
        },
        Lattice {
            name: "hexagonal",
            vectors: hexagonal,
            places: &[[0.0; 3], [1.0 / 3.0, 1.0 / 3.0, 0.5]],
        },
    ]
}

/// A turned lattice cut to a box of edge 6: spheres of radius 0.4 that keep within it.
fn cut(lattice: &Lattice, turn: Rotation3<f64>) -> Spheres {
    let (edge, r) = (6.0, 0.4);
    let mut x = vec![];
    for i in -9..=9 {
        for j in -9..=9 {
            for k in -9..=9 {
                for place in lattice.places {
                    let at = [i, j, k].map(f64::from);
                    let c: Vec3 = (0..3).map(|a| (at[a] + place[a]) * lattice.vectors[a]).sum();
                    let c = turn * c + Vec3::repeat(0.5 * edge);
                    if c.iter().all(|&c| (r..=edge - r).contains(&c)) {
                        x.push(c);
                    }
                }
            }
        }
    }
    Spheres { r: vec![r; x.len()], x, bounds: unit_box(edge) }
}

/// Permeability along y, and how many pores are flat or inside out.
fn permeability(s: &Spheres) -> (f64, [u32; 2]) {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
    flow.solve_static().unwrap();
    let remarks = flow.network().remarks;
    let k = flow.permeability(WallId::YMin).unwrap().value;
    (k, [remarks.flat_pores, remarks.inverted_pores])
}

fn jittered(s: &Spheres, random: &mut Random) -> Spheres {
    let x = s.x.iter().map(|x| x + 1e-6 * random.vector()).collect();
    Spheres { x, r: s.r.clone(), bounds: s.bounds }
}

/// Every turned lattice runs, and its permeability is that of its copy with each sphere moved by
/// a millionth of the spacing: what round-off makes of a cell with several ways to be split does
/// not show. Promised is 0.1 %. Of 100 turns of each, simple, body- and face-centred cubic ones
/// are within 1e-6 of the mean of four copies, hexagonal ones, with distances of no round number,
/// within 5e-5: 1e-4 has twice that.
#[test]
fn turned_lattices_are_their_jittered_copies() {
    let mut random = Random(17);
    for lattice in lattices() {
        for turn in 0..turns() {
            let axis = Unit::new_normalize(random.vector());
            let turn_by = match turn {
                0 => Rotation3::identity(),
                _ => Rotation3::from_axis_angle(&axis, std::f64::consts::PI * random.next()),
            };
            let s = cut(&lattice, turn_by);
            let (k, [_, inverted]) = permeability(&s);
            let copies: Vec<f64> =
                (0..4).map(|_| permeability(&jittered(&s, &mut random)).0).collect();
            let mean = copies.iter().sum::<f64>() / 4.0;
            let off = (k / mean - 1.0).abs();
            assert!(off < 1e-4, "{} turn {turn}: {k:e}, copies {copies:?}", lattice.name);
            assert_eq!(inverted, 0, "{} turn {turn}", lattice.name);
        }
    }
}

/// A lattice along the axes has the same permeability along each of them, though its cells are
/// split as it comes: within 1e-5, ten times what the shortest throats leave.
#[test]
fn a_cube_of_spheres_has_one_permeability() {
    let s = common::cubic(6, 0.0);
    let along = |axis: usize| {
        let x = s.x.iter().map(|x| Vec3::new(x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]));
        let moved = Spheres { x: x.collect(), r: vec![0.45; s.r.len()], bounds: s.bounds };
        permeability(&moved).0
    };
    let k = [0, 1, 2].map(along);
    assert!((k[1] / k[0] - 1.0).abs() < 1e-5 && (k[2] / k[0] - 1.0).abs() < 1e-5, "{k:?}");
}

/// A packing that lies some hundred boxes away from the origin is the same.
#[test]
fn a_lattice_far_away_is_the_same() {
    let s = common::cubic(4, 0.0);
    let shift = Vec3::new(1e3, -2e3, 4e3);
    let moved = Spheres {
        x: s.x.iter().map(|x| x + shift).collect(),
        r: s.r.clone(),
        bounds: Aabb { min: s.bounds.min + shift, max: s.bounds.max + shift },
    };
    let (near, far) = (permeability(&s).0, permeability(&moved).0);
    assert!((far / near - 1.0).abs() < 1e-9, "{near:e} {far:e}");
}
