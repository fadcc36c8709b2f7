//! A network takes another's place: the pressures go on, and so does the
//! analysis where the pattern is the same.

mod common;

use std::collections::HashMap;

use common::{Random, Spheres, cubic, settled};
use dempfv::coupling::{Acceleration, RemeshMode};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

/// 1 Pa below, 0 above.
fn fluid(viscosity: f64) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary }
}

fn flow(s: &Spheres, viscosity: f64) -> Flow {
    Flow::new(&s.x, &s.r, s.bounds, &fluid(viscosity), SolverKind::default()).unwrap()
}

fn renewed(old: Flow, s: &Spheres, viscosity: f64) -> Flow {
    old.renew(&s.x, &s.r, s.bounds, &fluid(viscosity)).unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn moved(s: &Spheres, by: f64) -> Spheres {
    let mut random = Random(9);
    let x = s.x.iter().zip(&s.r).map(|(x, r)| x + by * r * random.vector()).collect();
    Spheres { x, r: s.r.clone(), bounds: s.bounds }
}

/// Another viscosity is another matrix of the same pattern: no second analysis,
/// for a factor of supernodes (1,000 spheres) and for one without (125). The
/// solution has the bits of a flow that was made anew.
#[test]
fn other_conductances_take_no_second_analysis() {
    for s in [settled(), cubic(5, 0.1)] {
        let mut old = flow(&s, 1e-3);
        assert!(!old.analysis_reused());
        old.solve_static().unwrap();
        let mut again = renewed(old, &s, 2e-3);
        assert!(again.analysis_reused());
        let mut anew = flow(&s, 2e-3);
        let nothing = anew.extrapolation().clone();
        again.restore_pressures(&nothing, &[]).unwrap();
        anew.restore_pressures(&nothing, &[]).unwrap();
        again.solve_static().unwrap();
        anew.solve_static().unwrap();
        assert!(bits(again.pressure()) == bits(anew.pressure()));
        assert!(again.nnz_l() == anew.nnz_l() && again.nnz_l() > 0);
    }
}

/// Another packing has another pattern, and gets an analysis of its own.
#[test]
fn another_pattern_is_analyzed() {
    let s = cubic(5, 0.1);
    let other = moved(&s, 0.3);
    let mut again = renewed(flow(&s, 1e-3), &other, 1e-3);
    assert!(!again.analysis_reused());
    let mut anew = flow(&other, 1e-3);
    again.solve_static().unwrap();
    anew.solve_static().unwrap();
    for (a, b) in again.pressure().iter().zip(anew.pressure()) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

/// The flow through 1,000 settled spheres goes from 1 Pa to 0. After a motion of
/// 5 % of the radii, pores with the vertices of an old one start from its very
/// pressure; all others (some: that is the premise) from that of an old pore
/// that shares a sphere with them, less than a sphere's share of the drop away
/// from their own; and one solve brings all to what a flow made anew finds.
#[test]
fn pressures_are_carried_over() {
    let s = settled();
    let other = moved(&s, 0.05);
    let mut old = flow(&s, 1e-3);
    old.solve_static().unwrap();
    let sorted = |mut cell: [u32; 4]| {
        cell.sort_unstable();
        cell
    };
    let before: HashMap<[u32; 4], f64> = (old.network().tessellation.cells.iter())
        .map(|c| sorted(*c))
        .zip(old.pressure().iter().copied())
        .collect();
    let mut again = renewed(old, &other, 1e-3);
    let start = again.pressure().to_vec();
    let (mut same, mut others) = (0, 0);
    let mut anew = flow(&other, 1e-3);
    anew.solve_static().unwrap();
    for (i, cell) in again.network().tessellation.cells.iter().enumerate() {
        if again.operators().imposed(i).is_some() {
            continue;
        }
        match before.get(&sorted(*cell)) {
            Some(p) => {
                assert_eq!(start[i], *p);
                same += 1;
            }
            None => {
                let off = (start[i] - anew.pressure()[i]).abs();
                assert!(off < 0.2, "{off}");
                others += 1;
            }
        }
    }
    assert!(same > 4000 && others > 100, "{same} the same, {others} others");
    again.solve_static().unwrap();
    for (a, b) in again.pressure().iter().zip(anew.pressure()) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

/// Spheres that stand still keep their pattern. At once and ahead, ten networks
/// take one analysis, also after the viscosity has changed; in the background
/// two networks are there at a time, and each has its own.
#[test]
fn a_packing_at_rest_is_analyzed_once() {
    for (remesh, expected) in
        [(RemeshMode::AtOnce, 1), (RemeshMode::Ahead, 1), (RemeshMode::Background, 2)]
    {
        let mut s = cubic(5, 0.1);
        s.r.iter_mut().for_each(|r| *r *= 0.6);
        let material =
            Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.0, density: 2600.0 };
        let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
        let particles = Particles::new(s.x, s.r, material.density);
        let dem = Dem::new(particles, s.bounds, material, walls, DemOptions::default()).unwrap();
        let at = dem.storage().position.clone();
        let mut coupled = Coupled::new(dem);
        coupled.accelerate(Acceleration { remesh, ..Acceleration::default() });
        // No flow: both walls have the same pressure.
        let saturation = |viscosity| {
            let mut fluid = fluid(viscosity);
            fluid.boundary.pressure[WallId::YMin] = Some(0.0);
            let remesh = RemeshRule { interval: Some(5), strain: None };
            Saturation { fluid, solver: SolverKind::default(), remesh }
        };
        coupled.saturate(saturation(1e-3));
        for _ in 0..50 {
            coupled.step(1e-4).unwrap();
        }
        let counts = coupled.remesh_counts();
        assert_eq!((counts.networks, counts.analyses), (10, expected), "{remesh:?}");
        coupled.saturate(saturation(2e-3));
        coupled.step(1e-4).unwrap();
        let counts = coupled.remesh_counts();
        assert_eq!((counts.networks, counts.analyses), (11, expected), "{remesh:?}");
        // The premise.
        let still = at.iter().zip(&coupled.dem().storage().position);
        assert!(still.map(|(a, b): (&Vec3, _)| (a - b).norm()).all(|d| d == 0.0));
    }
}
