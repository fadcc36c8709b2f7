//! Momentum, angular momentum and energy of gases of spheres.

mod dem_support;

use dem_support::{cloud, frictionless_walls, material};
use dempfv::dem::{Dem, DemOptions, Material, Particles};
use dempfv::{Aabb, Vec3};

/// A large box that the spheres do not reach in the time of a test.
const SPACE: Aabb = Aabb { min: Vec3::new(-9.0, -9.0, -9.0), max: Vec3::new(10.0, 10.0, 10.0) };

/// A cloud that falls in on itself, every sphere with a spin of its own and
/// some of the random motion that its radius stands for.
fn gas(count: usize, friction_angle: f64) -> Dem {
    let mut p = cloud(count, 5);
    for i in 0..p.len() {
        let inwards = Vec3::repeat(0.5) - p.position[i];
        let random = Vec3::new(
            (1e5 * p.radius[i]).sin(),
            (2e5 * p.radius[i]).sin(),
            (3e5 * p.radius[i]).cos(),
        );
        p.velocity[i] = inwards + 0.3 * random;
        p.spin[i] = 20.0 * random;
    }
    let m = Material { friction_angle, ..material() };
    Dem::new(p, SPACE, m, frictionless_walls(), DemOptions::default()).unwrap()
}

/// Σ m |v| (kg m/s)
fn total_momentum_size(dem: &Dem) -> f64 {
    let p = dem.storage();
    p.mass.iter().zip(&p.velocity).map(|(m, v)| m * v.norm()).sum()
}

/// Σ x × m v + I ω about the origin, and Σ of the sizes (kg m²/s).
fn angular_momentum(dem: &Dem) -> (Vec3, f64) {
    let p = dem.storage();
    let each = (0..p.len()).map(|i| {
        let inertia = 0.4 * p.mass[i] * p.radius[i].powi(2);
        (p.mass[i] * p.position[i].cross(&p.velocity[i]), inertia * p.spin[i])
    });
    each.fold((Vec3::zeros(), 0.0), |(sum, size), (a, b)| (sum + a + b, size + a.norm() + b.norm()))
}

/// Actions and reactions cancel for any forces, friction included; with the
/// arms r − overlap/2 the torques of a contact do too, and the leapfrog keeps
/// both sums exactly. Round-off is all that may remain.
#[test]
fn momentum_is_conserved() {
    let mut dem = gas(1000, 0.5);
    let (p0, scale) = (dem.momentum(), total_momentum_size(&dem));
    let (l0, l_scale) = angular_momentum(&dem);
    let mut contacts = 0;
    for _ in 0..5000 {
        dem.step(2e-4).unwrap();
        contacts = contacts.max(dem.sphere_contact_count());
    }
    assert!(contacts > 60, "only {contacts} contacts at a time: no test");
    assert!((dem.momentum() - p0).norm() < 1e-12 * scale);
    assert!((angular_momentum(&dem).0 - l0).norm() < 1e-12 * l_scale);
}

/// The energy of a frictionless gas (J): kinetic, of the velocities at the
/// time of the positions, v + F/m Δt/2, and elastic.
fn energy(dem: &Dem, dt: f64) -> f64 {
    let p = dem.storage();
    let kinetic: f64 = (0..p.len())
        .map(|i| {
            let v = p.velocity[i] + dem.storage_forces()[i] * (0.5 * dt / p.mass[i]);
            0.5 * p.mass[i] * v.norm_squared()
        })
        .sum();
    kinetic + dem.elastic_energy()
}

/// Mean over 1000 pairs of spheres, each meeting once at an offset and at a
/// phase of the time step of its own, of the size of the energy that the
/// collision makes or loses, as a share of the pair's.
fn collision_error(dt: f64) -> f64 {
    let (mut position, mut velocity) = (Vec::new(), Vec::new());
    for k in 0..1000 {
        let at =
            Vec3::from([k / 100, k / 10 % 10, k % 10].map(f64::from)) * 1.5 - Vec3::repeat(7.0);
        let k = f64::from(k);
        let offset = Vec3::new(0.12 + 1e-5 * k, 0.1 * (0.7 * k).sin(), 0.1 * (0.9 * k).cos());
        position.extend([at - offset, at + offset]);
        velocity.extend([Vec3::new(0.5, 0.0, 0.0), Vec3::new(-0.5, 0.0, 0.0)]);
    }
    let mut p = Particles::new(position, vec![0.1; 2000], 2600.0);
    p.velocity = velocity;
    let pair_energy = 0.25 * p.mass[0];
    let m = Material { friction_angle: 0.0, ..material() };
    let mut dem = Dem::new(p, SPACE, m, frictionless_walls(), DemOptions::default()).unwrap();
    let mut seen = 0;
    for _ in 0..(0.4 / dt).round() as usize {
        dem.step(dt).unwrap();
        seen = seen.max(dem.sphere_contact_count());
    }
    assert!(seen > 50 && dem.contacts().count() == 0, "{seen}");
    let mut pairs = vec![-1.0; 1000];
    let p = dem.storage();
    for (i, &id) in p.id.iter().enumerate() {
        pairs[id as usize / 2] += 0.5 * p.mass[i] * p.velocity[i].norm_squared() / pair_energy;
    }
    pairs.iter().map(|e| e.abs()).sum::<f64>() / 1000.0
}

/// The leapfrog conserves energy to second order in the time step: half of it
/// divides the error of a collision by four. (The force has a kink where a
/// contact begins, so the error depends on the phase; the mean does not.)
#[test]
fn energy_is_conserved_to_second_order() {
    let [coarse, middle, fine] = [4e-4, 2e-4, 1e-4].map(collision_error);
    println!("{coarse:e} {middle:e} {fine:e}");
    for ratio in [coarse / middle, middle / fine] {
        assert!((3.6..4.4).contains(&ratio), "{coarse:e} {middle:e} {fine:e}");
    }
}

/// And so does a whole gas: the drift of 1000 steps stays within 1e-4.
#[test]
fn the_energy_of_a_gas_does_not_drift() {
    let dt = 2e-4;
    let mut dem = gas(1000, 0.0);
    dem.compute_contacts().unwrap();
    let first = energy(&dem, dt);
    let mut contacts = 0;
    for _ in 0..5000 {
        dem.step(dt).unwrap();
        contacts = contacts.max(dem.sphere_contact_count());
    }
    assert!(contacts > 60, "only {contacts} contacts at a time: no test");
    dem.compute_contacts().unwrap();
    println!("{contacts} {:e}", energy(&dem, dt) / first - 1.0);
    assert!((energy(&dem, dt) / first - 1.0).abs() < 1e-4);
}

/// The kinetic energy counts rotation: a sphere with spin ω has 1/5 m r² ω².
#[test]
fn spin_has_energy() {
    let mut p = cloud(1, 1);
    p.spin[0] = Vec3::new(0.0, 3.0, 4.0);
    let expected = 0.2 * p.mass[0] * p.radius[0].powi(2) * 25.0;
    let mut dem =
        Dem::new(p, SPACE, material(), frictionless_walls(), DemOptions::default()).unwrap();
    assert!((dem.rotational_energy() / expected - 1.0).abs() < 1e-14);
    dem.set_velocity(0, Vec3::new(1.0, 2.0, 2.0));
    let translation = 0.5 * dem.mass(0) * 9.0;
    assert!((dem.translational_energy() / translation - 1.0).abs() < 1e-14);
    assert!((dem.kinetic_energy() / (expected + translation) - 1.0).abs() < 1e-14);
}
