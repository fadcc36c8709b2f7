//! Everything of a scene but its stages.

use std::path::{Path, PathBuf};

use super::stages;
use crate::coupling::{Acceleration, OnFailure, RemeshMode, Swap, Update};
use crate::domain::{Aabb, Vec3, WallId};
use crate::input::InputError;
use crate::pfv::Clamp;
use crate::scene::keys;
use crate::scene::packing_check::probe_outside;
use crate::scene::plan::*;
use crate::scene::table::{Bound, Table, Value};
use crate::solver::SolverKind;

type Result<T> = std::result::Result<T, InputError>;

/// Reads the whole scene.
pub(super) fn read(root: &Table) -> Result<Plan> {
    let file = root.source.file.map(Path::to_path_buf);
    let title = match root.get("title") {
        Some(v) => v.text("the scene's title")?.to_owned(),
        None => file
            .as_deref()
            .and_then(Path::file_stem)
            .map_or_else(|| "untitled".to_owned(), |s| s.to_string_lossy().into_owned()),
    };
    let seed = root.count_or("seed", 0, 1)?;
    let bounds = root.get("box").map(|v| read_box(&v)).transpose()?;
    let particles = read_particles(root, bounds.as_ref())?;
    let walls = read_walls(root, &particles)?;
    let dem = root.get("dem").map(|v| read_dem(&v)).transpose()?;
    let fluid = root.get("fluid").map(|v| read_fluid(&v)).transpose()?;
    let stages = stages::read(root, &walls, fluid.is_some())?;
    let output = read_output(root, bounds.as_ref(), fluid.is_some())?;
    Ok(Plan { title, file, seed, bounds, particles, walls, dem, fluid, stages, output })
}

fn read_box(value: &Value) -> Result<Aabb> {
    let table = value.table(&keys::BOX)?;
    let min = table.need("min", "the smallest x, y, z in m")?.vector("m")?;
    let upper = table.need("max", "the largest x, y, z in m")?;
    let max = upper.vector("m")?;
    match (0..3).find(|&a| min[a] >= max[a]) {
        None => Ok(Aabb { min, max }),
        Some(a) => Err(upper.error(
            &format!("has {} = {}, not above {} of `min`", ["x", "y", "z"][a], max[a], min[a]),
            "give a `max` above `min` on every axis",
        )),
    }
}

fn read_particles(root: &Table, bounds: Option<&Aabb>) -> Result<Particles> {
    let value = root.need("particles", "[particles] with `packing` or `cloud`")?;
    let table = value.table(&keys::PARTICLES)?;
    let source = match (table.get("packing"), table.get("cloud")) {
        (Some(file), None) => ParticleSource::Packing(read_packing_path(&file)?),
        (None, Some(cloud)) => ParticleSource::Cloud(read_cloud(&cloud, bounds)?),
        (Some(file), Some(cloud)) => {
            let later = if file.at > cloud.at { file } else { cloud };
            return Err(later.error("is a second source of spheres", "keep `packing` or `cloud`"));
        }
        (None, None) => {
            return Err(root.source.error(
                table.at,
                "[particles] has neither `packing` nor `cloud`",
                "give `packing = \"FILE\"` or `cloud = { count = 1000, porosity = 0.95 }`",
            ));
        }
    };
    Ok(Particles {
        source,
        density: table.number_or("density", "kg/m³", Bound::Positive, 2600.0)?,
        young: table.number_or("young", "Pa", Bound::Positive, 1e6)?,
        stiffness_ratio: table.number_or("stiffness_ratio", "", Bound::NotNegative, 0.5)?,
        friction_angle: table.angle_or("friction_angle", 30f64.to_radians())?,
    })
}

fn read_packing_path(value: &Value) -> Result<PathBuf> {
    let name = value.text("the name of a packing file")?;
    let folder = value.source.file.and_then(Path::parent);
    let path = folder.map_or_else(|| PathBuf::from(name), |f| f.join(name));
    if path.is_file() {
        return Ok(path);
    }
    Err(value.error(
        &format!("is \"{name}\", but there is no file {}", path.display()),
        "name an existing packing file; a relative name starts at the scene's folder",
    ))
}

