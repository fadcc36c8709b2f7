//! Networks that are built ahead of time, in the foreground or in the
//! background, come into use when they should and change no bit by who built
//! them.

mod common;
mod moving;

use common::settled;
use dempfv::coupling::{Acceleration, RemeshMode, Swap};
use dempfv::coupling::{Coupled, RemeshRule};
use dempfv::dem::WallControl;
use dempfv::{Vec3, WallId};
use moving::{DT, bits, course, dem_of, drained, every, mode, moving};

use RemeshMode::{Ahead, AtOnce, Background};

fn with_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

fn strain(share: f64) -> RemeshRule {
    RemeshRule { interval: None, strain: Some(share) }
}

/// The plain path with the same swap points is `Ahead`: everything at once
/// (background, parallel tasks) has its bits after every step, for any number
/// of threads. Spheres move by a radius in 1,000 steps, so most networks differ
/// from the ones before: 100 steps at an interval of 7 take 14 of them.
#[test]
fn the_background_changes_no_bit() {
    let both = RemeshRule { interval: Some(40), strain: Some(0.1) };
    for (rule, least) in [
        (every(1), 100),
        (every(2), 50),
        (every(7), 14),
        (every(40), 3),
        (strain(0.1), 10),
        (both, 10),
    ] {
        let mut ahead = moving(4, rule, mode(Ahead));
        let expected = course(&mut ahead, 100, DT);
        let networks = ahead.remeshes();
        assert!(networks >= least, "{rule:?}: {networks} networks");
        for (threads, parallel_tasks) in [(1, false), (2, true), (3, true)] {
            let all = Acceleration { parallel_tasks, ..mode(Background) };
            let (seen, found) = with_threads(threads, || {
                let mut coupled = moving(4, rule, all);
                (course(&mut coupled, 100, DT), coupled.remeshes())
            });
            let other = seen.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!(other, None, "{rule:?}, {threads} threads");
            assert_eq!(found, networks);
        }
        // The premise: positions of another moment are another simulation,
        // where the network is not built of those of the moment anyway.
        let at_once = course(&mut moving(4, rule, mode(AtOnce)), 100, DT);
        assert_ne!(at_once, expected, "{rule:?}");
    }
}

/// 1,000 spheres with 5,685 pores: their factor is made of supernodes, so the
/// BLAS works in the background and in the foreground at the same time.
#[test]
fn the_blas_serves_both_threads() {
    let start = |acceleration| {
        let mut dem = dem_of(settled());
        dem.set_control(WallId::YMax, WallControl::Velocity(-1e-2)).unwrap();
        let mut coupled = Coupled::new(dem);
        coupled.saturate(drained(1e-3, every(8)));
        coupled.accelerate(acceleration);
        coupled
    };
    let expected = course(&mut start(mode(Ahead)), 60, 1e-6);
    let all = Acceleration { parallel_tasks: true, ..mode(Background) };
    for _ in 0..3 {
        let mut coupled = start(all);
        assert!(course(&mut coupled, 60, 1e-6) == expected);
        assert_eq!(coupled.remesh_counts().networks, 8);
    }
}

/// Tasks beside each other have the bits of one after the other, with every
/// way to remesh.
#[test]
fn parallel_tasks_change_no_bit() {
    for remesh in [AtOnce, Ahead] {
        let plain = course(&mut moving(4, every(10), mode(remesh)), 60, DT);
        for threads in [1, 2, 3] {
            let tasks = Acceleration { parallel_tasks: true, ..mode(remesh) };
            let seen = with_threads(threads, || course(&mut moving(4, every(10), tasks), 60, DT));
            assert!(seen == plain, "{remesh:?}, {threads} threads");
        }
    }
}

/// Whoever looks at the viscous mode before a step, as the automatic time step
/// does, finds the network that the step uses: nothing is built twice, and no
/// bit changes.
#[test]
fn a_look_at_the_viscous_mode_changes_no_bit() {
    for remesh in [AtOnce, Ahead, Background] {
        for rule in [every(1), every(7), strain(0.1)] {
            for parallel_tasks in [false, true] {
                let how = Acceleration { parallel_tasks, ..mode(remesh) };
                let mut plain = moving(3, rule, how);
                let mut looking = moving(3, rule, how);
                for step in 0..40 {
                    plain.step(DT).unwrap();
                    let renewed = looking.update_viscous_mode(false).unwrap();
                    assert!(!looking.update_viscous_mode(false).unwrap());
                    looking.step(DT).unwrap();
                    let at = format!("{remesh:?}, {rule:?}, tasks {parallel_tasks}, step {step}");
                    assert!(bits(&looking) == bits(&plain), "{at}");
                    assert_eq!(looking.remeshes(), plain.remeshes(), "{at}");
                    assert_eq!(looking.network_age(), plain.network_age(), "{at}");
                    assert!(renewed || rule != every(1) || step == 0, "{at}");
                    assert!(looking.viscous_mode().is_some() && plain.viscous_mode().is_none());
                }
            }
        }
    }
}

