//! Spheres whose motion is given: held fast, driven, turned about an axis; and what that takes.

mod dem_support;

use dem_support::{bits, frictionless_walls, material, settled};
use dempfv::coupling::Coupled;
use dempfv::dem::{Dem, DemError, DemOptions, Motion, Particles};
use dempfv::{Aabb, TimeFunction, Vec3};

const SPACE: Aabb = Aabb { min: Vec3::new(-9.0, -9.0, -9.0), max: Vec3::new(9.0, 9.0, 9.0) };

fn dem(centres: &[Vec3], radius: f64, options: DemOptions) -> Dem {
    let p = Particles::new(centres.to_vec(), vec![radius; centres.len()], 2600.0);
    Dem::new(p, SPACE, material(), frictionless_walls(), options).unwrap()
}

fn constant(v: Vec3) -> [TimeFunction; 3] {
    [v.x, v.y, v.z].map(TimeFunction::Constant)
}

/// Two spheres on an axis that itself goes along: after 100,000 steps they are where the rigid motion
/// says, as far from the axis as ever, with the velocities of their places. Gravity has no say.
#[test]
fn a_turn_about_an_axis_is_rigid() {
    let about = Vec3::new(0.5, 0.0, 0.0);
    let centres = [Vec3::new(1.5, 0.0, 0.3), Vec3::new(0.5, 2.0, 0.0)];
    let options = DemOptions { gravity: Some(Vec3::new(0.0, -9.81, 0.0)), ..Default::default() };
    let mut dem = dem(&centres, 0.1, options);
    let (velocity, rate) = (Vec3::new(0.2, 0.0, -0.1), 3.0);
    let spin = constant(Vec3::new(0.0, 0.0, rate));
    let motion = Motion { velocity: constant(velocity), spin, about: Some(about) };
    dem.prescribe(&[0, 1], motion).unwrap();
    let (dt, steps) = (1e-4, 100_000);
    (0..steps).for_each(|_| dem.step(dt).unwrap());
    let time = dt * f64::from(steps);
    let turned = |angle: f64, r: Vec3| {
        let (sine, cosine) = angle.sin_cos();
        Vec3::new(cosine * r.x - sine * r.y, sine * r.x + cosine * r.y, r.z)
    };
    for (k, centre) in centres.into_iter().enumerate() {
        let expected = about + time * velocity + turned(rate * time, centre - about);
        assert!((dem.position(k) - expected).norm() < 1e-9, "{} {expected}", dem.position(k));
        // Half a step behind.
        let r = turned(rate * (time - 0.5 * dt), centre - about);
        let expected = velocity + rate * Vec3::z().cross(&r);
        assert!((dem.velocity(k) - expected).norm() < 1e-6, "{} {expected}", dem.velocity(k));
        assert_eq!(dem.spin(k), Vec3::new(0.0, 0.0, rate));
    }
}

/// A sphere between one that is held and one that is driven takes the work of the drive as strain
/// energy: with two springs in series F = ½ k u, and W = ¼ k u². One that is held takes none, and a
/// sphere that strikes it comes back as fast.
#[test]
fn work_of_a_drive_is_found_again() {
    let r = 0.1;
    let centres = [0.0, 2.0 * r, 4.0 * r].map(|x| Vec3::new(x, 0.0, 0.0));
    let mut dem = dem(&centres, r, DemOptions { damping: 0.3, ..Default::default() });
    dem.compute_contacts().unwrap();
    dem.track_energy(true);
    dem.prescribe(&[0], Motion::default()).unwrap();
    let slow = TimeFunction::Constant(-1e-3);
    let velocity = [slow, 0.0.into(), 0.0.into()];
    dem.prescribe(&[2], Motion { velocity, ..Motion::default() }).unwrap();
    let (dt, steps) = (1e-4, 10_000);
    (0..steps).for_each(|_| dem.step(dt).unwrap());
    let shift = 1e-3 * dt * f64::from(steps);
    let (stiffness, b) = (1e6 * r, dem.energy_balance().unwrap());
    assert!((b.motion_work / (0.25 * stiffness * shift * shift) - 1.0).abs() < 5e-3, "{b:?}");
    assert!((b.elastic / b.motion_work - 1.0).abs() < 5e-3 && b.residual.abs() < 1e-9 * b.elastic);
    assert_eq!(dem.position(0), centres[0]);
    assert!((dem.position(2).x - (centres[2].x - shift)).abs() < 1e-13);

    let mut dem = self::dem(&[Vec3::zeros(), Vec3::new(0.21, 0.0, 0.0)], r, DemOptions::default());
    dem.set_velocity(1, -Vec3::x());
    dem.track_energy(true);
    dem.prescribe(&[0], Motion::default()).unwrap();
    (0..4000).for_each(|_| dem.step(2e-5).unwrap());
    let b = dem.energy_balance().unwrap();
    assert!((dem.velocity(1).x - 1.0).abs() < 1e-4 && b.motion_work == 0.0, "{b:?}");
    assert!(b.residual.abs() < 1e-12 * b.translation, "{b:?}");
}

