//! Rigid clumps of spheres.

mod dem_support;

use std::f64::consts::PI;

use dem_support::{UNIT, bits, frictionless_walls, material};
use dempfv::dem::{
    CloudScale, CloudSpec, ClumpTemplate, Dem, DemError, DemOptions, GrowthCompaction,
    GrowthOptions, Material, Motion, Particles, SizeDistribution, WallControl, WallMaterial,
    random_cloud,
};
use dempfv::{Aabb, Vec3, WallId};

const SPACE: Aabb = Aabb { min: Vec3::new(-9.0, -9.0, -9.0), max: Vec3::new(9.0, 9.0, 9.0) };

/// Spheres with their radii, bound to one clump.
fn clump(spheres: &[([f64; 3], f64)], material: Material, options: DemOptions) -> Dem {
    let (x, r): (Vec<Vec3>, Vec<f64>) = spheres.iter().map(|&(x, r)| (Vec3::from(x), r)).unzip();
    let p = Particles::new(x, r, material.density);
    let walls = WallMaterial { young: material.young, friction_angle: 0.0 };
    let mut dem = Dem::new(p, SPACE, material, walls, options).unwrap();
    dem.bind(&[(0..spheres.len() as u32).collect()]).unwrap();
    dem
}

/// Three principal moments that differ, and members that overlap.
const UGLY: [([f64; 3], f64); 4] = [
    ([0.0, 0.0, 0.0], 0.3),
    ([0.5, 0.0, 0.0], 0.25),
    ([0.1, 0.4, 0.1], 0.2),
    ([-0.6, -0.2, 0.0], 0.1),
];

fn only(dem: &Dem) -> &dempfv::dem::Clump {
    dem.clumps().next().unwrap()
}

/// Free tumbling about the axis between two that are stable: the angular momentum, also as the members
/// move, stays; the energy swings by the square of the time step and does not drift; the body turns as
/// Euler's equations say, integrated with a step of a hundredth by Runge and Kutta.
#[test]
fn a_free_body_tumbles() {
    let spin = Vec3::new(0.3, 4.0, 0.5);
    let run = |dt: f64, time: f64| {
        let mut dem = clump(&UGLY, material(), DemOptions::default());
        dem.set_clump_motion(0, Vec3::zeros(), spin).unwrap();
        let (momentum, energy) = (only(&dem).angular_momentum, only(&dem).kinetic_energy()[1]);
        let (mut worst, mut second_half) = ([0.0f64; 2], 0.0f64);
        let steps = (time / dt).round() as usize;
        for step in 0..steps {
            dem.step(dt).unwrap();
            let body = only(&dem);
            let now = [
                (body.angular_momentum - momentum).norm() / momentum.norm(),
                (body.kinetic_energy()[1] / energy - 1.0).abs(),
            ];
            worst = [0, 1].map(|k| worst[k].max(now[k]));
            if 2 * step > steps {
                second_half = second_half.max(now[1]);
            }
        }
        assert!(worst[0] < 1e-10, "{worst:?}");
        (worst[1], second_half, dem)
    };
    let (coarse, _, _) = run(2e-3, 20.0);
    let (fine, late, _) = run(1e-3, 20.0);
    println!("{coarse:e} {fine:e} {late:e}");
    assert!((3.5..4.5).contains(&(coarse / fine)) && fine < 2e-5 && late < 1.05 * fine);

    let (_, _, after) = run(1e-3, 3.0);
    let mut expected = clump(&UGLY, material(), DemOptions::default());
    expected.set_clump_motion(0, Vec3::zeros(), spin).unwrap();
    let body = only(&expected).clone();
    let place = |dem: &Dem, k: usize| dem.position(k) - only(dem).centre;
    let reference = euler(&body, 1e-5, 300_000);
    for k in 0..4 {
        let r = body.orientation.inverse_transform_vector(&place(&expected, k));
        let off = (place(&after, k) - reference * r).norm();
        assert!(off < 5e-4, "{k}: {off}");
    }
}

