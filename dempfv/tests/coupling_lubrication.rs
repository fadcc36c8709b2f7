//! Films that are squeezed out between spheres and at walls, and what touches in them.

mod common;
mod lubrication_support;

use std::f64::consts::PI;

use dempfv::coupling::{Coupled, EdgeEffects, Saturation};
use dempfv::dem::{DemOptions, WallControl};
use dempfv::pfv::Fluid;
use dempfv::{Aabb, Vec3, WallId};
use lubrication_support::{DENSITY, NONE, around, open, spheres, wet};

/// Radius of the spheres (m), the modulus of their springs (Pa), viscosity of the fluid (Pa·s).
const R: f64 = 0.01;
const YOUNG: f64 = 4e8;
const VISCOSITY: f64 = 1e3;

fn squeezed(roughness: f64) -> EdgeEffects {
    EdgeEffects { normal_lubrication: true, roughness, ..NONE }
}

/// Two spheres with this gap, about the origin, walls a million radii away.
fn pair(gap: f64, every: u64, edges: EdgeEffects) -> Coupled {
    let half = R + 0.5 * gap;
    let x = [Vec3::new(-half, 0.0, 0.0), Vec3::new(half, 0.0, 0.0)];
    let dem = spheres(&x, &[R, R], around(1e6 * R), YOUNG, DemOptions::default());
    wet(dem, open(VISCOSITY, every), edges)
}

fn gap(coupled: &Coupled) -> f64 {
    (coupled.dem().position(1) - coupled.dem().position(0)).norm() - 2.0 * R
}

/// A step of length `dt` (s) in which a force pushes the two together (N).
fn push(coupled: &mut Coupled, force: f64, dt: f64) {
    let mut controls = coupled.controls();
    controls.add_force(0, Vec3::new(force, 0.0, 0.0));
    controls.add_force(1, Vec3::new(-force, 0.0, 0.0));
    coupled.step(dt).unwrap();
}

/// A constant force F on a film of c = 3/2 π μ R² / h closes it by dh/dt = −F h / (3/2 π μ R²). With
/// F = 4/3 π μ R² / τ (the weight of one of the spheres where τ = μ / (ρ g R)) that is
/// h = h₀ exp(−8t / 9τ); h is the gap and the roughness of both surfaces. Within 1e-5 of R.
#[test]
fn the_approach_of_two_spheres() {
    const TAU: f64 = 10.0;
    let force = 4.0 / 3.0 * PI * VISCOSITY * R * R / TAU;
    let dt = 5e-5;
    for roughness in [0.0, 1e-2] {
        let rough = 2.0 * roughness * R;
        let expected = |t: f64| (R + rough) * (-8.0 / 9.0 * t / TAU).exp() - rough;
        let mut coupled = pair(R, 1_000_000, squeezed(roughness));
        // The velocities that it has without inertia.
        let speed = 0.5 * 8.0 / 9.0 * (R + rough) / TAU;
        for v in coupled.controls().storage_velocities_mut().0.iter_mut() {
            *v = Vec3::new(speed, 0.0, 0.0);
        }
        let second = coupled.dem().storage_index(1);
        coupled.controls().storage_velocities_mut().0[second].x = -speed;
        let mut worst = 0.0f64;
        for step in 1..=200_000 {
            push(&mut coupled, force, dt);
            worst = worst.max((gap(&coupled) - expected(f64::from(step) * dt)).abs());
        }
        println!("roughness {roughness}: {:e} of R", worst / R);
        assert!(worst < 1e-5 * R, "{roughness}: {:e}", worst / R);
    }
}

/// Spheres that are pressed together until they overlap, and pulled apart again, through rough and
/// ideally smooth surfaces: the film's force stays finite and below what moves the spheres and their
/// inertia. The film and its spring settle in 10⁻⁵ s at first: steps below and above that.
#[test]
fn a_film_at_gap_zero_and_below_is_finite() {
    for roughness in [0.0, 1e-6, 1e-2] {
        for dt in [1e-6, 2e-5] {
            let mut coupled = pair(1e-5 * R, 1_000, squeezed(roughness));
            coupled.controls().track_energy(true);
            let force = 100.0;
            let (mut least, mut largest) = (f64::INFINITY, 0.0f64);
            let steps = (0.02 / dt) as u32;
            for step in 0..steps {
                push(&mut coupled, if step < steps / 2 { force } else { -force }, dt);
                least = least.min(gap(&coupled));
                let f = coupled.fluid_force();
                assert!(f.iter().all(|f| f.iter().all(|c| c.is_finite())), "{roughness} {dt}");
                assert!((f[0] + f[1]).norm() < 1e-6 * force, "{f:?}");
                largest = largest.max(f[0].norm());
            }
            let b = coupled.dem().energy_balance().unwrap();
            assert!(least < 0.0, "{roughness} {dt}: never touched: {least:e}");
            assert!(largest < 5.0 * force, "{roughness} {dt}: {largest}");
            assert!(b.normal_lubrication > 0.0 && b.viscous_shear == 0.0, "{b:?}");
            println!("{roughness} {dt:e}: gap {:e} R, {largest} N, {b:?}", least / R);
        }
    }
}

