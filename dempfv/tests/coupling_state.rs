//! A coupled system cannot be put into a wrong state, can be stored as one
//! value, and speaks of spheres by the user's numbers.

mod common;
mod moving;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use common::settled;
use dempfv::coupling::{
    Acceleration, Coupled, CoupledState, CouplingError, NetworkBuilder, NetworkRequest, RemeshMode,
    StandardBuilder, Update,
};
use dempfv::pfv::{Flow, PfvError};
use dempfv::solver::SolverError;
use dempfv::{Error, Vec3};
use moving::{DT, bits, course, dem_of, drained, every, mode, moving};

/// The largest difference of two lists over the largest entry of the first.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / largest
}

fn components(vectors: &[Vec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

/// Spheres that have flown about are sorted anew while the pores are full, in
/// the midst of an interval. The next step has the pressures, forces and
/// motions of a system that was not sorted and builds its network of the same
/// positions; a network that kept the old order would be off by tens of per cent.
#[test]
fn sorting_while_wet_changes_no_pressure() {
    for remesh in [RemeshMode::AtOnce, RemeshMode::Background] {
        let run = |sort: bool| {
            let mut coupled = moving(5, every(40), mode(remesh));
            course(&mut coupled, 130, 4.0 * DT);
            let before = coupled.dem().storage().id.clone();
            if sort {
                coupled.sort_spatially().unwrap();
                assert_ne!(coupled.dem().storage().id, before, "nothing was out of order");
            } else {
                // Another fluid and the same again: a network of these positions.
                coupled.saturate(drained(2.0, every(40)));
                coupled.saturate(drained(1.0, every(40)));
            }
            coupled.step(DT).unwrap();
            let seen = coupled.observe();
            let pressure = coupled.pressure_at_spheres();
            (
                pressure,
                coupled.fluid_force(),
                coupled.dem().positions(),
                coupled.dem().velocities(),
                seen,
            )
        };
        let (pressure, force, position, velocity, seen) = run(false);
        let (p, f, x, v, s) = run(true);
        assert!(seen.largest_pressure > 0.0);
        assert!((s.largest_pressure / seen.largest_pressure - 1.0).abs() < 1e-8);
        assert!(difference(&pressure, &p) < 1e-8, "{}", difference(&pressure, &p));
        for (there, here) in [(&force, &f), (&position, &x), (&velocity, &v)] {
            let off = difference(&components(there), &components(here));
            assert!(off < 1e-8, "{remesh:?}: {off}");
        }
    }
}

/// Lists by the user's numbers: those of storage order, put in their places.
#[test]
fn lists_are_by_the_users_numbers() {
    let spheres = settled();
    let position = spheres.x.clone();
    let mut coupled = Coupled::new(dem_of(spheres));
    assert_eq!(coupled.dem().positions(), position);
    assert_ne!(coupled.dem().storage().position, position, "storage order is another");
    assert!(coupled.fluid_force().iter().all(|f| *f == Vec3::zeros()));
    coupled.saturate(drained(1e-3, every(10)));
    // At rest nothing flows: the second step has velocities.
    course(&mut coupled, 2, 1e-6);
    let (fluid, contact, velocity) =
        (coupled.fluid_force(), coupled.dem().forces(), coupled.dem().velocities());
    let particles = coupled.dem().storage();
    let flow = coupled.storage_flow().unwrap();
    for (k, &id) in particles.id.iter().enumerate() {
        assert_eq!(fluid[id as usize], flow.force()[k]);
        assert_eq!(contact[id as usize], coupled.dem().storage_forces()[k]);
        assert_eq!(velocity[id as usize], particles.velocity[k]);
    }
    let total: Vec3 = fluid.iter().sum();
    assert!(total.norm() > 0.0);
}

/// A state of another kind or version is refused in words, and is the input's
/// fault.
#[test]
fn a_foreign_state_is_refused() {
    let mut coupled = moving(3, every(10), mode(RemeshMode::AtOnce));
    course(&mut coupled, 3, DT);
    let state = coupled.state();
    let bytes = postcard::to_stdvec(&state).unwrap();
    let kind = b"dempfv coupled state";
    // The length of the kind, the kind, the version.
    assert_eq!((bytes[0] as usize, &bytes[1..=kind.len()]), (kind.len(), &kind[..]));
    for (at, what) in [(1, "`eempfv coupled state`"), (kind.len() + 1, "version 9")] {
        let mut other = bytes.clone();
        other[at] += 1;
        let foreign: CoupledState = postcard::from_bytes(&other).unwrap();
        let error = Coupled::from_state(foreign).err().unwrap();
        assert!(matches!(error, CouplingError::ForeignState { .. }), "{error:?}");
        assert!(error.to_string().contains(what), "{error}");
        assert!(error.to_string().contains("reads `dempfv coupled state`, version 8"), "{error}");
        assert!(Error::from(error).is_input());
    }
    let again = Coupled::from_state(postcard::from_bytes(&bytes).unwrap()).unwrap();
    assert!(bits(&again) == bits(&coupled) && again.state() == state);
}

/// What a caller chooses can be chosen anew: another viscosity, twice the
/// pressure.
#[test]
fn parameters_may_change_where_a_state_is_taken_up() {
    let mut coupled = moving(3, every(10), mode(RemeshMode::AtOnce));
    course(&mut coupled, 5, DT);
    let mut state = coupled.state();
    let saturation = state.parameters.saturation.as_mut().unwrap();
    assert_eq!(saturation.fluid.viscosity, 1.0);
    saturation.fluid.viscosity = 2.0;
    let mut thicker = Coupled::from_state(state).unwrap();
    thicker.step(DT).unwrap();
    coupled.step(DT).unwrap();
    let ratio = thicker.observe().largest_pressure / coupled.observe().largest_pressure;
    assert!((ratio - 2.0).abs() < 1e-9, "{ratio}");
}

/// Whether the network follows the spheres may change too, both ways: the network goes on from the
/// positions that it was built of, or from those of the moment, and every solve still balances the
/// fluid to its tolerance (1e-11 by the factor, 1e-6 by iteration).
#[test]
fn following_may_begin_and_end_where_a_state_is_taken_up() {
    let with = |update| Acceleration { update, ..mode(RemeshMode::AtOnce) };
    for (before, after, imbalance) in
        [(Update::EveryStep, Update::Remesh, 1e-11), (Update::Remesh, Update::EveryStep, 1e-5)]
    {
        let mut coupled = moving(3, every(40), with(before));
        course(&mut coupled, 15, DT);
        let mut state = coupled.state();
        state.parameters.acceleration.update = after;
        let mut again = Coupled::from_state(state).unwrap();
        for _ in 0..10 {
            again.step(DT).unwrap();
            let seen = again.storage_flow().unwrap().imbalance();
            assert!(seen <= imbalance, "{before:?} to {after:?}: {seen}");
        }
        assert_eq!(again.remeshes(), 0, "the premise: no remesh has hidden it");
    }
}

/// Counts the networks that it builds; from the second on it fails.
struct OneOnly(AtomicU64);

impl NetworkBuilder for OneOnly {
    fn build(
        &self,
        request: NetworkRequest,
        cancelled: &AtomicBool,
    ) -> Result<Option<Flow>, CouplingError> {
        match self.0.fetch_add(1, Ordering::SeqCst) {
            0 => StandardBuilder.build(request, cancelled),
            _ => Err(PfvError::from(SolverError::NotPositiveDefinite { column: 3 }).into()),
        }
    }
}

/// A restored system takes its networks from the builder it is given.
#[test]
fn a_restored_system_builds_with_what_it_is_given() {
    let mut coupled = moving(3, every(4), mode(RemeshMode::AtOnce));
    course(&mut coupled, 2, DT);
    let builder = Arc::new(OneOnly(AtomicU64::new(0)));
    let mut again = Coupled::from_state_with(coupled.state(), builder.clone()).unwrap();
    course(&mut again, 2, DT);
    let error = again.step(DT).unwrap_err();
    assert_eq!(builder.0.load(Ordering::SeqCst), 2);
    assert!(!error.spoils_state() && error.to_string().contains("unknown 3"), "{error}");
}