fn read_cloud(value: &Value, bounds: Option<&Aabb>) -> Result<Cloud> {
    let table = value.table(&keys::CLOUD)?;
    let Some(bounds) = bounds else {
        return Err(value.error("needs a box to fill", "add [box] with `min` and `max` in m"));
    };
    let count = table.need("count", "the number of spheres")?.count32(1)?;
    let spread = table.number_or("spread", "(half width over mean)", Bound::BelowOne, 0.0)?;
    let sizes = match (table.get("porosity"), table.get("radius"), table.get("sizes")) {
        (Some(v), None, None) => {
            let porosity = v.number("", Bound::InsideUnit)?;
            let unit = Sizes::Uniform { mean: 1.0, spread }.mean_volume();
            let one = (1.0 - porosity) * bounds.volume() / f64::from(count);
            Sizes::Uniform { mean: (one / unit).cbrt(), spread }
        }
        (None, Some(v), None) => Sizes::Uniform { mean: v.number("m", Bound::Positive)?, spread },
        (None, None, Some(v)) => match table.get("spread") {
            None => Sizes::Classes(read_classes(&v)?),
            Some(spread) => {
                return Err(spread.error("stands beside `sizes`", "keep one of the two"));
            }
        },
        (None, None, None) => {
            return Err(value.error(
                "does not say how large the spheres are",
                "give one of `porosity`, `radius` (the mean, m), `sizes` ([[radius, share], ...])",
            ));
        }
        _ => {
            return Err(value.error(
                "has more than one of `porosity`, `radius`, `sizes`",
                "keep one: each says how large the spheres are",
            ));
        }
    };
    let cloud = Cloud { count, sizes };
    check_room(&cloud, bounds, value)?;
    Ok(cloud)
}

/// Random placement without overlaps jams at a solid fraction of 0.384 for equal spheres
/// (random sequential addition; Torquato, Uche and Stillinger 2006), a little above for
/// unequal ones.
const JAMMED: f64 = 0.38;

fn check_room(cloud: &Cloud, bounds: &Aabb, value: &Value) -> Result<()> {
    let solid = f64::from(cloud.count) * cloud.sizes.mean_volume() / bounds.volume();
    if solid > JAMMED {
        return Err(value.error(
            &format!("has a porosity of {:.3}: spheres placed at random do not fit", 1.0 - solid),
            format!("give fewer or smaller spheres, for a porosity above {}", 1.0 - JAMMED),
        ));
    }
    let edge = bounds.size().min();
    if 2.0 * cloud.sizes.largest() >= edge {
        return Err(value.error(
            &format!("has spheres of {:.4e} m across", 2.0 * cloud.sizes.largest()),
            format!("give spheres smaller than the box's shortest edge, {edge:.4e} m"),
        ));
    }
    Ok(())
}

fn read_classes(value: &Value) -> Result<Vec<SizeClass>> {
    const WANTED: &str = "pairs of radius (m) and share, as in [[0.01, 0.4], [0.02, 0.6]]";
    let mut classes = Vec::new();
    for pair in value.items(WANTED)? {
        let items = pair.items(WANTED)?;
        let [radius, share] = items.as_slice() else {
            return Err(pair.error("has an item that is no pair", format!("give {WANTED}")));
        };
        classes.push(SizeClass {
            radius: radius.number("m", Bound::Positive)?,
            share: share.number("", Bound::Positive)?,
        });
    }
    let total: f64 = classes.iter().map(|c| c.share).sum();
    if classes.is_empty() {
        return Err(value.error("is empty", format!("give {WANTED}")));
    }
    for class in &mut classes {
        class.share /= total;
    }
    Ok(classes)
}

