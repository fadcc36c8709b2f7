//! The parts of a plan in words.

use dempfv::coupling::{Acceleration, RemeshMode, Swap};
use dempfv::scene::*;
use dempfv::{PerWall, TimeFunction};
use dempfv_report::format::{count, si, three_digits};

/// What a stage does and when it ends, and the mechanics that it has of its own.
pub fn stage(stage: &Stage) -> String {
    let dt = stage.dt.map(|dt| match dt {
        TimeStep::Auto => ", automatic time step".to_owned(),
        TimeStep::Fixed(dt) => format!(", time step {}", si(dt, "s")),
    });
    let damping = stage.damping.map(|x| format!(", damping {}", three_digits(x)));
    format!("{}{}{}", kind(&stage.kind), dt.unwrap_or_default(), damping.unwrap_or_default())
}

fn kind(kind: &StageKind) -> String {
    match kind {
        StageKind::Compact(s) => format!(
            "{} to {}{}; ends at unbalanced force {} with the stress within {} %",
            if s.keep_radii { "the box shrinks" } else { "radii grow" },
            si(s.stress, "Pa"),
            friction(s.friction_angle),
            s.unbalanced,
            three_digits(100.0 * s.tolerance),
        ),
        StageKind::Cycle(s) => format!(
            "{} between {} and {}, {} times, dry: measures the oedometric modulus",
            s.wall,
            si(s.from, "Pa"),
            si(s.to, "Pa"),
            s.cycles,
        ),
        StageKind::Permeability(s) => {
            format!("static flow along {}: measures the permeability", s.axis.name())
        }
        StageKind::Flow(s) => match s.time {
            Some(time) => format!(
                "flow through spheres at rest for {} in {} steps",
                si(time, "s"),
                count(s.steps)
            ),
            None => "steady flow through spheres at rest".to_owned(),
        },
        StageKind::Consolidate(s) => format!(
            "{} on {}, coupled, until T_v = {}",
            si(s.stress, "Pa"),
            s.wall,
            three_digits(s.until_tv),
        ),
        StageKind::Run(s) => run(s),
    }
}

fn run(run: &Run) -> String {
    let end = match run.until {
        Until::Steps(steps) => format!("{} steps", count(steps)),
        Until::Time(time) => si(time, "s"),
        Until::Strain { strain, axis, .. } => {
            format!("to a strain of {} % along {}", three_digits(100.0 * strain), axis.name())
        }
        Until::Stress { stress, axis, .. } => {
            format!("to a total stress of {} along {}", si(stress, "Pa"), axis.name())
        }
        Until::Porosity { porosity, .. } => format!("to a porosity of {}", three_digits(porosity)),
        Until::Unbalanced { unbalanced, .. } => {
            format!("until at rest, at an unbalanced force of {unbalanced}")
        }
    };
    let flow = match &run.pressure {
        _ if !run.fluid => "dry".to_owned(),
        Some(walls) => format!("coupled, {}", pressures(walls)),
        None => "coupled".to_owned(),
    };
    let moving = match *run.cell == CellControls::default() {
        true => controls(run),
        false => cell_controls(&run.cell),
    };
    format!("{end}, {flow}, {moving}{}", friction(run.friction_angle))
}

fn cell_controls(controls: &CellControls) -> String {
    let name = |a: usize, b: usize| format!("{}{}", ["x", "y", "z"][a], ["x", "y", "z"][b]);
    let moving: Vec<String> = (0..9)
        .map(|k| (k / 3, k % 3))
        .filter_map(|(a, b)| match controls[a][b] {
            CellControl::Rate(0.0) => None,
            CellControl::Rate(rate) => Some(format!("L_{} = {}/s", name(a, b), three_digits(rate))),
            CellControl::Stress(stress) => {
                Some(format!("σ_{} at {}", name(a, b), si(stress, "Pa")))
            }
        })
        .collect();
    moving.join(", ")
}

/// The periodic cell.
pub fn cell(shape: &CellShape) -> String {
    let CellShape::Edges(cell) = shape else { return "that of the packing".to_owned() };
    let lengths = cell.lengths().map(|x| si(x, "m"));
    let angles = cell.angles().map(|x| three_digits(x.to_degrees()));
    format!("{} at {}°", lengths.join(" × "), angles.join("°, "))
}

fn controls(run: &Run) -> String {
    let moving: Vec<String> = run
        .walls
        .iter()
        .filter_map(|(wall, control)| {
            let value = |value: f64, unit: &str| match &run.walls_in_time[wall] {
                Some(function) => in_time(function, unit),
                None => si(value, unit),
            };
            match *control {
                WallControl::Fixed => None,
                WallControl::Velocity(v) => Some(format!("{wall} at {}", value(v, "m/s"))),
                WallControl::Servo { stress, .. } => {
                    Some(format!("{wall} under {}", value(stress, "Pa")))
                }
            }
        })
        .collect();
    if moving.is_empty() { "all walls fixed".to_owned() } else { moving.join(", ") }
}

