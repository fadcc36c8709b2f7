//! Energy by cause: what walls, gravity and added forces do is found again as motion, strain
//! energy and heat.

mod dem_support;

use dem_support::{bits, frictionless_walls, material, settled};
use dempfv::dem::{Dem, DemOptions, EnergyBalance, Material, Particles, WallControl};
use dempfv::{Aabb, Vec3, WallId};

const SPACE: Aabb = Aabb { min: Vec3::new(-9.0, -9.0, -9.0), max: Vec3::new(9.0, 9.0, 9.0) };

fn balance(dem: &Dem) -> EnergyBalance {
    dem.energy_balance().unwrap()
}

fn two_spheres(offset: f64, friction_angle: f64) -> Dem {
    let centres = vec![Vec3::new(-0.12, 0.0, 0.0), Vec3::new(0.12, offset, 0.0)];
    let mut p = Particles::new(centres, vec![0.1, 0.1], 2600.0);
    p.velocity = vec![Vec3::x(), -Vec3::x()];
    let material = Material { friction_angle, ..material() };
    let mut dem =
        Dem::new(p, SPACE, material, frictionless_walls(), DemOptions::default()).unwrap();
    dem.track_energy(true);
    dem
}

/// Along the line of centres the sums of a leapfrog step are exact: ½ k δ₀ δ₁ is the strain energy
/// at the half step, and what the first and the last step of the contact lose is known. Nothing but
/// round-off remains of 10.9 J at any step, 35 to a collision.
#[test]
fn a_central_collision_is_balanced_to_round_off() {
    let mut dem = two_spheres(0.0, 0.0);
    let all = balance(&dem).translation;
    let mut most_elastic = 0.0f64;
    for _ in 0..60 {
        dem.step(1e-3).unwrap();
        let b = balance(&dem);
        most_elastic = most_elastic.max(b.elastic);
        assert!(b.residual.abs() < 1e-12 * all, "{b:?}");
    }
    let end = balance(&dem);
    assert!(most_elastic > 0.99 * all && end.elastic == 0.0 && end.residual.abs() < 1e-12 * all);
    assert!(end.touch_change != 0.0 && end.touch_change.abs() < 5e-3 * all, "{end:?}");
}

/// An oblique collision that slips: friction has what is missing of the motion, and the balance closes to
/// round-off at any step. What turning contacts lose falls with the time step, to 2e-5 of the energy at
/// 1,400 steps a collision.
#[test]
fn friction_has_what_a_sliding_collision_loses() {
    let mut last = f64::INFINITY;
    for (steps, dt) in [(100, 1e-3), (1000, 1e-4), (4000, 2.5e-5)] {
        let mut dem = two_spheres(0.1, 0.1);
        let start = balance(&dem).translation;
        for _ in 0..steps {
            dem.step(dt).unwrap();
        }
        let b = balance(&dem);
        assert!(b.rotation > 0.01 * start && b.friction > 0.05 * start, "{b:?}");
        let missing = start - (b.translation + b.rotation);
        assert!((b.dissipated() - missing - b.residual).abs() < 1e-12 * start);
        assert!(b.residual.abs() < 1e-12 * start, "{dt}: {b:?}");
        assert!(b.turning.abs() < 0.4 * last, "{dt}: {} after {last}", b.turning);
        last = b.turning.abs();
    }
    assert!(last < 2e-5 * 10.9, "{last}");
}

/// A free fall trades height for motion exactly; a force that is added does work by F x.
#[test]
fn gravity_and_added_forces_do_work() {
    let p = Particles::new(vec![Vec3::zeros()], vec![0.1], 2600.0);
    let options = DemOptions { gravity: Some(Vec3::new(0.0, 0.0, -9.81)), ..Default::default() };
    let mut dem = Dem::new(p, SPACE, material(), frictionless_walls(), options).unwrap();
    dem.track_energy(true);
    for _ in 0..1000 {
        dem.add_force(0, Vec3::new(30.0, 0.0, 0.0));
        dem.add_torque(0, Vec3::new(0.0, 2.0, 0.0));
        dem.step(1e-4).unwrap();
    }
    let b = balance(&dem);
    let mass = 2600.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-3;
    // x = ½ F/m t², and ½ F² t²/m; the torque does ½ M² t² / I, with I = 2/5 m r².
    let expected = 0.5 * 30f64.powi(2) * 0.01 / mass + 0.5 * 4.0 * 0.01 / (0.4 * mass * 0.01);
    assert!((b.external_work / expected - 1.0).abs() < 2e-3, "{} {expected}", b.external_work);
    assert!(b.gravity < -0.4 && b.residual.abs() < 1e-13 * b.translation.abs(), "{b:?}");
}

