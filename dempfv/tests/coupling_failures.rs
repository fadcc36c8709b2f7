//! What happens when a network cannot be built, and when a simulation ends
//! while one is being built.

mod common;
mod moving;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use dempfv::Error;
use dempfv::coupling::{Acceleration, OnFailure, RemeshMode};
use dempfv::coupling::{
    Coupled, CouplingError, NetworkBuilder, NetworkRequest, RemeshRule, StandardBuilder,
};
use dempfv::pfv::{Flow, PfvError};
use dempfv::solver::SolverError;
use moving::{DT, bits, course, every, mode, moving};

use RemeshMode::{Ahead, AtOnce, Background};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    NotPositiveDefinite,
    OutOfMemory,
    NotFinite,
    GivesUp,
    Panic,
}

/// Builds networks, but for those whose number, from 0 on, has a fault.
struct Faulty {
    builds: AtomicU64,
    fault: fn(u64) -> Option<Fault>,
}

impl Faulty {
    fn new(fault: fn(u64) -> Option<Fault>) -> Arc<Faulty> {
        Arc::new(Faulty { builds: AtomicU64::new(0), fault })
    }
}

impl NetworkBuilder for Faulty {
    fn build(
        &self,
        mut request: NetworkRequest,
        cancelled: &AtomicBool,
    ) -> Result<Option<Flow>, CouplingError> {
        match (self.fault)(self.builds.fetch_add(1, Ordering::SeqCst)) {
            Some(Fault::NotPositiveDefinite) => {
                return Err(PfvError::from(SolverError::NotPositiveDefinite { column: 17 }).into());
            }
            Some(Fault::OutOfMemory) => {
                let none = SolverError::OutOfMemory { solver: "s", phase: "factor", n: 9 };
                return Err(PfvError::from(none).into());
            }
            Some(Fault::GivesUp) => return Ok(None),
            Some(Fault::Panic) => panic!("on purpose"),
            Some(Fault::NotFinite) => request.fluid.viscosity = f64::NAN,
            None => {}
        }
        StandardBuilder.build(request, cancelled)
    }
}

/// Works until it is told to stop.
struct Endless {
    begun: AtomicBool,
}

impl NetworkBuilder for Endless {
    fn build(
        &self,
        request: NetworkRequest,
        cancelled: &AtomicBool,
    ) -> Result<Option<Flow>, CouplingError> {
        // The first network, in the foreground, is needed.
        if !self.begun.swap(true, Ordering::SeqCst) {
            return StandardBuilder.build(request, cancelled);
        }
        while !cancelled.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(None)
    }
}

fn retrying(remesh: RemeshMode) -> Acceleration {
    Acceleration { on_failure: OnFailure::Retry, ..mode(remesh) }
}

fn restored(from: &Coupled) -> Coupled {
    Coupled::from_state(from.state()).unwrap()
}

/// The third network is that of the positions at step 15 and is due at step 20.
/// Its failure stops the simulation there, with its cause and both steps. What
/// a checkpoint holds then goes on with the bits of a simulation that nothing
/// disturbed (a machine with more memory, say), and so does the next step.
#[test]
fn a_failure_stops_with_its_cause_and_its_step() {
    let third: [fn(u64) -> Option<Fault>; 5] = [
        |k| (k == 2).then_some(Fault::NotPositiveDefinite),
        |k| (k == 2).then_some(Fault::OutOfMemory),
        |k| (k == 2).then_some(Fault::NotFinite),
        |k| (k == 2).then_some(Fault::GivesUp),
        |k| (k == 2).then_some(Fault::Panic),
    ];
    let expected = course(&mut moving(3, every(10), mode(Background)), 50, DT);
    for remesh in [Ahead, Background] {
        for fault in third {
            let kind = fault(2).unwrap();
            let mut coupled = moving(3, every(10), mode(remesh));
            coupled.build_with(Faulty::new(fault));
            course(&mut coupled, 20, DT);
            let error = coupled.step(DT).unwrap_err();
            let CouplingError::Snapshot { step: 15, source } = &error else { panic!("{error:?}") };
            match (kind, &**source) {
                (Fault::NotPositiveDefinite, CouplingError::Pfv(PfvError::Solver(e))) => {
                    assert_eq!(e, &SolverError::NotPositiveDefinite { column: 17 });
                }
                (
                    Fault::OutOfMemory,
                    CouplingError::Pfv(PfvError::Solver(SolverError::OutOfMemory { .. })),
                )
                | (Fault::NotFinite, CouplingError::Pfv(_)) => {}
                (Fault::Panic, CouplingError::WorkerPanicked { what }) => {
                    assert_eq!(what, "on purpose");
                }
                (Fault::GivesUp, CouplingError::NoNetwork) => {}
                (_, other) => panic!("{kind:?}: {other:?}"),
            }
            assert!(error.to_string().contains("step 15"), "{error}");
            assert!(!Error::from(error).is_input());
            let mut again = restored(&coupled);
            assert!(course(&mut again, 30, DT) == expected[20..], "{remesh:?}, {kind:?}");
            assert!(course(&mut coupled, 30, DT) == expected[20..], "{remesh:?}, {kind:?}");
        }
    }
}

