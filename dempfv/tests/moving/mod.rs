//! Loose spheres that fly about in a fluid, so that every network differs from
//! the one before.
#![allow(dead_code, reason = "every test file uses some of these")]

use dempfv::coupling::{Acceleration, RemeshMode};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

use crate::common::{Random, Spheres, cubic};

/// Time step of [`moving`] (s).
pub const DT: f64 = 1e-3;

pub fn every(steps: u64) -> RemeshRule {
    RemeshRule { interval: Some(steps), strain: None }
}

pub fn mode(remesh: RemeshMode) -> Acceleration {
    Acceleration { remesh, ..Acceleration::default() }
}

/// Water that leaves through the top.
pub fn drained(viscosity: f64, remesh: RemeshRule) -> Saturation {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary };
    Saturation { fluid, solver: SolverKind::default(), remesh }
}

/// Spheres at rest.
pub fn dem_of(s: Spheres) -> Dem {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let particles = Particles::new(s.x, s.r, material.density);
    Dem::new(particles, s.bounds, material, walls, DemOptions::default()).unwrap()
}

/// `n`³ spheres of 0.4 m that fly about at some 0.5 m/s under a servo wall: they move
/// by a thousandth of their radius in a step.
pub fn flying(n: usize) -> Dem {
    let mut s = cubic(n, 0.1);
    s.r.iter_mut().for_each(|r| *r *= 0.8);
    let mut dem = dem_of(s);
    let mut random = Random(5);
    for v in dem.storage_velocities_mut().0 {
        *v = 0.5 * random.vector();
    }
    dem.set_control(WallId::YMax, WallControl::Servo { stress: 100.0, max_velocity: Some(0.1) })
        .unwrap();
    dem
}

/// [`flying`] spheres in a fluid.
pub fn moving(n: usize, rule: RemeshRule, acceleration: Acceleration) -> Coupled {
    let mut coupled = Coupled::new(flying(n));
    coupled.saturate(drained(1.0, rule));
    coupled.accelerate(acceleration);
    coupled
}

/// The bits of positions, velocities and pressures, folded.
pub fn bits(coupled: &Coupled) -> u64 {
    let p = coupled.dem().storage();
    let vectors = p.position.iter().chain(&p.velocity);
    let pressure = coupled.storage_flow().map_or(&[][..], |f| f.pressure());
    let fold =
        |h: u64, x: f64| (h ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(7);
    let h = vectors.flat_map(|v: &Vec3| [v.x, v.y, v.z]).fold(1, fold);
    pressure.iter().copied().fold(h, fold)
}

/// Advances, and returns the bits after each step.
pub fn course(coupled: &mut Coupled, steps: usize, dt: f64) -> Vec<u64> {
    (0..steps)
        .map(|_| {
            coupled.step(dt).unwrap();
            bits(coupled)
        })
        .collect()
}
