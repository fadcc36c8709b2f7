//! Hertz-Mindlin contacts against closed forms and a published benchmark.

mod dem_support;
mod law_support;

use dem_support::frictionless_walls;
use dempfv::dem::law::{Granular, GranularEffects, Hertz};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles, WallMaterial};
use dempfv::{Vec3, WallId};
use law_support::{BOX, collide, energy, hertz, same_bits};

const GLASS: Material =
    Material { young: 48e9, stiffness_ratio: 0.0, friction_angle: 0.0, density: 2800.0 };
const LIMESTONE: Material = Material { young: 20e9, density: 2500.0, ..GLASS };

/// A material of the benchmark with Poisson's ratio, and largest overlap (m), largest force (N)
/// and duration (s) of the collision of two spheres of 10 mm at 10 m/s each.
type Row = (Material, f64, [f64; 3]);

/// Y. C. Chung, J. Y. Ooi: Benchmark tests for verifying discrete element modelling codes at
/// particle impact level, Granular Matter 13 (2011), test 1.
const BENCHMARK: [Row; 2] = [
    (GLASS, 0.2, [274.1e-6, 10.697e3, 40.35e-6]),
    (LIMESTONE, 0.25, [368.3e-6, 7.108e3, 54.21e-6]),
];

/// Two spheres of the benchmark on their way.
fn pair(material: Material, poisson_ratio: f64) -> Dem {
    let r = 0.01;
    let x = vec![Vec3::new(4.98, 5.0, 5.0), Vec3::new(5.0005, 5.0, 5.0)];
    let mut p = Particles::new(x, vec![r; 2], material.density);
    p.velocity[0].x = 10.0;
    p.velocity[1].x = -10.0;
    let walls = WallMaterial { young: material.young, friction_angle: 0.0 };
    let options = DemOptions::default();
    Dem::with_effects(hertz(poisson_ratio), p, BOX, &[material], walls, options).unwrap()
}

/// The four digits of the benchmark, at 2,000 steps a collision.
#[test]
fn two_spheres_collide_as_published() {
    for (material, poisson_ratio, [overlap, force, duration]) in BENCHMARK {
        let mut dem = pair(material, poisson_ratio);
        let found = collide(&mut dem, duration / 2000.0);
        println!("{found:?}");
        assert!((found.overlap / overlap - 1.0).abs() < 2e-4, "{found:?}");
        assert!((found.force / force - 1.0).abs() < 2e-4, "{found:?}");
        assert!((found.duration / duration - 1.0).abs() < 1e-3, "{found:?}");
        // They part as they came.
        assert!((dem.velocity(0).x / -10.0 - 1.0).abs() < 1e-5, "{}", dem.velocity(0));
    }
}

/// A sphere against a wall of another material, by the closed forms
/// δ = (15 m v² / 16 E* √R)^(2/5), F = 4/3 E* √R δ^(3/2), T = 2.9432 δ / v (Johnson 1985, 11.1).
#[test]
fn a_sphere_strikes_a_wall() {
    for wall in WallId::ALL {
        let (r, v, wall_young, wall_poisson) = (0.01, 10.0, 70e9, 0.3);
        let normal = wall.inward_normal();
        let centre = BOX.center() - (5.0 - r - 1e-4) * normal;
        let mut p = Particles::new(vec![centre], vec![r], GLASS.density);
        p.velocity[0] = -v * normal;
        let m = p.mass[0];
        let walls = WallMaterial { young: wall_young, friction_angle: 0.0 };
        let effects = GranularEffects {
            hertz: Some(Hertz { poisson_ratio: 0.2, wall_poisson_ratio: wall_poisson }),
            ..GranularEffects::default()
        };
        let mut dem =
            Dem::with_effects(effects, p, BOX, &[GLASS], walls, DemOptions::default()).unwrap();
        let modulus = 1.0 / (0.96 / 48e9 + 0.91 / wall_young);
        let overlap = (15.0 * m * v * v / (16.0 * modulus * r.sqrt())).powf(0.4);
        let force = 4.0 / 3.0 * modulus * r.sqrt() * overlap.powf(1.5);
        let duration = 2.943_28 * overlap / v;
        let found = collide(&mut dem, duration / 2000.0);
        assert!((found.overlap / overlap - 1.0).abs() < 1e-5, "{wall} {found:?} {overlap}");
        assert!((found.force / force - 1.0).abs() < 1e-5, "{wall} {found:?} {force}");
        assert!((found.duration / duration - 1.0).abs() < 1e-3, "{wall} {found:?} {duration}");
    }
}

/// Half the time step, a quarter of the error of the energy: kinetic, of the velocities at the time
/// of the positions, and elastic, W = 2/5 F δ, in the middle of a collision.
#[test]
fn energy_is_conserved_to_second_order() {
    let duration = 40.35e-6;
    let error = |steps: f64| {
        let (mut dem, dt) = (pair(GLASS, 0.2), duration / steps);
        let start = dem.kinetic_energy();
        let mut worst = 0.0f64;
        for _ in 0..(2.0 * steps) as usize {
            dem.step(dt).unwrap();
            dem.compute_contacts().unwrap();
            worst = worst.max((energy(&dem, dt) / start - 1.0).abs());
        }
        assert!(worst > 0.0 && dem.sphere_contact_count() == 0);
        worst
    };
    let [coarse, middle, fine] = [50.0, 100.0, 200.0].map(error);
    println!("{coarse:e} {middle:e} {fine:e}");
    for ratio in [coarse / middle, middle / fine] {
        assert!((3.5..4.5).contains(&ratio), "{coarse:e} {middle:e} {fine:e}");
    }
}

