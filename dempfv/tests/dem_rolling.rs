//! Resistance against rolling and twisting.

mod dem_support;
mod law_support;

use dempfv::Vec3;
use dempfv::dem::law::{Granular, GranularEffects, Hertz, Resistance};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles, WallMaterial};
use law_support::{BOX, same_bits};

const FRICTION: f64 = 0.05;
const RESISTANCE: Resistance =
    Resistance { friction: FRICTION, stiffness_ratio: 0.5, damping_ratio: 0.3 };
const YOUNG: f64 = 1e8;
const RADIUS: f64 = 0.1;
const WEIGHT: f64 = 9.81;

fn law(rolling: bool, twisting: bool) -> GranularEffects {
    GranularEffects {
        rolling: rolling.then_some(RESISTANCE),
        twisting: twisting.then_some(RESISTANCE),
        ..GranularEffects::default()
    }
}

/// A sphere at rest on the wall y_min, under gravity that leans by this angle towards x.
fn on_the_floor(law: GranularEffects, slope: f64) -> Dem {
    let rough =
        Material { young: YOUNG, stiffness_ratio: 0.5, friction_angle: 0.7, density: 2600.0 };
    let walls = WallMaterial { young: YOUNG, friction_angle: 0.7 };
    let mut p = Particles::new(vec![Vec3::new(2.0, RADIUS, 5.0)], vec![RADIUS], rough.density);
    p.position[0].y -= p.mass[0] * WEIGHT * slope.cos() / (YOUNG * RADIUS);
    let gravity = Some(WEIGHT * Vec3::new(slope.sin(), -slope.cos(), 0.0));
    let options = DemOptions { gravity, ..DemOptions::default() };
    Dem::with_effects(law, p, BOX, &[rough], walls, options).unwrap()
}

fn time_step(dem: &Dem) -> f64 {
    0.05 * (dem.mass(0) / (YOUNG * RADIUS)).sqrt()
}

/// Rolling without slip is braked by M = μ_r R F_n: 7/5 m R a = M, so that a sphere that begins
/// with v goes v² / 2a, a = 5/7 μ_r g, and stays there.
#[test]
fn a_rolling_sphere_comes_to_rest() {
    let mut dem = on_the_floor(law(true, false), 0.0);
    let (v, dt) = (0.5, time_step(&dem));
    dem.set_velocity(0, Vec3::new(v, 0.0, 0.0));
    dem.set_spin(0, Vec3::new(0.0, 0.0, -v / RADIUS));
    let brake = 5.0 / 7.0 * FRICTION * WEIGHT;
    let start = dem.position(0).x;
    for _ in 0..(1.5 * v / brake / dt) as usize {
        dem.step(dt).unwrap();
    }
    let way = (dem.position(0).x - start) / (v * v / (2.0 * brake));
    println!("{way} {:e}", dem.velocity(0).norm());
    assert!((way - 1.0).abs() < 2e-3, "{way}");
    assert!(dem.velocity(0).norm() < 1e-3 * v);
    // Without resistance it rolls on.
    let mut dem = on_the_floor(GranularEffects::default(), 0.0);
    dem.set_velocity(0, Vec3::new(v, 0.0, 0.0));
    dem.set_spin(0, Vec3::new(0.0, 0.0, -v / RADIUS));
    for _ in 0..1000 {
        dem.step(dt).unwrap();
    }
    assert!((dem.velocity(0).x / v - 1.0).abs() < 1e-3);
}