fn read_walls(root: &Table, particles: &Particles) -> Result<Walls> {
    let mut walls = Walls { young: particles.young, friction_angle: 0.0, max_velocity: 1.0 };
    if let Some(value) = root.get("walls") {
        let table = value.table(&keys::WALLS)?;
        walls.young = table.number_or("young", "Pa", Bound::Positive, walls.young)?;
        walls.friction_angle = table.angle_or("friction_angle", walls.friction_angle)?;
        walls.max_velocity =
            table.number_or("max_velocity", "m/s", Bound::Positive, walls.max_velocity)?;
    }
    Ok(walls)
}

fn read_dem(value: &Value) -> Result<Dem> {
    let table = value.table(&keys::DEM)?;
    let dt = match table.get("dt") {
        None => TimeStep::Auto,
        Some(v) if v.is_text() => v.choice(&[("auto", TimeStep::Auto)])?,
        Some(v) => TimeStep::Fixed(v.number("s, or \"auto\"", Bound::Positive)?),
    };
    let gravity = table.get("gravity").map(|v| v.vector("m/s²")).transpose()?;
    Ok(Dem {
        dt,
        safety: table.number_or("safety", "", Bound::UpToOne, 0.8)?,
        damping: table.number_or("damping", "", Bound::BelowOne, 0.2)?,
        gravity: gravity.filter(|g| g.norm_squared() > 0.0),
        rotation: table.flag_or("rotation", true)?,
    })
}

fn read_fluid(value: &Value) -> Result<Fluid> {
    let table = value.table(&keys::FLUID)?;
    let remesh_strain =
        table.get("remesh_strain").map(|v| v.number("", Bound::Positive)).transpose()?;
    let (remesh_interval, auto_interval) = match table.get("remesh_interval") {
        Some(v) if v.is_text() => {
            v.choice(&[("auto", ())])?;
            (None, true)
        }
        Some(v) => (Some(v.count(1)?), false),
        None => (remesh_strain.is_none().then_some(200), false),
    };
    let clamp = table.get("clamp").map(|v| v.choice(&Clamp::ALL.map(|c| (c.name(), c))));
    Ok(Fluid {
        viscosity: table.need_number("viscosity", "Pa·s", Bound::Positive)?,
        remesh_interval,
        remesh_strain,
        acceleration: read_acceleration(&table, auto_interval)?,
        slip_walls: table.flag_or("slip_walls", true)?,
        clamp: clamp.transpose()?.unwrap_or_default(),
        solver: read_solver(&table)?,
        tolerance: table.number_or("tolerance", "", Bound::Positive, 1e-11)?,
        pressure: read_conditions(&table)?,
    })
}

fn read_solver(fluid: &Table) -> Result<SolverKind> {
    let solvers: Vec<_> = SolverKind::CHOICES.iter().map(|s| (s.name(), *s)).collect();
    let mut solver = match fluid.get("solver") {
        Some(v) => v.choice(&solvers)?,
        None => SolverKind::default(),
    };
    for (key, value) in
        [("gpu_device", fluid.get("gpu_device")), ("gpu_memory", fluid.get("gpu_memory"))]
    {
        let Some(value) = value else { continue };
        let SolverKind::CholmodGpu(options) = &mut solver else {
            return Err(value
                .error("is given, but the solver uses no GPU", "add `solver = \"cholmod-gpu\"`"));
        };
        match key {
            "gpu_device" => options.device = value.count(0)? as u32,
            _ => options.memory = Some(value.number("bytes", Bound::Positive)? as u64),
        }
    }
    Ok(solver)
}

