//! Spheres in a fluid whose pressure is imposed everywhere, so that only neighbours act.
#![allow(dead_code, reason = "every test file uses some of these")]

use dempfv::coupling::{Coupled, EdgeEffects, FluidEffects, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, PerWall, Vec3};

/// Every effect between neighbours.
pub const ALL: EdgeEffects = EdgeEffects {
    viscous_shear: true,
    normal_lubrication: true,
    shear_lubrication: true,
    pump_torque: true,
    twist_torque: true,
    roughness: 1e-3,
    stiffness: None,
};

/// None of them, with a roughness.
pub const NONE: EdgeEffects = EdgeEffects {
    viscous_shear: false,
    normal_lubrication: false,
    shear_lubrication: false,
    pump_torque: false,
    twist_torque: false,
    ..ALL
};

/// Density of the spheres (kg/m³).
pub const DENSITY: f64 = 2600.0;

/// A fluid with this viscosity (Pa·s), renewed every so many steps, with a pressure of 0 at all walls.
pub fn open(viscosity: f64, every: u64) -> Saturation {
    let boundary = Boundary { pressure: PerWall::from_fn(|_| Some(0.0)), ..Boundary::default() };
    let fluid = Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary };
    let remesh = RemeshRule { interval: Some(every), strain: None };
    Saturation { fluid, solver: SolverKind::default(), remesh }
}

/// Spheres of modulus `young` (Pa) in a box, without friction.
pub fn spheres(x: &[Vec3], r: &[f64], bounds: Aabb, young: f64, options: DemOptions) -> Dem {
    let material = Material { young, stiffness_ratio: 0.5, friction_angle: 0.0, density: DENSITY };
    let walls = WallMaterial { young, friction_angle: 0.0 };
    let particles = Particles::new(x.to_vec(), r.to_vec(), DENSITY);
    Dem::new(particles, bounds, material, walls, options).unwrap()
}

/// These in a fluid.
pub fn wet(dem: Dem, saturation: Saturation, edges: EdgeEffects) -> Coupled {
    let mut coupled = Coupled::new(dem);
    coupled.saturate(saturation);
    coupled.set_fluid_effects(FluidEffects { edges, ..FluidEffects::default() });
    coupled
}

/// A cube of this half edge (m) around the origin: far walls.
pub fn around(half: f64) -> Aabb {
    Aabb { min: Vec3::repeat(-half), max: Vec3::repeat(half) }
}
