//! Viscous damping by a coefficient of restitution.

mod dem_support;
mod law_support;

use std::f64::consts::PI;

use dem_support::{frictionless_walls, material, settled};
use dempfv::dem::law::{Granular, GranularEffects, Hertz, Restitution};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::{Aabb, Vec3, WallId};
use law_support::{BOX, same_bits};

const MATERIAL: Material =
    Material { young: 1e7, stiffness_ratio: 0.5, friction_angle: 0.0, density: 2600.0 };
const HERTZ: Hertz = Hertz { poisson_ratio: 0.25, wall_poisson_ratio: 0.25 };

fn law(hertz: bool, restitution: f64) -> GranularEffects {
    GranularEffects {
        hertz: hertz.then_some(HERTZ),
        restitution: Some(Restitution { spheres: restitution, walls: restitution }),
        ..GranularEffects::default()
    }
}

fn walls() -> WallMaterial {
    WallMaterial { young: MATERIAL.young, friction_angle: MATERIAL.friction_angle }
}

/// Steps until the contact has come and gone; no force pulled.
fn strike(dem: &mut Dem, dt: f64) {
    let mut seen = false;
    loop {
        dem.step(dt).unwrap();
        dem.compute_contacts().unwrap();
        match dem.contacts().next() {
            Some(contact) => {
                seen = true;
                let along = -dem.force(contact.i as usize).dot(&contact.normal);
                assert!(along >= 0.0, "{along}");
            }
            None if seen => return,
            None => {}
        }
    }
}

/// Speed after over speed before, of two spheres and of a sphere on a wall.
fn measured(hertz: bool, restitution: f64, wall: Option<WallId>) -> f64 {
    let (r, speed) = (0.1, 0.5);
    let mut p = match wall {
        None => {
            let x = vec![Vec3::new(4.8, 5.0, 5.0), Vec3::new(5.0501, 5.0, 5.0)];
            Particles::new(x, vec![r, 1.5 * r], MATERIAL.density)
        }
        Some(wall) => {
            let x = BOX.center() - (5.0 - r - 1e-4) * wall.inward_normal();
            Particles::new(vec![x], vec![r], MATERIAL.density)
        }
    };
    p.velocity[0] = wall.map_or(Vec3::x(), |w| -w.inward_normal()) * speed;
    // 1,000 steps for half a period of the undamped linear spring: the dashpot feels velocities
    // that are half a step old, which makes e smaller by ζ ω Δt/2 of |ln e| and more.
    let dt = PI * (p.mass[0] / (MATERIAL.young * r)).sqrt() / 1000.0;
    let law = law(hertz, restitution);
    let mut dem =
        Dem::with_effects(law, p, BOX, &[MATERIAL], walls(), DemOptions::default()).unwrap();
    strike(&mut dem, dt);
    match wall {
        None => (dem.velocity(1).x - dem.velocity(0).x) / speed,
        Some(wall) => dem.velocity(0).dot(&wall.inward_normal()) / speed,
    }
}

#[test]
fn restitution_is_what_was_asked_for() {
    for hertz in [false, true] {
        for restitution in [0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 0.95, 1.0] {
            for wall in [None, Some(WallId::YMin), Some(WallId::ZMax)] {
                let found = measured(hertz, restitution, wall);
                println!("{hertz} {restitution} {wall:?} {:.5}", found - restitution);
                assert!((found - restitution).abs() < 0.005, "{hertz} {restitution} {found}");
            }
        }
    }
}

/// An oblique impact that slides to its end: v_t' = v_t − μ (1 + e) v_n, and with I = 2/5 m R² the
/// spin is ω' R = 2.5 μ (1 + e) v_n.
#[test]
fn an_oblique_impact_slides() {
    let (r, young, friction) = (0.1, 1e9, 0.1f64);
    let [normal, across] = [1.0, 3.0];
    for hertz in [false, true] {
        for restitution in [0.3, 0.8, 1.0] {
            let rough = Material { young, friction_angle: friction.atan(), ..MATERIAL };
            let walls = WallMaterial { young, friction_angle: friction.atan() };
            let mut p = Particles::new(vec![Vec3::new(5.0, r + 1e-5, 5.0)], vec![r], rough.density);
            p.velocity[0] = Vec3::new(across, -normal, 0.0);
            let dt = PI * (p.mass[0] / (young * r)).sqrt() / 2000.0;
            let law = law(hertz, restitution);
            let mut dem =
                Dem::with_effects(law, p, BOX, &[rough], walls, DemOptions::default()).unwrap();
            strike(&mut dem, dt);
            let (v, spin) = (dem.velocity(0), dem.spin(0));
            let e = v.y / normal;
            let impulse = friction * (1.0 + e) * normal;
            println!("{hertz} {restitution} {:.5} {:.5}", v.x - across + impulse, spin.z);
            assert!((e - restitution).abs() < 0.005, "{hertz} {e}");
            assert!((v.x - (across - impulse)).abs() < 1e-3, "{hertz} {v} {impulse}");
            // The arm is R − δ/2, a little shorter.
            assert!((-spin.z * r / (2.5 * impulse) - 1.0).abs() < 0.01, "{hertz} {spin}");
        }
    }
}

