//! From a plan to the things that move.

use crate::coupling::Coupled;
use crate::dem::law::Linear;
use crate::dem::{self, CloudScale, CloudSpec, ClumpedSpheres, Dem, DemOptions, SizeDistribution};
use crate::scene::{CellShape, ParticleSource, Plan, Sizes};
use crate::{Aabb, Cell, InputError, Result, Vec3};

/// Spheres at their first places.
pub(super) struct Specimen {
    pub position: Vec<Vec3>,
    pub radius: Vec<f64>,
    /// The box (m); around the cell, where there is one.
    pub bounds: Aabb,
    pub cell: Option<Cell>,
    /// Members of each clump.
    pub clumps: Vec<Vec<u32>>,
}

impl Specimen {
    /// The same, with a clump of the plan's shape in the place of each sphere.
    fn clumped(self, plan: &Plan) -> Result<Specimen> {
        let Some(template) = &plan.particles.clump else { return Ok(self) };
        let spheres: Vec<(Vec3, f64)> = self.position.into_iter().zip(self.radius).collect();
        // Another draw than that of the cloud.
        let ClumpedSpheres { position, radius, clumps } =
            template.in_place_of(&spheres, plan.seed.wrapping_add(1))?;
        Ok(Specimen { position, radius, clumps, ..self })
    }
}

/// The spheres that a plan starts from, and their box (m): read from its
/// packing file, or drawn with its seed. Of a periodic cell, the box around it.
///
/// # Errors
/// What [`Plan::validate`] finds; when the file is missing or wrong, a sphere
/// lies outside the box, two coincide, or the cloud does not fit.
pub fn initial_packing(plan: &Plan) -> Result<(Vec<Vec3>, Vec<f64>, Aabb)> {
    let Specimen { position, radius, bounds, .. } = specimen(plan)?;
    Ok((position, radius, bounds))
}

/// The same, with the periodic cell.
pub(super) fn specimen(plan: &Plan) -> Result<Specimen> {
    plan.validate()?;
    if let Some((packing, bounds)) = plan.packing()? {
        let cell = packing.cell.filter(|_| plan.cell.is_some());
        let (position, radius, clumps) = (packing.position, packing.radius, vec![]);
        return Ok(Specimen { position, radius, bounds, cell, clumps });
    }
    let needs_box = || InputError::new("a cloud needs a box", "add [box] with min and max");
    let ParticleSource::Cloud(cloud) = &plan.particles.source else {
        return Err(needs_box().into());
    };
    let count = cloud.count as usize;
    let (sizes, scale) = match &cloud.sizes {
        Sizes::Uniform { mean, spread } => {
            (SizeDistribution::Uniform { spread: *spread }, CloudScale::MeanRadius(*mean))
        }
        Sizes::Classes(classes) => {
            let list = classes.iter().map(|c| (c.radius, c.share)).collect();
            (SizeDistribution::List(list), CloudScale::AsListed)
        }
        graded @ (Sizes::Curve(_) | Sizes::LogNormal(_)) => {
            let radii = graded.grading_curve().and_then(|curve| curve.radii(count));
            let too_many = || {
                let what = format!("there is no memory for a cloud of {count} spheres");
                InputError::new(what, "give fewer spheres")
            };
            let radii = radii.ok_or_else(too_many)?;
            let each = radii.into_iter().map(|radius| (radius, 1.0)).collect();
            (SizeDistribution::List(each), CloudScale::AsListed)
        }
    };
    if let Some(CellShape::Edges(cell)) = plan.cell {
        let spheres = dem::random_cloud_in_cell(&cell, count, &sizes, scale, plan.seed)?;
        let (position, radius) = spheres.into_iter().unzip();
        let (bounds, cell, clumps) = (cell.bounds(), Some(cell), vec![]);
        return Ok(Specimen { position, radius, bounds, cell, clumps });
    }
    let bounds = plan.bounds.ok_or_else(needs_box)?;
    let spec = CloudSpec { box_: bounds, count, sizes, scale, seed: plan.seed };
    let (position, radius) = dem::random_cloud(&spec)?.into_iter().unzip();
    Specimen { position, radius, bounds, cell: None, clumps: vec![] }.clumped(plan)
}

/// The mechanics of a plan whose spheres are at rest at their first places.
pub(super) fn mechanics(plan: &Plan, specimen: Specimen) -> Result<Dem> {
    let Specimen { position, radius, bounds, cell, clumps } = specimen;
    let materials = &plan.materials()[..];
    let particles = match materials {
        [material] => dem::Particles::new(position, radius, material.density),
        _ => {
            let of_sphere = plan.material_of_each(&position, &radius)?;
            dem::Particles::of_materials(position, radius, of_sphere, materials)?
        }
    };
    let (walls, options) = (plan.walls.material, options(plan));
    let mut dem = match (plan.granular_law()?, cell) {
        (Some(law), Some(cell)) => Dem::in_cell(law, particles, cell, materials, options)?,
        (None, Some(cell)) => Dem::in_cell(Linear, particles, cell, materials, options)?,
        (Some(law), None) => Dem::with_law(law, particles, bounds, materials, walls, options)?,
        (None, None) if !plan.moves() => {
            Dem::standing(particles, bounds, materials, walls, options)?
        }
        (None, None) => Dem::with_law(Linear, particles, bounds, materials, walls, options)?,
    };
    if !clumps.is_empty() {
        dem.bind(&clumps)?;
    }
    if !plan.pairs.is_empty() {
        dem.set_materials(materials, &plan.material_pairs())?;
    }
    Ok(dem)
}

/// Gives the spheres the materials of the plan again, after a stage with a friction of its own.
pub(super) fn own_materials(coupled: &mut Coupled, plan: &Plan) -> Result<()> {
    Ok(coupled.controls().set_materials(&plan.materials(), &plan.material_pairs())?)
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
    coupled.controls().track_turning(plan.output.energy_turning);
    Ok(coupled)
}
