//! From a plan to the things that move.

use crate::coupling::{Coupled, RemeshRule, Saturation};
use crate::dem::{
    self, CloudScale, CloudSpec, Dem, DemOptions, Material, SizeDistribution, WallMaterial,
};
use crate::pfv;
use crate::scene::{self, ParticleSource, Plan, Sizes};
use crate::{Aabb, InputError, Result, Vec3};

/// The spheres that a plan starts from, and their box (m): read from its
/// packing file, or drawn with its seed.
///
/// # Errors
/// When the file is missing or wrong, a sphere lies outside the box, two
/// coincide, or the cloud does not fit.
pub fn initial_packing(plan: &Plan) -> Result<(Vec<Vec3>, Vec<f64>, Aabb)> {
    if let Some((packing, bounds)) = plan.packing()? {
        return Ok((packing.position, packing.radius, bounds));
    }
    let (ParticleSource::Cloud(cloud), Some(bounds)) = (&plan.particles.source, plan.bounds) else {
        return Err(
            InputError::new("a cloud needs a box", "add a table [box] with min and max").into()
        );
    };
    let (sizes, scale) = match &cloud.sizes {
        Sizes::Uniform { mean, spread } => {
            (SizeDistribution::Uniform { spread: *spread }, CloudScale::MeanRadius(*mean))
        }
        Sizes::Classes(classes) => {
            let list = classes.iter().map(|c| (c.radius, c.share)).collect();
            (SizeDistribution::List(list), CloudScale::AsListed)
        }
    };
    let spec =
        CloudSpec { box_: bounds, count: cloud.count as usize, sizes, scale, seed: plan.seed };
    let (position, radius) = dem::random_cloud(&spec)?.into_iter().unzip();
    Ok((position, radius, bounds))
}

/// The mechanics of a plan, at rest.
pub(super) fn mechanics(plan: &Plan) -> Result<Dem> {
    let (position, radius, bounds) = initial_packing(plan)?;
    let particles = dem::Particles::new(position, radius, plan.particles.density);
    Ok(Dem::new(particles, bounds, material(plan), wall_material(plan), options(plan))?)
}

pub(super) fn material(plan: &Plan) -> Material {
    let p = &plan.particles;
    Material {
        young: p.young,
        stiffness_ratio: p.stiffness_ratio,
        friction_angle: p.friction_angle,
        density: p.density,
    }
}

pub(super) fn wall_material(plan: &Plan) -> WallMaterial {
    WallMaterial { young: plan.walls.young, friction_angle: plan.walls.friction_angle }
}

pub(super) fn options(plan: &Plan) -> DemOptions {
    let mut options = DemOptions::default();
    if let Some(dem) = &plan.dem {
        options.damping = dem.damping;
        options.gravity = dem.gravity;
        options.rotation = dem.rotation;
    }
    options
}

/// Dry spheres that know how the plan's fluid is to be computed.
pub(super) fn coupled(plan: &Plan, dem: Dem) -> Coupled {
    let mut coupled = Coupled::new(dem);
    coupled.accelerate(plan.fluid.as_ref().map(|f| f.acceleration).unwrap_or_default());
    if let Some(fluid) = &plan.fluid {
        coupled.set_tolerance(fluid.tolerance);
    }
    coupled.watch(plan.output.probes.clone());
    coupled
}

/// The fluid of a plan.
pub(super) fn saturation(fluid: &scene::Fluid) -> Saturation {
    Saturation {
        fluid: pfv::Fluid {
            viscosity: fluid.viscosity,
            slip_walls: fluid.slip_walls,
            clamp: fluid.clamp,
            boundary: pfv::Boundary { pressure: fluid.pressure.into() },
        },
        solver: fluid.solver,
        remesh: RemeshRule { interval: fluid.remesh_interval, strain: fluid.remesh_strain },
    }
}