/// Orientation after `steps` of `dt` of a free body: dq/dt = ½ ω q with ω = I⁻¹ L, by Runge and Kutta.
fn euler(body: &dempfv::dem::Clump, dt: f64, steps: usize) -> nalgebra::UnitQuaternion<f64> {
    use nalgebra::{Quaternion, UnitQuaternion};
    let rate = |q: &Quaternion<f64>| {
        let turn = UnitQuaternion::new_normalize(*q);
        let own = turn.inverse_transform_vector(&body.angular_momentum);
        let spin = turn.transform_vector(&own.component_div(&body.moments));
        Quaternion::from_parts(0.0, spin) * q * 0.5
    };
    let mut q = *body.orientation.quaternion();
    for _ in 0..steps {
        let a = rate(&q);
        let b = rate(&(q + a * (0.5 * dt)));
        let c = rate(&(q + b * (0.5 * dt)));
        let d = rate(&(q + c * dt));
        q += (a + (b + c) * 2.0 + d) * (dt / 6.0);
    }
    UnitQuaternion::new_normalize(q)
}

/// Members move as their clump: Σ m r × v + I ω of members that do not overlap is the angular momentum,
/// to the square of the time step, and the momentum its.
#[test]
fn members_move_with_their_clump() {
    let apart = [([0.0; 3], 0.3), ([0.6, 0.0, 0.0], 0.2), ([0.0, 0.5, 0.1], 0.15)];
    let mut dem = clump(&apart, material(), DemOptions::default());
    dem.set_clump_motion(0, Vec3::new(0.1, 0.2, -0.3), Vec3::new(0.3, 4.0, 0.5)).unwrap();
    for _ in 0..500 {
        dem.step(1e-4).unwrap();
    }
    let body = only(&dem);
    // Half a step back, where the velocities are.
    let half_way = |k: usize| dem.position(k) - 0.5e-4 * dem.velocity(k);
    let middle = body.centre - 0.5e-4 * body.velocity;
    let angular: Vec3 = (0..3)
        .map(|k| {
            let inertia = 0.4 * dem.mass(k) * dem.radius(k).powi(2);
            dem.mass(k) * (half_way(k) - middle).cross(&(dem.velocity(k) - body.velocity))
                + inertia * dem.spin(k)
        })
        .sum();
    assert!(
        (angular / body.angular_momentum.norm() - body.angular_momentum.normalize()).norm() < 1e-6
    );
    let momentum: Vec3 = (0..3).map(|k| dem.mass(k) * dem.velocity(k)).sum();
    assert!((momentum - dem.momentum()).norm() < 1e-6 * momentum.norm());
}

