//! Hard cases 5 and 6: spheres that overlap so much that throats close, pores that are shut in,
//! and few fine particles in wide pores.

mod common;

use common::{Spheres, settled, unit_box};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, PfvError};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

fn along_y() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

fn flow(s: &Spheres) -> Flow {
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &along_y(), SolverKind::default()).unwrap();
    flow.solve_static().unwrap();
    flow
}

fn permeability(s: &Spheres) -> f64 {
    flow(s).permeability(WallId::YMin).unwrap().value
}

fn grown(s: &Spheres, factor: f64) -> Spheres {
    Spheres { x: s.x.clone(), r: s.r.iter().map(|r| factor * r).collect(), bounds: s.bounds }
}

/// As all radii grow, the permeability falls without a rise, to exactly zero.
#[test]
fn permeability_falls_to_zero_as_spheres_grow() {
    let s = settled();
    let mut last = f64::INFINITY;
    for factor in [1.0, 1.02, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4, 1.5, 2.0, 10.0] {
        let k = permeability(&grown(&s, factor));
        assert!(k < last || k == 0.0, "{factor}: {k:e} after {last:e}");
        assert!(k >= 0.0, "{factor}: {k:e}");
        last = k;
    }
    assert_eq!(last, 0.0);
}

/// A lattice of spacing 1 closes where spheres cover its square faces: at r = 1/√2, or where no
/// hundredth of them is open.
#[test]
fn a_lattice_closes_where_its_faces_are_covered() {
    let lattice = |r: f64| Spheres { r: vec![r; 343], ..common::cubic(7, 0.0) };
    let mut last = f64::INFINITY;
    for r in [0.5, 0.52, 0.55, 0.58, 0.6, 0.62, 0.64] {
        let k = permeability(&lattice(r));
        assert!(k > 0.0 && k < last, "{r}: {k:e} after {last:e}");
        last = k;
    }
    for r in [0.7072, 0.75, 0.9, 1.2] {
        let closed = flow(&lattice(r));
        assert_eq!(closed.permeability(WallId::YMin).unwrap().value, 0.0, "{r}");
        let remarks = closed.network().remarks;
        assert!(remarks.closed_throats > 0, "{r}: {remarks:?}");
    }
}

/// Where throats close, what each facet passes and what its spheres carry still make up the
/// facet: in a uniform pressure no sphere is pushed.
#[test]
fn closed_throats_push_nobody_in_a_uniform_pressure() {
    for factor in [1.05, 1.15, 1.3] {
        let s = grown(&settled(), factor);
        let fluid = along_y();
        let flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
        let uniform = vec![1.0; flow.network().pores()];
        let (mut force, mut walls) = (vec![Vec3::zeros(); s.x.len()], [Vec3::zeros(); 6]);
        flow.operators().forces(&uniform, &mut force, &mut walls).unwrap();
        let r = s.r[0];
        // Of the order of π r² times the pressure, were the pressure on one side only; 5e-16 is left.
        let largest =
            force.iter().map(Vec3::norm).fold(0.0, f64::max) / (std::f64::consts::PI * r * r);
        assert!(largest < 1e-13, "{factor}: {largest}");
    }
}

/// One sphere that touches all six walls and more: its eight corner pores are shut in, with fluid
/// that has nowhere to go, so a wall that moves is refused; at rest there is an answer.
#[test]
fn a_sphere_that_closes_its_box_is_told() {
    let s = Spheres { x: vec![Vec3::repeat(0.5)], r: vec![0.72], bounds: unit_box(1.0) };
    let mut fluid = along_y();
    fluid.boundary = Boundary::default();
    fluid.boundary.pressure[WallId::XMin] = Some(3.0);
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
    let sealed = flow.operators().sealed_pores().clone();
    assert_eq!(sealed.groups.len() + sealed.filled.len(), 4, "{sealed:?}");
    flow.solve_static().unwrap();
    assert!(flow.pressure().iter().all(|&p| p == 3.0), "{:?}", flow.pressure());
    let mut walls = [0.0; 6];
    walls[WallId::XMax.index()] = -1.0;
    let moved = flow.solve(&[Vec3::zeros()], &walls);
    if sealed.groups.is_empty() {
        moved.unwrap();
    } else {
        assert!(matches!(moved, Err(PfvError::SealedPores { .. })));
    }
}

/// Fine particles that float in wide pores, a hundred in a lattice of four spheres: they do not
/// make it conduct a thousand times better. The tubes around the throats bound it.
#[test]
fn loose_fines_do_not_open_a_packing() {
    let mut random = common::Random(23);
    let coarse: Vec<Vec3> =
        [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.25, 0.75, 0.75], [0.75, 0.25, 0.75]]
            .map(Vec3::from)
            .into();
    let alone = Spheres { x: coarse.clone(), r: vec![0.25; 4], bounds: unit_box(1.0) };
    let mut both = Spheres { x: coarse.clone(), r: vec![0.25; 4], bounds: unit_box(1.0) };
    while both.x.len() < 104 {
        let x = Vec3::repeat(0.5) + 0.49 * random.vector();
        if coarse.iter().all(|c| (x - c).norm() > 0.26) {
            both.x.push(x);
            both.r.push(0.0025);
        }
    }
    let (without, with) = (permeability(&alone), flow(&both));
    let k = with.permeability(WallId::YMin).unwrap().value;
    assert!(k < 10.0 * without, "{k:e} beside {without:e}");
    assert!(with.network().remarks.tube_throats > 0);
}