/// At the automatic time step: stable for every restitution, and how near it comes.
#[test]
fn damped_contacts_are_stable_at_the_automatic_time_step() {
    for hertz in [false, true] {
        for restitution in [0.01, 0.1, 0.5, 0.9] {
            let rough = Material { friction_angle: 0.5, ..MATERIAL };
            let x = Vec3::new(5.0, 0.0999, 5.0);
            let mut p = Particles::new(vec![x], vec![0.1], rough.density);
            p.velocity[0] = Vec3::new(0.3, -0.5, 0.0);
            let gravity = Some(Vec3::new(0.0, -9.81, 0.0));
            let options = DemOptions { gravity, ..DemOptions::default() };
            let walls = WallMaterial { friction_angle: 0.5, ..walls() };
            let law = law(hertz, restitution);
            let mut dem = Dem::with_effects(law, p, BOX, &[rough], walls, options).unwrap();
            let start = dem.kinetic_energy();
            for _ in 0..20_000 {
                dem.step_auto(0.8).unwrap();
            }
            assert!(dem.kinetic_energy() < start, "{hertz} {restitution}");
            // It rolls on: the wall takes what bounces.
            assert!(dem.velocity(0).y.abs() < 1e-2, "{hertz} {restitution} {}", dem.velocity(0));
        }
    }
}

/// A servo knows that the dashpots on its wall feel each shift as a speed: it holds a sphere between
/// two walls at the stress that was asked for, with no other damping, however short the step and
/// however often contacts are computed in it.
#[test]
fn a_servo_holds_damped_contacts() {
    let stress = 1e3;
    for (restitution, safety) in [(0.9, 0.8), (0.5, 0.8), (0.5, 0.05)] {
        let space = Aabb { min: Vec3::zeros(), max: Vec3::new(0.2, 0.1999, 0.2) };
        let p = Particles::new(vec![Vec3::new(0.1, 0.1, 0.1)], vec![0.1], MATERIAL.density);
        let options = DemOptions { damping: 0.0, ..DemOptions::default() };
        let law = law(false, restitution);
        let mut dem = Dem::with_effects(law, p, space, &[MATERIAL], walls(), options).unwrap();
        let servo = WallControl::Servo { stress, max_velocity: None };
        dem.set_control(WallId::YMax, servo).unwrap();
        for _ in 0..40_000 {
            dem.step_auto(safety).unwrap();
        }
        for _ in 0..20 {
            dem.step_auto(safety).unwrap();
            dem.compute_contacts().unwrap();
            let off = dem.wall_stress(WallId::YMax) / stress - 1.0;
            assert!(off.abs() < 1e-2, "{restitution} {safety}: {off}");
        }
    }
}

/// A packing between dashpots alone, no local damping: the servo settles at the stress asked for
/// within 1 %, from 10 kPa to 12 kPa and to 2 kPa, and what its wall does is found again in the
/// ledger, to 1.2e-4 as without dashpots.
#[test]
fn a_servo_holds_a_damped_packing() {
    let made = settled(500, 1, DemOptions { damping: 0.2, ..DemOptions::default() });
    for restitution in [0.9, 0.5, 0.3] {
        for (stress, safety) in [(1.2e4, 0.8), (1.2e4, 0.2), (2e3, 0.8)] {
            let walls = frictionless_walls();
            let options = DemOptions { damping: 0.0, ..DemOptions::default() };
            let p = Particles { id: (0..500).collect(), ..made.storage().clone() };
            let law = law(false, restitution);
            let mut dem =
                Dem::with_effects(law, p, made.box_(), &[material()], walls, options).unwrap();
            dem.compute_contacts().unwrap();
            dem.track_energy(true);
            let servo = WallControl::Servo { stress, max_velocity: None };
            dem.set_control(WallId::YMax, servo).unwrap();
            for _ in 0..(4000.0 * 0.8 / safety) as usize {
                dem.step_auto(safety).unwrap();
            }
            let mut worst = 0.0f64;
            for _ in 0..200 {
                dem.step_auto(safety).unwrap();
                worst = worst.max((dem.wall_stress(WallId::YMax) / stress - 1.0).abs());
            }
            let b = dem.energy_balance().unwrap();
            let share = b.residual / b.moved();
            println!("{restitution} {stress} {safety}: {worst:e} {share:e}");
            assert!(worst < 1e-2, "{restitution} {stress} {safety}: {worst}");
            assert!(share.abs() < 2e-4, "{restitution} {stress} {safety}: {b:?}");
        }
    }
}

#[test]
fn a_damped_gas_conserves_momentum_and_bits() {
    same_bits(|| law(true, 0.7));
}

#[test]
fn no_restitution_is_refused() {
    for value in [0.0, -0.5, 1.1, f64::NAN] {
        for (spheres, walls, name) in
            [(value, 1.0, "restitution"), (1.0, value, "wall_restitution")]
        {
            let restitution = Some(Restitution { spheres, walls });
            let effects = GranularEffects { restitution, ..Default::default() };
            let DemError::Parameter { name: found, .. } = Granular::new(effects).unwrap_err()
            else {
                panic!("{value}")
            };
            assert_eq!(found, name);
        }
    }
}