/// A spin that is given turns a sphere on another by friction, and the ledger has who did it.
#[test]
fn a_driven_wheel_turns_its_neighbour() {
    let r = 0.1;
    let centres = [Vec3::zeros(), Vec3::new(2.0 * r - 1e-3, 0.0, 0.0)];
    let mut dem = dem(&centres, r, DemOptions::default());
    dem.compute_contacts().unwrap();
    dem.track_energy(true);
    dem.prescribe(&[0], Motion { spin: constant(5.0 * Vec3::z()), ..Motion::default() }).unwrap();
    let about = Some(centres[1]);
    dem.prescribe(&[1], Motion { about, ..Motion::default() }).unwrap();
    dem.release(&[1]).unwrap();
    (0..200).for_each(|_| dem.step(1e-4).unwrap());
    let b = dem.energy_balance().unwrap();
    assert!(dem.spin(1).z < -0.1 && dem.spin(0) == 5.0 * Vec3::z(), "{}", dem.spin(1));
    assert!(b.motion_work > 0.0 && b.residual.abs() < 1e-4 * b.moved(), "{b:?}");
}

/// A ramp in time is followed to its corners, in a coupled run by its own clock, and a sphere that is
/// let go flies on.
#[test]
fn motions_follow_the_clock() {
    let ramp = TimeFunction::Ramp(vec![[1.0, 0.0], [2.0, 4.0]]);
    let velocity = [ramp, 0.0.into(), 0.0.into()];
    let motion = Motion { velocity, ..Motion::default() };
    let mut dem = dem(&[Vec3::zeros()], 0.1, DemOptions::default());
    dem.set_time(0.5).unwrap();
    dem.prescribe(&[0], motion.clone()).unwrap();
    (0..2000).for_each(|_| dem.step(1e-3).unwrap());
    assert!((dem.position(0).x - 4.0).abs() < 1e-12, "{}", dem.position(0));
    dem.release(&[0]).unwrap();
    assert_eq!(dem.prescribed().count(), 0);
    (0..100).for_each(|_| dem.step(1e-3).unwrap());
    assert!((dem.position(0).x - 4.4).abs() < 1e-12, "{}", dem.position(0));

    let mut dem = self::dem(&[Vec3::zeros()], 0.1, DemOptions::default());
    dem.prescribe(&[0], motion).unwrap();
    let mut coupled = Coupled::new(dem);
    (0..2000).for_each(|_| coupled.step(1e-3).unwrap());
    assert!((coupled.dem().position(0).x - 2.0).abs() < 1e-9, "{}", coupled.dem().position(0));
}

/// A packing with a floor that turns: the same bits for any number of threads, through checkpoints
/// and a new order of the spheres in memory.
#[test]
fn motions_change_no_bit() {
    let floor = |dem: &Dem| -> Vec<u32> {
        (0..dem.len() as u32).filter(|&k| dem.position(k as usize).y < 0.1).collect()
    };
    let mut start = settled(3000, 1, DemOptions { damping: 0.2, ..DemOptions::default() });
    let numbers = floor(&start);
    assert!(numbers.len() > 100);
    let spin = constant(0.5 * Vec3::y());
    let about = Some(Vec3::repeat(0.5));
    start.track_energy(true);
    start.prescribe(&numbers, Motion { spin, about, ..Motion::default() }).unwrap();
    let start = start.state();
    let run = |threads: usize, restarts: bool| {
        let from = |state| {
            Dem::from_state(state, material(), frictionless_walls(), DemOptions::default()).unwrap()
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut dem = from(start.clone());
            for _ in 0..40 {
                dem.step(1e-4).unwrap();
                if restarts {
                    dem = from(dem.state());
                }
            }
            dem
        })
    };
    let one = run(1, false);
    let b = one.energy_balance().unwrap();
    assert!(b.motion_work > 0.0 && b.residual.abs() < 1e-3 * b.moved(), "{b:?}");
    for (threads, restarts) in [(3, false), (1, true)] {
        assert_eq!(bits(&run(threads, restarts)), bits(&one), "{threads} threads, {restarts}");
    }
}

#[test]
fn no_motion_is_refused() {
    let mut dem = dem(&[Vec3::zeros()], 0.1, DemOptions::default());
    let nan = Motion { velocity: constant(Vec3::repeat(f64::NAN)), ..Motion::default() };
    assert!(matches!(dem.prescribe(&[0], nan), Err(DemError::Motion { what: "velocity", .. })));
    let unknown = dem.prescribe(&[0, 1], Motion::default());
    assert_eq!(unknown, Err(DemError::NoSuchSphere { number: 1, count: 1 }));
}