/// A dumb-bell hangs by one end in a cage of four spheres that are held, without friction, and swings
/// about the middle of that end: T = 2π √(I/(M g d)) (1 + θ²/16), with I about that point.
#[test]
fn a_dumbbell_swings_as_a_pendulum() {
    let (r, length, g, angle) = (0.1f64, 0.4, 9.81, 0.1f64);
    let stiff = Material { young: 1e9, friction_angle: 0.0, ..material() };
    let hung = Vec3::new(length * angle.sin(), 0.0, -length * angle.cos());
    let mut x = vec![Vec3::zeros(), hung];
    // The corners of a tetrahedron, of which one is above.
    let (low, out) = (-1.0 / 3.0, 8f64.sqrt() / 3.0);
    let corner = |turn: f64| Vec3::new(out * turn.cos(), out * turn.sin(), low);
    let cage = [Vec3::z(), corner(0.5), corner(0.5 + 2.0 * PI / 3.0), corner(0.5 - 2.0 * PI / 3.0)];
    x.extend(cage.map(|n| 1.4995 * r * n));
    let p = Particles::new(x, vec![r, r, 0.5 * r, 0.5 * r, 0.5 * r, 0.5 * r], stiff.density);
    let options = DemOptions { gravity: Some(Vec3::new(0.0, 0.0, -g)), ..DemOptions::default() };
    let mut dem = Dem::new(p, SPACE, stiff, frictionless_walls(), options).unwrap();
    dem.bind(&[vec![0, 1]]).unwrap();
    dem.prescribe(&[2, 3, 4, 5], Motion::default()).unwrap();
    dem.compute_contacts().unwrap();
    dem.track_energy(true);
    let dt = dem.safe_time_step(0.3);
    let (mut time, mut before, mut crossings) = (0.0, dem.position(1).x, vec![]);
    while crossings.len() < 7 {
        dem.step(dt).unwrap();
        let now = dem.position(1).x;
        if before * now < 0.0 {
            crossings.push(time + dt * before / (before - now));
        }
        (time, before) = (time + dt, now);
    }
    let period = (crossings[6] - crossings[0]) / 3.0;
    // Two equal spheres that do not overlap.
    let mass = 2600.0 * 4.0 / 3.0 * PI * r.powi(3);
    let inertia = 2.0 * 0.4 * mass * r * r + mass * length * length;
    let expected = 2.0
        * PI
        * (inertia / (2.0 * mass * g * 0.5 * length)).sqrt()
        * (1.0 + angle * angle / 16.0);
    println!("{period} {expected} {dt:e}");
    assert!((period / expected - 1.0).abs() < 5e-4, "{period} {expected}");
    let b = dem.energy_balance().unwrap();
    let swung = 2.0 * mass * g * 0.5 * length * (1.0 - angle.cos());
    assert!(b.residual.abs() < 1e-3 * swung, "{b:?} of {swung}");
}

/// A tilted dumb-bell falls on a wall: the blow along the normal at the arm x turns it, with
/// J = 2 v / (1/M + x²/I) for a contact that gives back all.
#[test]
fn a_blow_turns_a_dumbbell() {
    let (r, tilt, speed) = (0.1f64, 0.5f64, 1.0);
    let half = 0.15;
    let ends = [-1.0, 1.0]
        .map(|s| [s * half * tilt.cos(), -9.0 + r + 1e-4 + half * tilt.sin() * (1.0 + s), 0.0]);
    let smooth = Material { young: 1e9, friction_angle: 0.0, ..material() };
    let mut dem = clump(&ends.map(|x| (x, r)), smooth, DemOptions::default());
    dem.set_clump_motion(0, Vec3::new(0.0, -speed, 0.0), Vec3::zeros()).unwrap();
    dem.compute_contacts().unwrap();
    dem.track_energy(true);
    let energy = dem.kinetic_energy();
    let dt = dem.safe_time_step(0.05);
    let mut touched = false;
    loop {
        dem.step(dt).unwrap();
        let touches = dem.contacts().count() > 0;
        if touched && !touches {
            break;
        }
        touched |= touches;
    }
    let body = only(&dem);
    let mass = smooth.density * 4.0 / 3.0 * PI * r.powi(3);
    let (arm, inertia) = (half * tilt.cos(), 2.0 * (0.4 * mass * r * r + mass * half * half));
    let blow = 2.0 * speed / (0.5 / mass + arm * arm / inertia);
    let (v, w) = (blow / (2.0 * mass) - speed, -arm * blow / inertia);
    println!("{} {v} {} {w}", body.velocity.y, body.spin().z);
    // The stiffness of the contact stays; the arm changes by a few thousandths meanwhile.
    assert!((body.velocity.y - v).abs() < 5e-3 && (body.spin().z / w - 1.0).abs() < 5e-3);
    let b = dem.energy_balance().unwrap();
    assert!((dem.kinetic_energy() / energy - 1.0).abs() < 1e-3, "{b:?}");
    assert!(b.residual.abs() < 1e-4 * energy && dem.momentum().x.abs() < 1e-12, "{b:?}");
}