/// A packing that a wall squeezes by some per cent. Time integration leaves 1e-6 of what was moved
/// at the largest step that runs take, and less than half of that at half the step; local damping
/// is part of the balance. The ledger is part of the state, and has the same bits on any number of
/// threads.
#[test]
fn a_packing_under_load_is_balanced() {
    let rest = settled(1000, 1, DemOptions { damping: 0.2, ..DemOptions::default() }).state();
    let squeezed = |damping: f64, safety: f64, restarts: bool| {
        let options = DemOptions { damping, ..DemOptions::default() };
        let from =
            |state| Dem::from_state(state, material(), frictionless_walls(), options).unwrap();
        let mut dem = from(rest.clone());
        dem.track_energy(true);
        dem.set_control(WallId::YMax, WallControl::Velocity(-0.02)).unwrap();
        let dt = dem.contact_time_step(safety).unwrap();
        for _ in 0..(1000.0 * 0.8 / safety) as usize {
            dem.step(dt).unwrap();
            if restarts {
                dem = from(dem.state());
            }
        }
        dem
    };
    let of = |dem: &Dem| {
        let b = balance(dem);
        assert!(b.friction > 0.01 * b.wall_work && b.wall_work > 100.0, "{b:?}");
        b.residual.abs() / b.moved()
    };
    let damped = squeezed(0.2, 0.8, false);
    assert!(balance(&damped).local_damping > 0.1);
    let (whole, half) = (of(&squeezed(0.0, 0.8, false)), of(&squeezed(0.0, 0.4, false)));

    assert!(of(&damped) < 1e-6 && whole < 3e-6 && half < 0.6 * whole);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| squeezed(0.2, 0.8, false));
        assert_eq!(bits(&again), bits(&damped), "{threads} threads");
        assert_eq!(balance(&again), balance(&damped));
    }
    let restarted = squeezed(0.2, 0.8, true);
    assert_eq!(balance(&restarted), balance(&damped));
}

/// Off, there is no balance and no bit of the motion differs; growth begins anew.
#[test]
fn tracking_changes_no_motion() {
    let run = |tracked: bool| {
        let mut dem = two_spheres(0.1, 0.4);
        dem.track_energy(tracked);
        assert_eq!(dem.tracks_energy(), tracked);
        for _ in 0..60 {
            dem.step(1e-3).unwrap();
        }
        dem
    };
    let (mut on, off) = (run(true), run(false));
    assert_eq!(on.storage(), off.storage());
    assert!(off.energy_balance().is_none() && balance(&on).friction > 0.0);
    on.scale_radii(1.01).unwrap();
    assert_eq!(balance(&on).friction, 0.0);
}

/// A push in one step is booked once: the steps after it, without one, add nothing.
#[test]
fn a_single_push_is_booked_once() {
    let p = Particles::new(vec![Vec3::zeros()], vec![0.1], 2600.0);
    let mut dem =
        Dem::new(p, SPACE, material(), frictionless_walls(), DemOptions::default()).unwrap();
    dem.track_energy(true);
    dem.add_force(0, Vec3::new(30.0, 0.0, 0.0));
    for _ in 0..5 {
        dem.step(1e-3).unwrap();
    }
    let b = balance(&dem);
    assert!(b.external_work > 0.0 && b.residual.abs() < 1e-14 * b.translation, "{b:?}");
    assert!((b.external_work / b.translation - 1.0).abs() < 1e-12, "{b:?}");
}