/// With an interval of 10, positions are taken after 5 steps and their network
/// is in use from 10 to 19: it is 15 steps old when it is replaced. At once, it
/// is 10. With an interval of 1, positions of each step serve the next but one.
#[test]
fn networks_are_as_old_as_the_interval_says() {
    let ages = |interval, remesh| {
        let mut coupled = moving(3, every(interval), mode(remesh));
        let ages: Vec<u64> = (0..40)
            .map(|_| {
                coupled.step(DT).unwrap();
                coupled.network_age()
            })
            .collect();
        (ages, *coupled.remesh_counts())
    };
    let (at_once, counts) = ages(10, AtOnce);
    assert_eq!(at_once[8..12], [9, 10, 1, 2]);
    assert_eq!((counts.swaps, counts.largest_age, counts.mean_age()), (3, 10, Some(10.0)));
    for remesh in [Ahead, Background] {
        let (ages, counts) = ages(10, remesh);
        assert_eq!(ages[8..12], [9, 10, 6, 7], "{remesh:?}");
        assert_eq!(ages[18..22], [14, 15, 6, 7], "{remesh:?}");
        assert_eq!((counts.swaps, counts.largest_age), (3, 15));
        assert_eq!(counts.total_age, 10 + 15 + 15);
    }
    let (each, _) = ages(1, Background);
    assert_eq!(each[..4], [1, 2, 2, 2]);
}

/// No pore strains by more than the limit from the positions that its network
/// was built of, whoever builds it; volumes are looked up in the geometry itself.
/// The look comes before a step, so that step's strain may come on top; and it
/// is the sum of the rates, linear in the motion: a tenth of the limit for both.
#[test]
fn the_strain_stays_below_its_limit() {
    const LIMIT: f64 = 0.1;
    let networks = [AtOnce, Ahead, Background].map(|remesh| {
        let mut coupled = moving(3, strain(LIMIT), mode(remesh));
        let mut largest = 0.0f64;
        for _ in 0..1500 {
            coupled.step(0.1 * DT).unwrap();
            let network = &coupled.storage_flow().unwrap().network();
            let now = network
                .volumes_at(&coupled.dem().storage().position, &coupled.dem().box_())
                .unwrap();
            let strains = now.iter().zip(&network.volume).map(|(now, v)| ((now - v) / v).abs());
            largest = largest.max(strains.fold(0.0, f64::max));
        }
        assert!(largest > 0.9 * LIMIT && largest < 1.1 * LIMIT, "{remesh:?}: {largest}");
        coupled.remeshes()
    });
    // Aged networks have come half the way when they come into use: some twice
    // as many are needed.
    let [at_once, ahead, background] = networks;
    assert_eq!(ahead, background);
    assert!(at_once > 10 && ahead as f64 > 1.5 * at_once as f64, "{networks:?}");
}

/// A state that was taken while the next network was on its way goes on with
/// the same bits, wherever in the interval.
#[test]
fn a_restart_in_flight_changes_no_bit() {
    for rule in [every(1), every(10), strain(0.1)] {
        let all = Acceleration { parallel_tasks: true, ..mode(Background) };
        let mut coupled = moving(4, rule, all);
        let mut states = vec![];
        let mut expected = vec![];
        for step in 0..60 {
            if (20..40).contains(&step) {
                states.push((step, coupled.state(), coupled.observe()));
            }
            coupled.step(DT).unwrap();
            expected.push(bits(&coupled));
        }
        for (step, state, seen_then) in states {
            let mut again = Coupled::from_state(state).unwrap();
            assert_eq!(again.observe(), seen_then);
            assert_eq!(again.steps(), step as u64);
            let seen = course(&mut again, 60 - step, DT);
            assert!(seen == expected[step..], "{rule:?}, restarted at step {step}");
        }
    }
}

/// As soon as it is ready: nothing waits, networks come into use in time, and
/// the positions follow those of a remesh at every step to the error that aged
/// conductances make anyway.
#[test]
fn when_ready_waits_for_nothing() {
    let ready = Acceleration { swap: Swap::WhenReady, ..mode(Background) };
    let mut coupled = moving(4, every(10), ready);
    let mut steps = 0;
    // However slow the background: it gets its time.
    while coupled.remeshes() < 20 {
        coupled.step(DT).unwrap();
        std::thread::yield_now();
        steps += 1;
        assert!(steps < 1_000_000);
    }
    let counts = coupled.remesh_counts();
    assert_eq!((counts.waits, counts.failures), (0, 0));
    // A network comes into use half an interval after the last at the earliest.
    assert!(steps >= 19 * 5, "{steps}");
}

/// The interval that follows from measured times is one of them (eq. 15), and
/// networks are renewed by it.
#[test]
fn an_automatic_interval_follows_the_measured_times() {
    let auto = Acceleration { auto_interval: true, ..mode(Background) };
    let mut coupled = moving(4, RemeshRule::default(), auto);
    assert_eq!(coupled.interval_trail().interval, None);
    let mut steps = 0;
    while coupled.remeshes() < 10 {
        coupled.step(DT).unwrap();
        let trail = coupled.interval_trail();
        assert!(trail.background_s > 0.0 && trail.steps_per_s > 0.0);
        let bound = 2.0 * trail.background_s * trail.steps_per_s;
        let found = trail.interval.unwrap() as f64;
        assert!(found >= bound && found <= (1.1 * bound).max(1.0) + 1.0, "{trail:?}");
        steps += 1;
        assert!(steps < 1_000_000);
    }
}

/// A drained packing has no network, and none on its way; filled again, it
/// starts from the positions of then.
#[test]
fn draining_cancels_what_is_on_its_way() {
    let mut coupled = moving(4, every(10), mode(Background));
    course(&mut coupled, 7, DT);
    coupled.drain();
    assert!(coupled.storage_flow().is_none());
    course(&mut coupled, 3, DT);
    coupled.saturate(drained(1.0, every(10)));
    course(&mut coupled, 30, DT);
    assert_eq!(coupled.remeshes(), 1 + 3);
    assert!(coupled.storage_flow().unwrap().force().iter().any(|f| *f != Vec3::zeros()));
}