/// Mass and moments of a dumb-bell whose ends overlap: twice a sphere less the lens
/// π (4R + d)(2R − d)²/12; its ends do not touch each other, and its porosity counts the lens once.
#[test]
fn overlapping_ends_count_once() {
    let (r, d) = (0.2f64, 0.3);
    let ends = [([0.0; 3], r), ([d, 0.0, 0.0], r)];
    let mut dem = clump(&ends, material(), DemOptions::default());
    let lens = PI * (4.0 * r + d) * (2.0 * r - d).powi(2) / 12.0;
    let volume = 2.0 * 4.0 / 3.0 * PI * r.powi(3) - lens;
    let body = only(&dem);
    assert!(
        (body.volume / volume - 1.0).abs() < 1e-12
            && (body.mass / 2600.0 / volume - 1.0).abs() < 1e-12
    );
    assert!((body.centre - Vec3::new(0.5 * d, 0.0, 0.0)).norm() < 1e-12);
    assert!(((1.0 - dem.porosity()) * SPACE.volume() / volume - 1.0).abs() < 1e-9);
    // By their shares the ends have no more inertia than the body, along or about any axis.
    let along = 2.0 * 0.4 * dem.mass(0) * r * r;
    let within = |part: f64, whole: f64| part <= whole * (1.0 + 1e-12);
    assert!(within(2.0 * dem.mass(0), body.mass) && within(along, body.moments.min()));
    for _ in 0..10 {
        dem.step(1e-3).unwrap();
    }
    assert_eq!((dem.sphere_contact_count(), dem.elastic_energy()), (0, 0.0));
}

/// Clumps in the place of the spheres of a cloud.
fn packing(count: usize, options: DemOptions) -> Dem {
    let spec = CloudSpec {
        box_: UNIT,
        count,
        sizes: SizeDistribution::Uniform { spread: 0.3 },
        scale: CloudScale::Porosity(0.8),
        seed: 3,
    };
    let ends = [(Vec3::new(0.45, 0.0, 0.0), 0.55), (Vec3::new(-0.45, 0.0, 0.0), 0.5)];
    let template = ClumpTemplate { members: ends.to_vec() };
    let spheres = template.in_place_of(&random_cloud(&spec).unwrap(), 7).unwrap();
    let p = Particles::new(spheres.position, spheres.radius, material().density);
    let mut dem = Dem::new(p, UNIT, material(), frictionless_walls(), options).unwrap();
    dem.bind(&spheres.clumps).unwrap();
    dem
}

fn from(state: dempfv::dem::DemState, damping: f64) -> Dem {
    let options = DemOptions { damping, ..DemOptions::default() };
    Dem::from_state(state, material(), frictionless_walls(), options).unwrap()
}

/// A packing of dumb-bells grows to 10 kPa and comes to rest; a servo loads it, gravity is added; all
/// with the same bits for any number of threads and through checkpoints. The ledger closes.
#[test]
fn a_packing_of_dumbbells() {
    let mut dem = packing(600, DemOptions { damping: 0.3, ..DemOptions::default() });
    GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap().run(&mut dem).unwrap();
    assert!((dem.mean_stress() / 1e4 - 1.0).abs() < 0.05 && dem.porosity() < 0.5);
    for body in dem.clumps() {
        let [a, b] = [0, 1].map(|k| dem.position(body.members[k] as usize));
        let [r, s] = [0, 1].map(|k| dem.radius(body.members[k] as usize));
        // The shape has grown as a whole.
        assert!(((a - b).norm() / (r + s) - 0.9 / 1.05).abs() < 1e-9);
    }
    dem.track_energy(true);
    dem.set_control(WallId::YMax, WallControl::Servo { stress: 1.5e4, max_velocity: None })
        .unwrap();
    let start = dem.state();
    let run = |threads: usize, restarts: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut dem = from(start.clone(), 0.2);
            let dt = dem.safe_time_step(0.5);
            for _ in 0..300 {
                dem.step(dt).unwrap();
                if restarts {
                    dem = from(dem.state(), 0.2);
                }
            }
            dem
        })
    };
    let one = run(1, false);
    let b = one.energy_balance().unwrap();
    println!("{} {:e} of {:e}", one.porosity(), b.residual, b.moved());
    assert!(b.residual.abs() < 2e-5 * b.moved() && b.local_damping > 0.0, "{b:?}");
    assert!((one.wall_stress(WallId::YMax) / 1.5e4 - 1.0).abs() < 0.05);
    for (threads, restarts) in [(3, false), (2, true)] {
        assert_eq!(bits(&run(threads, restarts)), bits(&one), "{threads} threads, {restarts}");
    }
    let mut sorted = from(start.clone(), 0.2);
    sorted.sort_spatially().unwrap();
    assert_eq!(sorted.clumps().count(), 600);
    sorted.step(1e-5).unwrap();
    assert!(
        sorted.clumps().all(|c| c.members.iter().all(|&n| sorted.clump_of(n as usize).is_some()))
    );
}