/// Mindlin: a contact pressed to δ and sheared by s has the shear force 8 G* √(R* δ) s, G* = G /
/// 2(2 − ν) of two spheres of one material; and Coulomb's limit.
#[test]
fn shear_is_mindlins() {
    let (r, overlap, slip, dt) = (0.01, 1e-5, 1e-7, 1e-6);
    let rough = Material { friction_angle: 0.5, ..GLASS };
    for (path, cut) in [(slip, false), (1e3 * slip, true)] {
        let x = vec![Vec3::new(4.98 + overlap, 5.0, 5.0), Vec3::new(5.0, 5.0, 5.0)];
        let mut p = Particles::new(x, vec![r; 2], GLASS.density);
        // So heavy that only the motion given counts.
        p.mass.fill(1e30);
        p.velocity[1].y = path / (10.0 * dt);
        let walls = frictionless_walls();
        let options = DemOptions { rotation: false, ..DemOptions::default() };
        let mut dem = Dem::with_effects(hertz(0.2), p, BOX, &[rough], walls, options).unwrap();
        for _ in 0..10 {
            dem.step(dt).unwrap();
        }
        dem.compute_contacts().unwrap();
        let contact = dem.contacts().next().unwrap();
        let shear_modulus = 48e9 / 2.4 / (2.0 * 1.8);
        let stiffness = 8.0 * shear_modulus * (0.005 * overlap).sqrt();
        let limit = 0.5f64.tan() * contact.normal_force;
        let expected = if cut { limit } else { stiffness * path };
        assert!(stiffness * slip < limit && limit < stiffness * 1e3 * slip);
        let found = contact.shear.norm();
        assert!((found / expected - 1.0).abs() < 1e-3, "{cut} {found} {expected}");
    }
}

/// Pressed, sheared, let go half way and sheared back: the energy put in is never less than what
/// comes out. With the shear force kept on unloading, more would come out.
#[test]
fn a_cycle_of_shear_and_pressure_gains_nothing() {
    let (r, dt) = (0.01, 1e-7);
    let rough = Material { friction_angle: 1.4, ..GLASS };
    let x = vec![Vec3::new(4.98, 5.0, 5.0), Vec3::new(4.9999, 5.0, 5.0)];
    let mut p = Particles::new(x, vec![r; 2], GLASS.density);
    p.mass.fill(1e30);
    let walls = frictionless_walls();
    let options = DemOptions { rotation: false, ..DemOptions::default() };
    let mut dem = Dem::with_effects(hertz(0.2), p, BOX, &[rough], walls, options).unwrap();
    let mut work = 0.0;
    // Press by 100 µm more, shear by 10 µm, back by 150 µm, shear back, press again.
    for (vx, vy) in [(-1.0, 0.0), (0.0, 0.1), (1.5, 0.0), (0.0, -0.1), (-0.5, 0.0)] {
        let steps = 1000;
        for _ in 0..steps {
            dem.set_velocity(1, Vec3::new(vx, vy, 0.0));
            dem.compute_contacts().unwrap();
            let before = dem.force(1);
            dem.integrate(dt, None, None).unwrap();
            dem.compute_contacts().unwrap();
            // What moves the sphere does the opposite of the contact's work.
            work -= 0.5 * dt * (before + dem.force(1)).dot(&Vec3::new(vx, vy, 0.0));
        }
    }
    println!("{work:e}");
    assert!(work > 0.0, "{work}");
}

/// The automatic time step knows how stiff the contact becomes: a collision takes 16 steps at
/// least, of those so fast that their overlap is above a hundredth of the radius too.
#[test]
fn a_collision_takes_sixteen_steps() {
    for speed in [0.1, 1.0, 10.0, 40.0] {
        let mut dem = pair(GLASS, 0.2);
        dem.set_velocity(0, Vec3::new(speed, 0.0, 0.0));
        dem.set_velocity(1, Vec3::new(-speed, 0.0, 0.0));
        let (mut steps, mut seen, start) = (0, false, dem.kinetic_energy());
        loop {
            dem.step_auto(0.8).unwrap();
            let touching = dem.sphere_contact_count() > 0;
            steps += usize::from(touching);
            seen |= touching;
            if seen && !touching {
                break;
            }
        }
        let gain = dem.kinetic_energy() / start - 1.0;
        println!("{speed} {steps} {gain:e}");
        assert!(steps >= 16, "{speed}: {steps}");
        assert!(gain.abs() < 1e-3, "{speed}: {gain:e}");
    }
}

/// A gas with friction and spin: momentum and angular momentum stay, to round-off; threads and
/// restarts change no bit.
#[test]
fn a_gas_conserves_momentum_and_bits() {
    same_bits(|| hertz(0.25));
}

#[test]
fn wrong_constants_are_refused() {
    for ratio in [-1.0, 0.51, f64::NAN] {
        for (first, second, name) in
            [(ratio, 0.2, "poisson_ratio"), (0.2, ratio, "wall_poisson_ratio")]
        {
            let hertz = Some(Hertz { poisson_ratio: first, wall_poisson_ratio: second });
            let error = Granular::new(GranularEffects { hertz, ..Default::default() }).unwrap_err();
            let DemError::Parameter { name: found, .. } = error else { panic!("{error}") };
            assert_eq!(found, name);
        }
    }
}
