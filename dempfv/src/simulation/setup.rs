//! From a plan to the things that move.

use crate::coupling::Coupled;
use crate::dem::{self, CloudScale, CloudSpec, Dem, DemOptions, SizeDistribution};
use crate::scene::{ParticleSource, Plan, Sizes};
use crate::{Aabb, InputError, Result, Vec3};

/// The spheres that a plan starts from, and their box (m): read from its
/// packing file, or drawn with its seed.
///
/// # Errors
/// What [`Plan::validate`] finds; when the file is missing or wrong, a sphere
/// lies outside the box, two coincide, or the cloud does not fit.
pub fn initial_packing(plan: &Plan) -> Result<(Vec<Vec3>, Vec<f64>, Aabb)> {
    plan.validate()?;
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

/// The mechanics of a plan whose spheres are at rest at their first places.
pub(super) fn mechanics(
    plan: &Plan,
    (position, radius, bounds): (Vec<Vec3>, Vec<f64>, Aabb),
) -> Result<Dem> {
    let material = plan.particles.material;
    let particles = dem::Particles::new(position, radius, material.density);
    let (walls, options) = (plan.walls.material, options(plan));
    Ok(match plan.granular_law()? {
        Some(law) => Dem::with_law(law, particles, bounds, &[material], walls, options)?,
        None => Dem::new(particles, bounds, material, walls, options)?,
    })
}

pub(super) fn options(plan: &Plan) -> DemOptions {
    plan.dem.map_or_else(DemOptions::default, |dem| dem.options)
}

/// Dry spheres that know how the plan's fluid is to be computed.
pub(super) fn coupled(plan: &Plan, dem: Dem) -> Result<Coupled> {
    let mut coupled = Coupled::new(dem);
    coupled.accelerate(plan.fluid.as_ref().map(|f| f.acceleration).unwrap_or_default());
    if let Some(fluid) = &plan.fluid {
        coupled.set_tolerance(fluid.tolerance)?;
    }
    coupled.watch(plan.output.probes.clone());
    Ok(coupled)
}