/// The pressures of a stage's own.
fn pressures(walls: &PerWall<Option<TimeFunction>>) -> String {
    let on = walls.iter().filter_map(|(wall, p)| Some((wall, p.as_ref()?)));
    let all: Vec<String> = on.map(|(wall, p)| format!("{} on {wall}", in_time(p, "Pa"))).collect();
    if all.is_empty() { "no wall drained".to_owned() } else { all.join(", ") }
}

/// A function of time from its beginning to its end.
fn in_time(function: &TimeFunction, unit: &str) -> String {
    match function {
        TimeFunction::Constant(value) => si(*value, unit),
        TimeFunction::Ramp(points) => {
            let values: Vec<String> = points.iter().map(|[_, value]| si(*value, unit)).collect();
            values.join(" → ")
        }
        TimeFunction::Sine { mean, amplitude, frequency } => {
            format!("{} ± {} at {}", si(*mean, unit), si(*amplitude, unit), si(*frequency, "Hz"))
        }
    }
}

fn friction(angle: Option<f64>) -> String {
    angle.map_or_else(String::new, |a| format!(", friction {}°", three_digits(a.to_degrees())))
}

/// Where the spheres come from.
pub fn source(source: &ParticleSource) -> String {
    match source {
        ParticleSource::Packing(path) => path.display().to_string(),
        ParticleSource::Cloud(cloud) => match &cloud.sizes {
            Sizes::Uniform { mean, spread } => format!(
                "random cloud, mean radius {} ± {} %",
                si(*mean, "m"),
                three_digits(100.0 * spread)
            ),
            Sizes::Curve(_) | Sizes::LogNormal(_) => format!(
                "random cloud graded by mass, diameters from {} to {}",
                si(2.0 * cloud.sizes.smallest(), "m"),
                si(2.0 * cloud.sizes.largest(), "m")
            ),
            Sizes::Classes(classes) => {
                format!(
                    "random cloud of {} sizes, {} to {}",
                    classes.len(),
                    si(cloud.sizes.smallest(), "m"),
                    si(cloud.sizes.largest(), "m")
                )
            }
        },
    }
}

/// The fluid; its boundary conditions where some stage has them, and its remeshing where one is
/// coupled; in a periodic cell or between walls.
pub fn fluid(fluid: &Fluid, stages: &[Stage], in_cell: bool) -> String {
    let any = |holds: fn(&StageKind) -> bool| stages.iter().any(|stage| holds(&stage.kind));
    let viscosity = format!("μ = {}", si(fluid.fluid.viscosity, "Pa·s"));
    if !any(StageKind::has_conditions) {
        return viscosity;
    }
    let profile = |wall| match fluid.effects.wall_profile[wall] {
        Some(_) => " and a profile",
        None => "",
    };
    let pressure = |(wall, p)| format!("{}{} on {wall}", si(p, "Pa"), profile(wall));
    let pressures: Vec<String> = fluid.pressure_walls().map(pressure).collect();
    let driven = match fluid.effects.pressure_gradient {
        Some(gradient) => {
            let [x, y, z] = <[f64; 3]>::from(gradient).map(three_digits);
            format!("mean gradient {x}, {y}, {z} Pa/m")
        }
        None if in_cell => "no mean gradient".to_owned(),
        None => format!("{}, no flow through other walls", pressures.join(", ")),
    };
    if !any(StageKind::is_coupled) {
        return format!("{viscosity}; {driven}");
    }
    let how = fluid.acceleration;
    let interval = match fluid.remesh.interval {
        _ if how.auto_interval => Some("as often as the background can follow".to_owned()),
        interval => interval.map(|n| format!("every {} steps", count(n))),
    };
    let strain = fluid
        .remesh
        .strain
        .map(|s| format!("when a pore changes by {} %", three_digits(100.0 * s)));
    let remesh: Vec<String> = interval.into_iter().chain(strain).collect();
    format!("{viscosity}; {driven}; remesh {}{}", remesh.join(" or "), renewal(&how))
}

/// From which positions networks are built, and by whom, unless plainly.
fn renewal(how: &Acceleration) -> &'static str {
    match (how.remesh, how.swap) {
        (RemeshMode::AtOnce, _) => "",
        (RemeshMode::Ahead, _) => ", of the positions of half as long before",
        (RemeshMode::Background, Swap::WhenDue) => {
            ", of the positions of half as long before, in the background"
        }
        (RemeshMode::Background, Swap::WhenReady) => {
            ", in the background, in use as soon as it is ready"
        }
    }
}