/// A clump one of whose members is given a motion moves as a whole, and takes blows without a stir.
#[test]
fn a_held_clump_stands() {
    let x = [Vec3::zeros(), Vec3::new(0.2, 0.0, 0.0), Vec3::new(0.21, 0.205, 0.0)];
    let p = Particles::new(x.to_vec(), vec![0.1; 3], 2600.0);
    let mut dem =
        Dem::new(p, SPACE, material(), frictionless_walls(), DemOptions::default()).unwrap();
    dem.bind(&[vec![0, 1]]).unwrap();
    dem.prescribe(&[0], Motion::default()).unwrap();
    dem.set_velocity(2, -Vec3::y());
    dem.track_energy(true);
    (0..2000).for_each(|_| dem.step(5e-5).unwrap());
    assert_eq!([dem.position(0), dem.position(1)], [x[0], x[1]]);
    let b = dem.energy_balance().unwrap();
    assert!(dem.velocity(2).y > 0.9 && b.motion_work.abs() < 1e-12, "{} {b:?}", dem.velocity(2));
    let spin = [0.0.into(), 0.0.into(), 2.0.into()];
    dem.prescribe(&[1], Motion { spin, ..Motion::default() }).unwrap();
    let middle = only(&dem).centre;
    (0..1000).for_each(|_| dem.step(1e-3).unwrap());
    let expected = middle + 0.1 * Vec3::new(2f64.cos(), 2f64.sin(), 0.0);
    assert!((dem.position(1) - expected).norm() < 1e-9 && only(&dem).centre == middle);
    dem.release(&[0]).unwrap();
    assert!((only(&dem).spin() - Vec3::new(0.0, 0.0, 2.0)).norm() < 1e-9);
}

#[test]
fn no_clump_is_refused() {
    let x = [0.0, 0.1, 0.2, 1.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let make = |options: DemOptions| {
        let p = Particles::new(x.to_vec(), vec![0.15; 4], 2600.0);
        Dem::new(p, SPACE, material(), frictionless_walls(), options).unwrap()
    };
    for (groups, word) in [
        (vec![vec![0, 1, 2]], "three spheres that overlap"),
        (vec![vec![0]], "fewer than two"),
        (vec![vec![0, 1], vec![1, 3]], "in a clump already"),
        (vec![vec![0, 9]], "no sphere 9"),
    ] {
        let error = make(DemOptions::default()).bind(&groups).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    let still = DemOptions { rotation: false, ..DemOptions::default() };
    assert!(matches!(make(still).bind(&[vec![0, 3]]), Err(DemError::Clump { clump: 0, .. })));
    let out = ClumpTemplate { members: vec![(Vec3::zeros(), 0.5), (Vec3::x(), 0.1)] };
    assert!(out.in_place_of(&[(Vec3::zeros(), 1.0)], 1).is_err());
}
