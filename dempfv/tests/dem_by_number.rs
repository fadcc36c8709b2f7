//! The spheres as the outside world knows them: the user's numbers, what a
//! user adds to the forces, and a time step that needs no care.

mod dem_support;

use dem_support::{UNIT, bits, cloud, frictionless_walls, material, settled};
use dempfv::Vec3;
use dempfv::dem::{Dem, DemOptions, Material, Particles, Partner};

/// Spheres whose order in storage is not the user's.
fn shuffled() -> (Particles, Dem) {
    let given = cloud(500, 3);
    let options = DemOptions::default();
    let dem = Dem::new(given.clone(), UNIT, material(), frictionless_walls(), options).unwrap();
    assert!(dem.storage().id != given.id, "the order in storage is the user's: no test");
    (given, dem)
}

#[test]
fn spheres_answer_to_the_users_numbers() {
    let (given, mut dem) = shuffled();
    assert_eq!(dem.positions(), given.position);
    assert_eq!(dem.radii(), given.radius);
    assert_eq!(dem.masses(), given.mass);
    for i in 0..dem.len() {
        dem.set_velocity(i, Vec3::new(i as f64, 0.0, 0.0));
        dem.set_spin(i, Vec3::new(0.0, i as f64, 0.0));
    }
    dem.sort_spatially().unwrap();
    for i in 0..dem.len() {
        assert_eq!(dem.position(i), given.position[i]);
        assert_eq!(dem.velocity(i).x, i as f64);
        assert_eq!(dem.spin(i).y, i as f64);
        assert_eq!(dem.storage().id[dem.storage_index(i)], i as u32);
    }
    assert_eq!(dem.velocities()[17].x, 17.0);
    assert_eq!(dem.spins()[17].y, 17.0);
}

/// The forces of the contacts, taken from the list of contacts by the user's
/// numbers, add up to the force on each sphere.
#[test]
fn contacts_bear_the_users_numbers() {
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let mut dem = settled(400, 5, options);
    dem.compute_contacts().unwrap();
    let mut sums = vec![Vec3::zeros(); dem.len()];
    let mut largest = 0.0f64;
    for contact in dem.contacts() {
        let force = contact.force();
        largest = largest.max(force.norm());
        sums[contact.i as usize] -= force;
        if let Partner::Sphere(j) = contact.partner {
            sums[j as usize] += force;
            let way = dem.position(j as usize) - dem.position(contact.i as usize);
            assert!((way - contact.distance * contact.normal).norm() < 1e-12);
        }
    }
    assert!(largest > 0.0);
    for (i, sum) in sums.iter().enumerate() {
        assert!((sum - dem.force(i)).norm() < 1e-9 * largest, "{i}: {sum} {}", dem.force(i));
    }
}

/// F Δt = m Δv and T Δt = I Δω for the one sphere named, in one step only,
/// and nothing happens to the others.
#[test]
fn what_is_added_acts_once_on_the_sphere_named() {
    let (_, mut dem) = shuffled();
    let (force, torque) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(1e-3, 2e-3, -3e-3));
    let (i, dt) = (123, 1e-6);
    dem.compute_contacts().unwrap();
    dem.add_force(i, 0.25 * force);
    dem.add_force(i, 0.75 * force);
    dem.add_torque(i, torque);
    dem.integrate(dt, None, None).unwrap();
    let inertia = 0.4 * dem.mass(i) * dem.radius(i).powi(2);
    assert!((dem.velocity(i) * dem.mass(i) / dt - force).norm() < 1e-12 * force.norm());
    assert!((dem.spin(i) * inertia / dt - torque).norm() < 1e-12 * torque.norm());
    let moving = dem.velocities().iter().filter(|v| **v != Vec3::zeros()).count();
    assert_eq!(moving, 1);
    let (v, w) = (dem.velocity(i), dem.spin(i));
    dem.step(dt).unwrap();
    assert_eq!((dem.velocity(i), dem.spin(i)), (v, w));
}

/// A torque turns a sphere that no friction could turn, unless rotation is
/// off; damping takes its share of an added force.
#[test]
fn rotation_and_damping_hold_for_what_is_added() {
    let smooth = Material { friction_angle: 0.0, ..material() };
    for (rotation, damping) in [(true, 0.0), (false, 0.3)] {
        let options = DemOptions { rotation, damping, ..DemOptions::default() };
        let mut dem = Dem::new(cloud(5, 1), UNIT, smooth, frictionless_walls(), options).unwrap();
        dem.add_torque(2, Vec3::new(0.0, 0.0, 1.0));
        dem.add_force(2, Vec3::new(1.0, 0.0, 0.0));
        dem.step(1e-6).unwrap();
        assert_eq!(dem.spin(2).z > 0.0, rotation);
        let expected = (1.0 - damping) * 1e-6 / dem.mass(2);
        assert!((dem.velocity(2).x / expected - 1.0).abs() < 1e-12);
    }
}

/// Zero forces change no bit, so the seam is the same sum.
#[test]
fn adding_nothing_changes_nothing() {
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let [plain, added] = [false, true].map(|add| {
        let mut dem = settled(400, 5, options);
        for _ in 0..20 {
            if add {
                dem.add_force(3, Vec3::zeros());
            }
            dem.step(1e-4).unwrap();
        }
        bits(&dem)
    });
    assert!(plain == added);
}

/// A row of spheres squeezed between two walls, whose fastest mode has
/// ω² = 4k/m: the step of a sphere with a single contact, 0.9 √(2m/k), taken
/// before anybody has looked for contacts, is beyond 2/ω; the automatic one,
/// 0.9 √(2m/2k), is not.
#[test]
fn the_automatic_time_step_is_stable_from_the_first_step_on() {
    let make = || {
        let centres = (0..5).map(|k| Vec3::new(0.1 + 0.2 * f64::from(k), 0.5, 0.5)).collect();
        let mut row = Particles::new(centres, vec![0.1005; 5], 2600.0);
        for (k, v) in row.velocity.iter_mut().enumerate() {
            v.x = 1e-4 * (-1f64).powi(k as i32);
        }
        let options = DemOptions::default();
        Dem::new(row, UNIT, material(), frictionless_walls(), options).unwrap()
    };
    let energy = |dem: &Dem| dem.kinetic_energy() + dem.elastic_energy();
    let mut dem = make();
    dem.compute_contacts().unwrap();
    let start = energy(&dem);
    let mut once = make();
    let blind = once.safe_time_step(0.9);
    let blew_up = (0..400).any(|_| once.step(blind).is_err() || energy(&once) > 2.0 * start);
    assert!(blew_up, "the blind step is stable: no test");
    for _ in 0..400 {
        assert!(dem.step_auto(0.9).unwrap() < 0.8 * blind);
        assert!((energy(&dem) / start - 1.0).abs() < 0.1, "{} {start}", energy(&dem));
    }
    assert!(dem.step_auto(0.0).is_err());
}
