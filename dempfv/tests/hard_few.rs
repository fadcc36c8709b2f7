//! Hard case 11: few spheres, spheres in a line, in a plane, on a sphere, and rattlers. Dry and wet
//! runs step on with a finite time step, or are refused in words.

mod common;

use common::unit_box;
use dempfv::Vec3;
use dempfv::WallId;
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;

/// Arrangements of spheres in a unit box.
fn arrangements() -> Vec<(&'static str, Vec<Vec3>, f64)> {
    let at = |x, y, z| Vec3::new(x, y, z);
    let few = [at(0.3, 0.4, 0.6), at(0.7, 0.5, 0.4), at(0.5, 0.75, 0.55), at(0.4, 0.2, 0.3)];
    let line = |k: usize| at(0.1 + 0.2 * k as f64, 0.5, 0.5);
    let diagonal = |k: usize| Vec3::repeat(0.1 + 0.2 * k as f64);
    let plane = |k: usize| at(0.2 + 0.2 * (k % 4) as f64, 0.5, 0.2 + 0.2 * (k / 4) as f64);
    let tilted = |k: usize| {
        let (a, b) = (0.1 * (k % 4) as f64, 0.1 * (k / 4) as f64);
        at(0.3 + a, 0.4 + 0.5 * a - 0.3 * b, 0.3 + b)
    };
    // Spread over a sphere along a spiral of golden angles.
    let ball = |k: usize| {
        let z = -0.95 + 0.1 * k as f64;
        let (angle, r) = (2.399_963_229_728_653 * k as f64, (1.0 - z * z).sqrt());
        at(0.5 + 0.35 * r * angle.cos(), 0.5 + 0.35 * r * angle.sin(), 0.5 + 0.35 * z)
    };
    vec![
        ("one", few[..1].to_vec(), 0.1),
        ("two", few[..2].to_vec(), 0.1),
        ("three", few[..3].to_vec(), 0.1),
        ("four", few.to_vec(), 0.1),
        ("one in the middle", vec![Vec3::repeat(0.5)], 0.5),
        ("in a line", (0..5).map(line).collect(), 0.1),
        ("on a diagonal", (0..5).map(diagonal).collect(), 0.1),
        ("in a plane", (0..16).map(plane).collect(), 0.1),
        ("in a tilted plane", (0..16).map(tilted).collect(), 0.04),
        ("on a sphere", (0..20).map(ball).collect(), 0.05),
        ("far from each other", few.to_vec(), 1e-4),
    ]
}

fn coupled(x: Vec<Vec3>, r: f64, wet: bool) -> Coupled {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let radius = vec![r; x.len()];
    let spheres = Particles::new(x, radius, material.density);
    let gravity = Some(Vec3::new(0.0, -9.81, 0.0));
    let options = DemOptions { damping: 0.2, gravity, ..DemOptions::default() };
    let dem = Dem::new(spheres, unit_box(1.0), material, walls, options).unwrap();
    let mut coupled = Coupled::new(dem);
    if wet {
        let mut boundary = Boundary::default();
        boundary.pressure[WallId::YMax] = Some(0.0);
        let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
        let remesh = RemeshRule { interval: Some(10), strain: None };
        coupled.saturate(Saturation { fluid, solver: SolverKind::default(), remesh });
    }
    coupled
}

/// Spheres fall by what gravity and the fluid make of them, and no step is longer than a fall
/// through the box.
#[test]
fn few_spheres_step_on() {
    for wet in [false, true] {
        for (name, x, r) in arrangements() {
            let mut coupled = coupled(x, r, wet);
            for step in 0..50 {
                let dt = coupled
                    .step_auto(0.8)
                    .unwrap_or_else(|e| panic!("{name}, wet {wet}, step {step}: {e}"));
                assert!(dt > 0.0 && dt < 0.5, "{name}, wet {wet}: {dt}");
            }
            let p = coupled.dem().storage();
            let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
            assert!(p.position.iter().chain(&p.velocity).all(finite), "{name}, wet {wet}");
            let seen = coupled.observe();
            assert!(
                seen.kinetic_energy > 0.0 && seen.kinetic_energy.is_finite(),
                "{name}, wet {wet}"
            );
            assert!(seen.mean_pressure.is_finite() && seen.flux.iter().all(|q| q.is_finite()));
        }
    }
}

/// Without a sphere a step of a given length passes, the automatic one and a fluid are refused.
#[test]
fn no_sphere_is_refused_in_words() {
    let mut dry = coupled(vec![], 0.1, false);
    dry.step(1e-3).unwrap();
    let error = dry.step_auto(0.8).unwrap_err().to_string();
    assert!(error.contains("time step = inf"), "{error}");
    let mut wet = coupled(vec![], 0.1, true);
    let error = wet.step(1e-3).unwrap_err().to_string();
    assert!(error.contains("no spheres"), "{error}");
}

/// A sphere without contacts among others that carry a load: it has no part in the bound of the
/// time step but its own, and stays where it is.
#[test]
fn a_rattler_stays_and_costs_no_time_step() {
    // A column that two walls squeeze, and a sphere beside it.
    let column = |k: usize| Vec3::new(0.5, 0.1 + 0.2 * k as f64, 0.5);
    let x: Vec<Vec3> = (0..5).map(column).chain([Vec3::new(0.8, 0.5, 0.8)]).collect();
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let with = |count: usize| {
        let spheres = Particles::new(x[..count].to_vec(), vec![0.1; count], material.density);
        let options = DemOptions { damping: 0.2, ..DemOptions::default() };
        let mut dem = Dem::new(spheres, unit_box(1.0), material, walls, options).unwrap();
        let servo = WallControl::Servo { stress: 100.0, max_velocity: Some(0.01) };
        dem.set_control(WallId::YMax, servo).unwrap();
        let steps: Vec<f64> = (0..200).map(|_| dem.step_auto(0.8).unwrap()).collect();
        (dem, steps)
    };
    let ((dem, steps), (_, without)) = (with(6), with(5));
    assert_eq!(dem.position(5), x[5]);
    assert!(steps == without);
    assert!(dem.wall_stress(WallId::YMax) > 0.0);
}