/// At once, the old network has made room when the new one fails. The state
/// knows what it was, and goes on with the same bits.
#[test]
fn a_failure_at_once_leaves_a_state_to_go_on_from() {
    let expected = course(&mut moving(3, every(10), mode(AtOnce)), 50, DT);
    let mut coupled = moving(3, every(10), mode(AtOnce));
    coupled.build_with(Faulty::new(|k| (k == 2).then_some(Fault::OutOfMemory)));
    course(&mut coupled, 20, DT);
    let error = coupled.step(DT).unwrap_err();
    assert!(
        matches!(error, CouplingError::Pfv(PfvError::Solver(SolverError::OutOfMemory { .. }))),
        "{error:?}"
    );
    let mut again = restored(&coupled);
    assert!(course(&mut again, 30, DT) == expected[20..]);
    assert!(course(&mut coupled, 30, DT) == expected[20..]);
}

/// Three builds in ten fail, one way or another. With `retry` nothing stops:
/// each failure is counted, the old network stays for another interval, and
/// the bits depend on neither threads nor who builds.
#[test]
fn with_retry_the_old_network_stays() {
    // As good as random, and the same in every run; the first must succeed.
    let fault: fn(u64) -> Option<Fault> = |k| {
        let draw = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let faults = [Fault::NotPositiveDefinite, Fault::Panic, Fault::NotFinite];
        faults.get((draw % 10) as usize).copied().filter(|_| k > 0)
    };
    let run = |remesh, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut coupled = moving(3, every(5), retrying(remesh));
            let builder = Faulty::new(fault);
            coupled.build_with(builder.clone());
            let seen = course(&mut coupled, 402, DT);
            (seen, *coupled.remesh_counts(), builder.builds.load(Ordering::SeqCst))
        })
    };
    let (expected, counts, builds) = run(Ahead, 1);
    let faults = (0..builds).filter(|&k| fault(k).is_some()).count() as u64;
    // Attempts are 5 steps apart, failed ones too.
    assert_eq!(builds, 1 + 400 / 5);
    assert_eq!((counts.failures, counts.networks), (faults, builds - faults));
    assert!(faults > 12, "{faults}");
    assert!(counts.largest_age >= 3 + 2 * 5, "{}", counts.largest_age);
    for threads in [1, 2] {
        let (seen, found, builds_there) = run(Background, threads);
        assert!(seen == expected, "{threads} threads");
        assert_eq!((found.failures, found.networks), (counts.failures, counts.networks));
        // The background works at one more when the simulation ends.
        assert!(builds_there == builds || builds_there == builds + 1);
    }
}

/// Once the strain is past its limit each step tries to remesh: once, also
/// where the time step asks for the network first.
#[test]
fn a_step_tries_once() {
    let rule = RemeshRule { interval: None, strain: Some(1e-6) };
    for remesh in [Ahead, Background] {
        let mut coupled = moving(3, rule, retrying(remesh));
        coupled.build_with(Faulty::new(|k| (k > 0).then_some(Fault::OutOfMemory)));
        for step in 0..10 {
            coupled.update_viscous_mode(false).unwrap();
            coupled.step(DT).unwrap();
            assert_eq!(coupled.remesh_counts().failures, step, "{remesh:?}");
        }
    }
}

/// Without a first network there is nothing to go on with.
#[test]
fn the_first_network_must_succeed() {
    let mut coupled = moving(3, every(5), retrying(Background));
    coupled.build_with(Faulty::new(|k| (k == 0).then_some(Fault::Panic)));
    let error = coupled.step(DT).unwrap_err();
    assert!(matches!(error, CouplingError::WorkerPanicked { .. }), "{error:?}");
    coupled.step(DT).unwrap();
    assert_eq!(coupled.remeshes(), 1);
}

/// A simulation that is dropped, drained, refilled, or unwound by a panic while
/// the background is busy ends it. (It would hang here if it did not.)
#[test]
fn the_end_does_not_wait_for_the_background() {
    let busy = || {
        let mut coupled = moving(3, every(10), mode(Background));
        coupled.build_with(Arc::new(Endless { begun: AtomicBool::new(false) }));
        course(&mut coupled, 8, DT);
        coupled
    };
    drop(busy());
    let mut coupled = busy();
    coupled.drain();
    coupled.step(DT).unwrap();
    drop(coupled);
    let mut coupled = busy();
    coupled.accelerate(mode(AtOnce));
    let before = bits(&coupled);
    coupled.build_with(Arc::new(StandardBuilder));
    course(&mut coupled, 10, DT);
    assert_ne!(bits(&coupled), before);
    let panicked = catch_unwind(AssertUnwindSafe(|| {
        let coupled = busy();
        assert!(coupled.steps() == 0, "on purpose");
    }));
    panicked.unwrap_err();
}