/// An incline: below tan θ = μ_r a sphere stays, above it rolls with 5/7 g (sin θ − μ_r cos θ).
#[test]
fn a_slope_below_the_limit_holds_a_sphere() {
    for (share, rolls) in [(0.95, false), (1.05, true), (2.0, true)] {
        let slope = f64::atan(share * FRICTION);
        let mut dem = on_the_floor(law(true, false), slope);
        let dt = time_step(&dem);
        // The spring gives way first, and swings.
        let settle = 0.2;
        for _ in 0..(settle / dt) as usize {
            dem.step(dt).unwrap();
        }
        let (before, time) = (dem.velocity(0).x, 0.5);
        for _ in 0..(time / dt) as usize {
            dem.step(dt).unwrap();
        }
        let found = (dem.velocity(0).x - before) / time;
        let expected = 5.0 / 7.0 * WEIGHT * (slope.sin() - FRICTION * slope.cos());
        println!("{share} {found:e} {expected:e} {:e}", dem.velocity(0).x);
        if rolls {
            assert!((found / expected - 1.0).abs() < 0.02, "{share}: {found} {expected}");
        } else {
            assert!(dem.velocity(0).x.abs() < 1e-5, "{share}: {}", dem.velocity(0));
        }
    }
}

/// A sphere that spins about the normal is braked by M = μ_t R F_n: it stops after
/// 2/5 R ω / (μ_t g). Neither rolling resistance nor sliding friction does that.
#[test]
fn a_spinning_sphere_comes_to_rest() {
    let spin = 5.0;
    let time = 0.4 * RADIUS * spin / (FRICTION * WEIGHT);
    let after = |law: GranularEffects, time: f64| {
        let mut dem = on_the_floor(law, 0.0);
        let dt = time_step(&dem);
        dem.set_spin(0, Vec3::new(0.0, spin, 0.0));
        for _ in 0..(time / dt) as usize {
            dem.step(dt).unwrap();
        }
        dem.spin(0).y / spin
    };
    for share in [0.25, 0.5, 0.75] {
        let left = after(law(false, true), share * time);
        assert!((left - (1.0 - share)).abs() < 1e-3, "{share} {left}");
    }
    let left = after(law(true, true), 1.5 * time);
    assert!(left.abs() < 1e-3, "{left}");
    assert_eq!(after(law(true, false), time), 1.0);
}

/// The springs alone: half the time step, a quarter of the error of the energy of a sphere that
/// swings on them.
#[test]
fn the_springs_keep_energy() {
    let elastic = Resistance { friction: 1e3, damping_ratio: 0.0, ..RESISTANCE };
    let drift = |refinement: f64| {
        let law = GranularEffects {
            rolling: Some(elastic),
            twisting: Some(elastic),
            ..GranularEffects::default()
        };
        let mut dem = on_the_floor(law, 0.0);
        let dt = time_step(&dem) / refinement;
        dem.set_spin(0, Vec3::new(0.0, 0.5, 0.01));
        let mut range = [f64::INFINITY, 0.0f64];
        for step in 0..(400.0 * refinement) as usize {
            dem.step(dt).unwrap();
            dem.compute_contacts().unwrap();
            if step > 10 {
                let energy =
                    law_support::energy(&dem, dt) + dem.mass(0) * WEIGHT * dem.position(0).y;
                range = [range[0].min(energy), range[1].max(energy)];
            }
        }
        range[1] - range[0]
    };
    let [coarse, fine] = [1.0, 2.0].map(drift);
    println!("{coarse:e} {fine:e}");
    assert!((3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn a_gas_that_resists_conserves_momentum_and_bits() {
    same_bits(|| law(true, true));
    same_bits(|| GranularEffects {
        hertz: Some(Hertz { poisson_ratio: 0.25, wall_poisson_ratio: 0.25 }),
        rolling: Some(RESISTANCE),
        ..GranularEffects::default()
    });
}

#[test]
fn wrong_resistances_are_refused() {
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        for (bad, name) in [
            (Resistance { friction: value, ..RESISTANCE }, "rolling friction"),
            (Resistance { stiffness_ratio: value, ..RESISTANCE }, "rolling stiffness_ratio"),
            (Resistance { damping_ratio: value, ..RESISTANCE }, "rolling damping_ratio"),
        ] {
            let effects = GranularEffects { rolling: Some(bad), ..Default::default() };
            let error = Granular::new(effects).unwrap_err();
            assert!(matches!(error, DemError::Parameter { name: n, .. } if n == name), "{error}");
        }
    }
}
