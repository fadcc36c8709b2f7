//! Pressures imposed on pores of choice, beside those of the walls.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Random, Spheres, cubic, settled, unit_box};
use dempfv::pfv::terms::PoreSource;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, ImposedPressure, PfvError, PoreSelection};
use dempfv::solver::{Backend, Cholmod, SolverError, SolverKind, Symbolic, SymmetricCsc};
use dempfv::{Vec3, WallId};

fn fluid(pressures: &[(WallId, f64)]) -> Fluid {
    let mut boundary = Boundary::default();
    for &(wall, p) in pressures {
        boundary.pressure[wall] = Some(p);
    }
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

fn flow(s: &Spheres, fluid: &Fluid, imposed: &[ImposedPressure]) -> Result<Flow, PfvError> {
    Flow::with_imposed(&s.x, &s.r, s.bounds, fluid, imposed, SolverKind::default())
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// The pores at a wall with the wall's pressure imposed on them one by one are the same as that
/// wall: pressures, forces, and what flows, to the last bit.
#[test]
fn walls_are_one_way_to_impose_pressures() {
    let s = settled();
    let mut by_wall = flow(&s, &fluid(&[(WallId::YMin, 1.0), (WallId::YMax, 0.0)]), &[]).unwrap();
    by_wall.solve_static().unwrap();
    let conditions = by_wall.operators().conditions();
    let at_wall = |wall| -> Vec<u32> {
        let pores = (0..by_wall.network().pores()).filter(|&i| conditions.wall_of(i) == Some(wall));
        pores.map(|i| i as u32).collect()
    };
    let imposed =
        |wall, pressure| ImposedPressure { pores: PoreSelection::Pores(at_wall(wall)), pressure };
    let both = [imposed(WallId::YMin, 1.0), imposed(WallId::YMax, 0.0)];
    let mut by_pore = flow(&s, &fluid(&[]), &both).unwrap();
    by_pore.solve_static().unwrap();
    assert!(bits(by_pore.pressure()) == bits(by_wall.pressure()));
    assert!(by_pore.force() == by_wall.force());
    let through = by_wall.flux();
    assert_eq!(by_pore.imposed_flux(), [through[2], through[3]]);
    assert_eq!(by_pore.flux(), [0.0; 6]);
    // No wall imposes anything, so there is no permeability between walls.
    assert!(by_pore.permeability(WallId::YMin).is_none());
}

/// An injection amid the packing: the pressure is imposed there, it is the largest anywhere (a
/// maximum principle), and what is injected leaves through the open wall, also while spheres
/// move.
#[test]
fn what_is_injected_around_a_point_leaves_through_the_walls() {
    let s = settled();
    let center = s.bounds.center();
    let radius = 0.1 * s.bounds.size().min();
    let around = PoreSelection::Around { center, radius };
    let imposed = [ImposedPressure { pores: around, pressure: 5.0 }];
    let open = fluid(&[(WallId::YMax, 0.0)]);
    let mut flow = flow(&s, &open, &imposed).unwrap();
    let centroids = flow.network().centroids(&s.x, &s.bounds).unwrap();
    let near: Vec<usize> =
        (0..centroids.len()).filter(|&i| (centroids[i] - center).norm() <= radius).collect();
    assert!(near.len() > 3);
    flow.solve_static().unwrap();
    assert!(near.iter().all(|&i| flow.pressure()[i] == 5.0));
    assert!(flow.pressure().iter().all(|p| (0.0..=5.0).contains(p)));
    let injected = flow.imposed_flux()[0];
    let left = -flow.flux()[WallId::YMax.index()];
    assert!(injected > 0.0 && (injected - left).abs() < 1e-10 * injected, "{injected} {left}");
    let mut random = Random(3);
    let v: Vec<Vec3> = s.x.iter().map(|_| 1e-6 * random.vector()).collect();
    flow.solve(&v, &[0.0; 6]).unwrap();
    let swallowed: f64 = flow.volume_rate().iter().sum();
    let entered = flow.imposed_flux()[0] + flow.flux().iter().sum::<f64>();
    assert!((entered - swallowed).abs() < 1e-10 * injected.max(swallowed.abs()));
    assert!(flow.imbalance() < 1e-10);
    // A renewed flow has the same conditions, and so has one whose spheres have moved.
    let mut again = flow.renew(&s.x, &s.r, s.bounds, &open).unwrap();
    again.solve_static().unwrap();
    assert!((again.imposed_flux()[0] - injected).abs() < 1e-9 * injected);
    again.update_geometry(&s.x, &s.bounds).unwrap();
    again.iterate(1e-10).unwrap();
    assert!((again.imposed_flux()[0] - injected).abs() < 1e-7 * injected);
}

#[test]
fn conditions_that_cannot_be_are_errors() {
    let s = cubic(3, 0.1);
    let open = fluid(&[(WallId::YMax, 0.0)]);
    let pores = |pores: &[u32]| PoreSelection::Pores(pores.to_vec());
    let nowhere = PoreSelection::Around { center: s.bounds.max + Vec3::repeat(9.0), radius: 1.0 };
    for (selection, pressure, name, entry) in [
        (pores(&[0]), f64::NAN, "imposed pressure", 0),
        (pores(&[]), 1.0, "imposed pressure", 0),
        (nowhere, 1.0, "imposed pressure", 0),
        (pores(&[0, 1_000_000]), 1.0, "selected pores", 1),
    ] {
        match flow(&s, &open, &[ImposedPressure { pores: selection, pressure }]) {
            Err(PfvError::InvalidInput { argument, index, .. }) => {
                assert_eq!((argument, index), (name, Some(entry)));
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// A pore has one pressure: what a wall, an earlier entry or a source says otherwise is refused
/// with the pore and both values; the same pressure twice is none the worse.
#[test]
fn two_pressures_of_one_pore_are_refused() {
    let s = settled();
    let open = fluid(&[(WallId::YMax, 0.0)]);
    let plain = flow(&s, &open, &[]).unwrap();
    let conditions = plain.operators().conditions();
    let number = |at_wall: bool| {
        let found =
            (0..plain.network().pores()).find(|&i| conditions.set_of(i).is_some() == at_wall);
        found.unwrap() as u32
    };
    let (wall, free) = (number(true), number(false));
    let on =
        |pore: u32, pressure| ImposedPressure { pores: PoreSelection::Pores(vec![pore]), pressure };
    for (imposed, entry, words) in [
        (vec![on(wall, 2.0)], 0, ["2 Pa on pore", "0 Pa are imposed by the wall y_max"]),
        (vec![on(free, 1.0), on(free, 3.0)], 1, ["3 Pa on pore", "1 Pa are imposed by entry 0"]),
    ] {
        match flow(&s, &open, &imposed) {
            Err(PfvError::InvalidInput { argument: "imposed pressure", index, problem }) => {
                assert_eq!(index, Some(entry));
                assert!(words.iter().all(|w| problem.contains(w)), "{problem}");
            }
            other => panic!("{:?}", other.map(|_| ())),
        }
    }
    flow(&s, &open, &[on(wall, 0.0), on(free, 1.0), on(free, 1.0)]).unwrap();
    // A flux into a pore whose pressure was imposed by choice.
    let mut imposed = flow(&s, &open, &[on(free, 1.0)]).unwrap();
    let source = PoreSource { pores: PoreSelection::Pores(vec![free]), rate: 1e-6 };
    let error = imposed.set_sources(&s.x, &[source]).unwrap_err().to_string();
    assert!(error.contains("has an imposed pressure"), "{error}");
}

/// Where walls of different pressures meet, each pore has that of one of them, and how many there
/// are is told; walls of one pressure contradict nothing.
#[test]
fn walls_of_different_pressures_are_named_where_they_meet() {
    let s = settled();
    let remarks = |pressures: &[(WallId, f64)]| {
        let flow = flow(&s, &fluid(pressures), &[]).unwrap();
        (flow.remarks().contested_pores, flow.remarks().warnings().join(" "))
    };
    let (contested, warnings) = remarks(&[(WallId::XMin, 1.0), (WallId::YMin, 2.0)]);
    assert!(contested > 0);
    let words = format!("{contested} pores touch walls of different pressures");
    assert!(warnings.contains(&words), "{warnings}");
    assert_eq!(remarks(&[(WallId::XMin, 1.0), (WallId::YMin, 1.0)]).0, 0);
}

/// Velocities that are not one per sphere, or no numbers, are refused, and so are positions.
#[test]
fn vectors_that_do_not_fit_are_errors() {
    let s = cubic(3, 0.1);
    let mut flow = flow(&s, &fluid(&[(WallId::YMax, 0.0)]), &[]).unwrap();
    let wrong = |result: Result<(), PfvError>, name: &str, entry: Option<usize>| match result {
        Err(PfvError::InvalidInput { argument, index, .. }) => {
            assert_eq!((argument, index), (name, entry));
        }
        other => panic!("{name}: {other:?}"),
    };
    let mut v = vec![Vec3::zeros(); s.x.len()];
    wrong(flow.solve(&v[1..], &[0.0; 6]), "velocity", None);
    wrong(flow.update_geometry(&s.x[1..], &s.bounds).map(|_| ()), "position", None);
    v[5].z = f64::NAN;
    wrong(flow.solve(&v, &[0.0; 6]), "velocity", Some(5));
    v[5].z = 0.0;
    wrong(flow.solve(&v, &[0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0]), "wall_velocity", Some(3));
    flow.solve(&v, &[0.0; 6]).unwrap();
}

/// Before a solve there is no permeability.
#[test]
fn a_permeability_takes_a_solve() {
    let s = Spheres { x: vec![Vec3::repeat(0.5)], r: vec![0.3], bounds: unit_box(1.0) };
    let mut flow = flow(&s, &fluid(&[(WallId::YMin, 1.0), (WallId::YMax, 0.0)]), &[]).unwrap();
    assert!(flow.permeability(WallId::YMin).is_none());
    flow.solve_static().unwrap();
    assert!(flow.permeability(WallId::YMin).is_some());
    assert!(flow.permeability(WallId::XMin).is_none());
}

/// A solver of a library user's, which counts its analyses.
#[derive(Default)]
struct Counting(AtomicUsize);

impl Backend for Counting {
    fn name(&self) -> &'static str {
        "counting"
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Cholmod.analyze(a, coordinates)
    }
}

/// A flow is solved by any backend, with the bits of the one behind it; a flow that is renewed
/// stays with it and uses its analysis again.
#[test]
fn any_backend_serves() {
    let s = cubic(5, 0.1);
    let fluid = fluid(&[(WallId::YMin, 1.0), (WallId::YMax, 0.0)]);
    let counting = Arc::new(Counting::default());
    let mut own = Flow::new(&s.x, &s.r, s.bounds, &fluid, Arc::clone(&counting)).unwrap();
    let mut cholmod = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::Cholmod).unwrap();
    own.solve_static().unwrap();
    cholmod.solve_static().unwrap();
    assert!(bits(own.pressure()) == bits(cholmod.pressure()));
    let again = own.renew(&s.x, &s.r, s.bounds, &fluid).unwrap();
    assert!(again.analysis_reused() && again.backend().name() == "counting");
    assert_eq!(counting.0.load(Ordering::Relaxed), 1);
}