/// The film goes on as it is where a network comes in the place of another: the bits are those of a run
/// with one network.
#[test]
fn a_film_outlives_its_network() {
    let run = |every: u64| {
        let mut coupled = pair(1e-3 * R, every, squeezed(0.0));
        let mut seen = vec![];
        for step in 0..400 {
            push(&mut coupled, if step < 200 { 1.0 } else { -1.0 }, 5e-5);
            seen.push(coupled.dem().position(0).x.to_bits());
        }
        (seen, coupled.remeshes())
    };
    let (one, seven) = (run(1_000), run(7));
    assert!(one.1 == 1 && seven.1 > 50);
    assert!(one.0 == seven.0);
}

/// A sphere that sinks onto a wall: h = h₀ exp(−F t / c h) with c h = 3/2 π μ R² where the fluid slips
/// along the wall (its image comes to meet it), 6 π μ R² where the wall holds it (Taylor). What the
/// sphere weighs more than it moves, the wall carries. The other walls are far: 1e-4.
#[test]
fn a_sphere_sinks_onto_a_wall() {
    for (slip_walls, factor) in [(true, 1.5), (false, 6.0)] {
        let far = 1e5 * R;
        let bounds = Aabb { min: Vec3::new(-far, 0.0, -far), max: Vec3::new(far, 2.0 * far, far) };
        let (g, h) = (9.81, 0.1 * R);
        let weight = DENSITY * 4.0 / 3.0 * PI * R.powi(3) * g;
        let gravity = Some(Vec3::new(0.0, -g, 0.0));
        let x = [Vec3::new(0.0, R + h, 0.0)];
        let dem = spheres(&x, &[R], bounds, YOUNG, DemOptions { gravity, ..DemOptions::default() });
        let saturation = open(VISCOSITY, 1_000_000);
        let fluid = Fluid { slip_walls, ..saturation.fluid };
        let mut coupled = wet(dem, Saturation { fluid, ..saturation }, squeezed(0.0));
        let rate = weight / (factor * PI * VISCOSITY * R * R);
        coupled.controls().storage_velocities_mut().0[0].y = -rate * h;
        let (dt, steps) = (5e-5, 20_000);
        for _ in 0..steps {
            coupled.step(dt).unwrap();
        }
        let time = dt * f64::from(steps);
        let left = coupled.dem().position(0).y - R;
        let expected = h * (-rate * time).exp();
        assert!((left - expected).abs() < 1e-4 * h, "{slip_walls}: {left} {expected}");
        let stress = coupled.wall_stress(WallId::YMin);
        let carried = stress * bounds.wall_area(WallId::YMin);
        assert!((carried / weight - 1.0).abs() < 1e-3, "{carried} {weight}");
    }
}

/// A servo holds its stress against films alone: a wall pressed on spheres that it does not touch yet,
/// and then on those that it does.
#[test]
fn a_servo_presses_on_films() {
    let r = 0.01;
    let x: Vec<Vec3> = (0..9)
        .map(|k| {
            Vec3::new(f64::from(k % 3), 0.0, f64::from(k / 3)) * 2.2 * r + Vec3::repeat(1.1 * r)
        })
        .collect();
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::new(6.6, 2.25, 6.6) * r };
    let options = DemOptions { damping: 0.1, ..DemOptions::default() };
    let dem = spheres(&x, &[r; 9], bounds, 1e7, options);
    let mut coupled = wet(dem, open(10.0, 500), squeezed(1e-3));
    let control = WallControl::Servo { stress: 500.0, max_velocity: None };
    coupled.controls().set_control(WallId::YMax, control).unwrap();
    let mut worst = 0.0f64;
    for step in 0..40_000 {
        coupled.step_auto(0.8).unwrap();
        if step > 10_000 {
            worst = worst.max((coupled.wall_stress(WallId::YMax) / 500.0 - 1.0).abs());
        }
    }
    assert!(coupled.dem().wall_contact_count() > 0, "the premise: it has come to touch");
    assert!(worst < 0.02, "{worst}");
}
