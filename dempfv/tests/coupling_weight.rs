//! A fluid with weight: hydrostatic pressure, buoyancy, and the flow that carries a bed.

mod common;
mod moving;

use std::f64::consts::PI;

use common::{Spheres, settled};
use dempfv::coupling::{Coupled, FluidEffects, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};
use moving::every;

const GRAVITY: f64 = 9.81;
const SOLID: f64 = 2600.0;
const WATER: f64 = 1000.0;

/// Spheres under gravity along -y in water, with this excess pressure below and none above.
fn bed(s: Spheres, pressure: f64, damping: f64) -> Coupled {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: SOLID };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let gravity = Some(Vec3::new(0.0, -GRAVITY, 0.0));
    let options = DemOptions { damping, gravity, ..DemOptions::default() };
    let particles = Particles::new(s.x, s.r, SOLID);
    let mut coupled =
        Coupled::new(Dem::new(particles, s.bounds, material, walls, options).unwrap());
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(pressure);
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    coupled.saturate(Saturation { fluid, solver: SolverKind::Cholmod, remesh: every(1000) });
    let density = Some(WATER);
    coupled.set_fluid_effects(FluidEffects { density, ..Default::default() });
    coupled
}

fn volume(radius: &[f64]) -> f64 {
    radius.iter().map(|r| 4.0 / 3.0 * PI * r.powi(3)).sum()
}

/// A column of five spheres, each on the one below, comes to rest: the base carries their weight less
/// that of the water in their place, to 1e-6 of it; the water is at rest, and its total pressure is
/// ρ_f g h.
#[test]
fn a_bed_at_rest_has_its_buoyant_weight() {
    let r = 0.05;
    let x = (0..5).map(|k| Vec3::new(0.1, r * (2.0 * f64::from(k) + 1.0), 0.1)).collect();
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::new(0.2, 0.6, 0.2) };
    let mut coupled = bed(Spheres { x, r: vec![r; 5], bounds }, 0.0, 0.5);
    for _ in 0..20_000 {
        coupled.step_auto(0.8).unwrap();
    }
    coupled.compute_contacts().unwrap();
    let weight = (SOLID - WATER) * GRAVITY * volume(&[r; 5]);
    let base = -coupled.dem().wall_force()[WallId::YMin].y;
    assert!((base / weight - 1.0).abs() < 1e-6, "{base} {weight}");
    let flow = coupled.storage_flow().unwrap();
    let hydrostatic = WATER * GRAVITY * 0.6;
    let below = flow.hydrostatic_pressure(&Vec3::new(0.1, 0.0, 0.1));
    assert!((below / hydrostatic - 1.0).abs() < 1e-12, "{below}");
    assert_eq!(flow.hydrostatic_pressure(&Vec3::new(0.0, 0.6, 0.2)), 0.0);
    assert!(flow.pressure().iter().all(|p| p.abs() < 1e-6 * hydrostatic));
}

/// At the critical gradient, (ρ_s − ρ_f) g V / (A L) as excess pressure over length, the flow carries
/// the bed: drag and buoyancy on all spheres together are their weight, to 1e-6 of it; at half of
/// it, half of the buoyant weight stays.
#[test]
fn an_upward_flow_carries_the_bed_at_the_critical_gradient() {
    let s = settled();
    let volume = volume(&s.r);
    let buoyant = (SOLID - WATER) * GRAVITY * volume;
    let critical = buoyant / s.bounds.wall_area(WallId::YMin);
    for share in [0.0, 0.5, 1.0] {
        let mut coupled = bed(settled(), share * critical, 0.0);
        // A short step: the spheres do not move yet.
        coupled.step(1e-12).unwrap();
        let lift: f64 = coupled.fluid_force().iter().map(|f| f.y).sum();
        let left = SOLID * GRAVITY * volume - lift;
        let off = left - (1.0 - share) * buoyant;
        assert!(off.abs() < 1e-6 * buoyant, "{share}: {}", off / buoyant);
    }
}
