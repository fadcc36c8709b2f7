//! `dempfv pack --tile`: copies of a packing side by side.

use std::path::Path;
use std::sync::atomic::Ordering;

use dempfv::dem::{
    Dem, DemOptions, GrowthCompaction, GrowthOptions, Material, Particles, WallMaterial,
};
use dempfv::io::packing::{self, Packing};
use dempfv::scene::load_packing;
use dempfv::simulation::Compaction;
use dempfv::{Aabb, Error};
use dempfv_report::format::si;

use super::{Args, FILE, Report, check_options, make_folder, write_spheres};
use crate::commands::Context;

/// Copies a packing, lets the copies settle together where a stress is given, and writes
/// them. `None`: Ctrl-C ended it, nothing was written.
///
/// # Errors
/// What is wrong in the packing or the options, or why the copies do not settle.
pub fn run(
    args: &Args,
    copies: &[u32],
    path: &Path,
    context: &Context,
) -> Result<Option<Report>, Error> {
    check_options(args)?;
    let folder = args.output.folder(path, FILE)?;
    let (one, bounds) = load_packing(path, None)?;
    // clap takes exactly three.
    let copies = [0, 1, 2].map(|axis| copies.get(axis).copied().unwrap_or(1));
    let tiled = Packing { bounds: Some(bounds), ..one }.tiled(copies)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let origin = format!("{} × {} × {} copies of {name}", copies[0], copies[1], copies[2]);
    let version = env!("CARGO_PKG_VERSION");
    let particles = tiled.len();
    let file = folder.join(FILE);
    if args.stress.is_none() {
        let comment = format!("{origin} (dempfv {version}); metres");
        make_folder(&folder)?;
        packing::write(&file, &tiled.position, &tiled.radius, tiled.bounds.as_ref(), &comment)?;
        return Ok(Some(Report { file, particles, steps: 0, compaction: None }));
    }
    let bounds = tiled.bounds.unwrap_or(bounds);
    let Some((dem, steps, compaction)) = settle(args, tiled, bounds, context)? else {
        return Ok(None);
    };
    let stress = compaction.stress_pa;
    let comment =
        format!("{origin}, settled at {stress:.6e} Pa by growth (dempfv {version}); metres");
    make_folder(&folder)?;
    write_spheres(&file, &dem, &comment)?;
    Ok(Some(Report { file, particles, steps, compaction: Some(compaction) }))
}

/// All radii grow until the walls carry the stress and the spheres are at rest.
fn settle(
    args: &Args,
    packing: Packing,
    bounds: Aabb,
    context: &Context,
) -> Result<Option<(Dem, u64, Compaction)>, Error> {
    let (stress, young, friction) = args.growth();
    let material = Material {
        young,
        stiffness_ratio: 0.5,
        friction_angle: friction.to_radians(),
        density: 2600.0,
    };
    let particles = Particles::new(packing.position, packing.radius, material.density);
    let walls = WallMaterial { young, friction_angle: 0.0 };
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let mut dem = Dem::new(particles, bounds, material, walls, options)?;
    let mut growth = GrowthCompaction::new(GrowthOptions::new(stress, young))?;
    let interrupted = context.interruption()?;
    let mut progress = context.progress();
    progress.begin("compact", 0, false);
    while !growth.step(&mut dem)?.done {
        if interrupted.load(Ordering::Relaxed) {
            return Ok(None);
        }
        progress.update(growth.status().steps, None, || si(growth.status().stress, "Pa"));
    }
    let status = growth.status();
    progress.end(status.steps, "");
    let compaction = Compaction {
        stress_pa: status.stress,
        unbalanced_force: status.unbalanced,
        porosity: dem.porosity(),
        coordination_number: dem.coordination_number(),
    };
    Ok(Some((dem, status.steps, compaction)))
}