/// How networks are renewed; what the mode has no use for is an error.
fn read_acceleration(fluid: &Table, auto_interval: bool) -> Result<Acceleration> {
    let remesh = match fluid.get("remesh") {
        Some(v) => v.choice(&RemeshMode::ALL.map(|m| (m.name(), m)))?,
        None => RemeshMode::default(),
    };
    if let Some(v) = fluid.get("remesh_interval").filter(|_| auto_interval)
        && remesh != RemeshMode::Background
    {
        return Err(v.error(
            "is \"auto\", which balances the time loop against a background that is not there",
            "add `remesh = \"background\"`, or give a number of steps",
        ));
    }
    let swap = match fluid.get("swap") {
        Some(v) => {
            let choice = v.choice(&Swap::ALL.map(|s| (s.name(), s)))?;
            if choice == Swap::WhenReady && remesh != RemeshMode::Background {
                return Err(v.error(
                    "is \"when ready\", but nothing is built in the background",
                    "add `remesh = \"background\"`",
                ));
            }
            choice
        }
        None => Swap::default(),
    };
    let on_failure = match fluid.get("on_failure") {
        Some(v) => {
            let choice = v.choice(&OnFailure::ALL.map(|f| (f.name(), f)))?;
            if choice == OnFailure::Retry && remesh == RemeshMode::AtOnce {
                return Err(v.error(
                    "is \"retry\", but a remesh at once has no old network left to go on with",
                    "add `remesh = \"ahead\"` or `remesh = \"background\"`",
                ));
            }
            choice
        }
        None => OnFailure::default(),
    };
    let update = match fluid.get("update") {
        Some(v) => v.choice(&Update::ALL.map(|u| (u.name(), u)))?,
        None => Update::default(),
    };
    let parallel_tasks = fluid.flag_or("parallel_tasks", false)?;
    Ok(Acceleration { remesh, swap, on_failure, auto_interval, parallel_tasks, update })
}

/// Imposed pressures; a wall must not be in `no_flow` too.
fn read_conditions(fluid: &Table) -> Result<[Option<f64>; 6]> {
    let mut pressure = [None; 6];
    if let Some(value) = fluid.get("pressure") {
        let table = value.table(&keys::PRESSURE)?;
        for wall in WallId::ALL {
            let imposed = table.get(wall.name()).map(|v| v.number("Pa", Bound::Finite));
            pressure[wall.index()] = imposed.transpose()?;
        }
    }
    if let Some(value) = fluid.get("no_flow") {
        for item in value.items("an array of wall names, as in [\"x_min\", \"x_max\"]")? {
            let wall = item.wall()?;
            if pressure[wall.index()].is_some() {
                return Err(item.error(
                    &format!("names {wall}, which has two conditions: a pressure and no flow"),
                    format!("take {wall} out of `pressure` or out of `no_flow`"),
                ));
            }
        }
    }
    Ok(pressure)
}

fn read_output(root: &Table, bounds: Option<&Aabb>, has_fluid: bool) -> Result<Output> {
    let mut output = Output {
        history_every: 10,
        vtk_every: 0,
        checkpoint_every: 0,
        pictures: true,
        probes: vec![],
    };
    if let Some(value) = root.get("output") {
        let table = value.table(&keys::OUTPUT)?;
        output.history_every = table.count_or("history_every", 1, output.history_every)?;
        output.vtk_every = table.count_or("vtk_every", 0, output.vtk_every)?;
        output.checkpoint_every = table.count_or("checkpoint_every", 0, output.checkpoint_every)?;
        output.pictures = table.flag_or("pictures", output.pictures)?;
        if let Some(value) = table.get("probes") {
            output.probes = read_probes(&value, bounds, has_fluid)?;
        }
    }
    Ok(output)
}

/// Points inside the box, as far as the scene says where that is.
fn read_probes(value: &Value, bounds: Option<&Aabb>, has_fluid: bool) -> Result<Vec<Vec3>> {
    const FORM: &str = "an array of points in m, as in [[0.5, 0.1, 0.5]]";
    if !has_fluid {
        return Err(value.error("asks for pore pressures, but there is no [fluid]", "add [fluid]"));
    }
    let mut probes = Vec::new();
    for item in value.items(FORM)? {
        let point = item.vector("m")?;
        probes.push(point);
        let outside = bounds.and_then(|bounds| probe_outside(&probes, bounds));
        if let Some(problem) = outside {
            return Err(item.error(&problem, "give points inside the box"));
        }
    }
    Ok(probes)
}
