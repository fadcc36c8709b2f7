//! Sources of fluid in pores of choice: the first term in the balance of the pores.

mod common;

use common::{Spheres, settled};
use dempfv::pfv::terms::{PoreSource, Sources};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, PfvError, PoreSelection};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

/// A rate (m³/s) that makes pressures of some Pa here.
const RATE: f64 = 1e-6;

/// The settled packing, drained at the top alone.
fn drained() -> (Spheres, Flow) {
    let s = settled();
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::Cholmod).unwrap();
    (s, flow)
}

fn into_pore(pore: u32, rate: f64) -> PoreSource {
    PoreSource { pores: PoreSelection::Pores(vec![pore]), rate }
}

/// What enters leaves through the open wall: fluid mass, to the tolerance of a solve (1e-11).
/// The pores themselves do not grow.
#[test]
fn what_enters_leaves_through_the_open_wall() {
    let (s, mut flow) = drained();
    let bottom = s.bounds.min + Vec3::new(0.5, 0.0, 0.5).component_mul(&s.bounds.size());
    let pores = PoreSelection::Around { center: bottom, radius: 0.3 * s.bounds.size().y };
    flow.set_sources(&s.x, &[PoreSource { pores, rate: RATE }]).unwrap();
    assert_eq!(flow.terms().collect::<Vec<_>>(), [Sources::NAME]);
    flow.solve_static().unwrap();
    let flux = flow.flux();
    assert!((flux[WallId::YMax.index()] + RATE).abs() < 1e-10 * RATE, "{flux:?}");
    assert!(flow.imbalance() < 1e-11 && flow.volume_rate().iter().all(|v| *v == 0.0));
    assert!(flow.pressure().iter().all(|p| *p >= 0.0));

    // Taken out again, nothing flows.
    assert!(flow.remove_term(Sources::NAME) && !flow.remove_term(Sources::NAME));
    flow.solve_static().unwrap();
    assert!(flow.flux()[WallId::YMax.index()].abs() < 1e-10 * RATE);
}

/// Sources come on top of the motion of the spheres: the system is linear. The sum of both
/// pressures is that of both at once, to 1e-9 of the largest.
#[test]
fn sources_and_motion_add_up() {
    let (s, mut flow) = drained();
    let free = (0..).find(|&i| flow.operators().imposed(i).is_none()).unwrap() as u32;
    let velocity: Vec<Vec3> = s.x.iter().map(|x| -1e-6 * x).collect();
    let mut solve = |velocity: &[Vec3], sources: &[PoreSource]| {
        flow.set_sources(&s.x, sources).unwrap();
        flow.solve(velocity, &[0.0; 6]).unwrap();
        assert!(flow.imbalance() < 1e-11);
        flow.pressure().to_vec()
    };
    let rest = vec![Vec3::zeros(); s.x.len()];
    let moved = solve(&velocity, &[]);
    let fed = solve(&rest, &[into_pore(free, RATE)]);
    let both = solve(&velocity, &[into_pore(free, 0.25 * RATE), into_pore(free, 0.75 * RATE)]);
    let largest = both.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    for ((a, b), sum) in moved.iter().zip(&fed).zip(&both) {
        assert!((a + b - sum).abs() < 1e-9 * largest);
    }
}

/// Reciprocity of a symmetric network: the pressure in pore j by a source in pore i is that in
/// i by the same source in j.
#[test]
fn a_source_and_its_effect_may_change_places() {
    let (s, mut flow) = drained();
    let is_free = |i: &u32| flow.operators().imposed(*i as usize).is_none();
    let free: Vec<u32> = (0..flow.network().pores() as u32).filter(is_free).collect();
    let (i, j) = (free[free.len() / 7], free[free.len() / 2]);
    let mut at = |source: u32, probe: u32| {
        flow.set_sources(&s.x, &[into_pore(source, RATE)]).unwrap();
        flow.solve_static().unwrap();
        flow.pressure()[probe as usize]
    };
    let (there, back) = (at(i, j), at(j, i));
    assert!(there > 0.0 && (there / back - 1.0).abs() < 1e-9, "{there} {back}");
}

/// Sources that cannot be are refused with their number and what would be right.
#[test]
fn sources_that_cannot_be_are_refused() {
    let (s, mut flow) = drained();
    let pores = flow.network().pores() as u32;
    let imposed = (0..pores).find(|&i| flow.operators().imposed(i as usize).is_some()).unwrap();
    let free = (0..pores).find(|&i| flow.operators().imposed(i as usize).is_none()).unwrap();
    let nowhere = PoreSelection::Around { center: Vec3::repeat(-9.0), radius: 0.1 };
    for (wrong, says) in [
        (into_pore(free, f64::NAN), "finite"),
        (into_pore(pores, RATE), "of a network of"),
        (into_pore(imposed, RATE), "has an imposed pressure"),
        (PoreSource { pores: nowhere, rate: RATE }, "selects no pore"),
    ] {
        let error = flow.set_sources(&s.x, &[into_pore(free, RATE), wrong]).unwrap_err();
        let PfvError::InvalidInput { argument: "sources", index: Some(1), problem } = &error else {
            panic!("{error:?}")
        };
        assert!(problem.contains(says), "{problem}");
    }
    assert!(flow.set_sources(&s.x[1..], &[]).is_err());
    assert_eq!(flow.terms().count(), 0);
}
