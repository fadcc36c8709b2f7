//! One run of either program through the same loading.

use std::time::Instant;

use dempfv::WallId;
use dempfv::coupling::RemeshMode;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::compare::loading::{Change, Job, LOADED, Loading, Material, Packing, Wet};
use crate::compare::peer::Bench;

const SCRIPT: &str = include_str!("sweep.py");

/// `FlowEngine.useSolver`: YADE's default, CHOLMOD through Eigen, which keeps a factor from one remesh to the
/// next.
pub const SOLVER: u32 = 3;
/// Threads of the BLAS in YADE: with more a step between remeshes takes longer.
const BLAS_THREADS: usize = 1;

/// Steps of each run, and how often one looks, evenly.
const STEPS: u64 = 1_200;
const LOOKS: u64 = 32;
/// Time step (s), viscosity (Pa·s).
const DT: f64 = 1e-6;
const VISCOSITY: f64 = 0.02;
/// Stress that the packing goes to from the 1 kPa at which it has settled (Pa).
const STRESS: f64 = 1e4;
/// Cut of the servo's speed, in heights of the box per second.
const SPEED: f64 = 50.0;
/// Where the pore pressure is looked at: shares of the box's height, and of its width.
const HEIGHTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
const ACROSS: [f64; 3] = [0.25, 0.5, 0.75];

/// Who remeshes, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    Yade,
    AtOnce,
    Background,
}

impl Way {
    pub const ALL: [Way; 3] = [Way::Yade, Way::AtOnce, Way::Background];

    pub fn name(self) -> &'static str {
        match self {
            Way::Yade => "YADE",
            Way::AtOnce => "dempfv",
            Way::Background => "dempfv, background",
        }
    }

    pub fn key(self) -> &'static str {
        match self {
            Way::Yade => "yade",
            Way::AtOnce => "dempfv",
            Way::Background => "dempfv-background",
        }
    }
}

/// What was seen, and how long it took.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Course {
    /// Of the loaded wall (m).
    pub displacement: Vec<f64>,
    /// At each point (Pa).
    pub pressure: Vec<Vec<f64>>,
    pub pores: u64,
    /// Of all steps after the first.
    pub seconds: f64,
}

/// The loading with so many steps from one remesh to the next: that of the specimens of `compare yade`. A
/// larger stress deforms the packing by enough for remeshes to matter within the steps that YADE comes through
/// with a network at each; the fluid is so viscous that drainage, not inertia, takes the time.
pub fn loading(packing: &Packing, remesh_interval: u64) -> Loading {
    let (size, low) = (packing.size(), packing.bounds);
    let probes = HEIGHTS.iter().flat_map(|&y| {
        let row = move |x: f64| ACROSS.map(|z| [x * size.x, y * size.y, z * size.z]);
        ACROSS.into_iter().flat_map(row)
    });
    Loading {
        material: Material::default(),
        dt: DT,
        stress: STRESS,
        max_velocity: SPEED * size.y,
        wet: Some(Wet { viscosity: VISCOSITY, remesh_interval, clamp: true }),
        probes: probes.map(|[x, y, z]| [low[0] + x, low[1] + y, low[2] + z]).collect(),
        steps: STEPS,
        samples: (1..=LOOKS).map(|k| between_remeshes(k * STEPS / LOOKS)).collect(),
    }
}

/// Model time of the steps that are timed (s).
pub fn model_time(loading: &Loading) -> f64 {
    loading.dt * (loading.steps - 1) as f64
}

/// The last step up to this one that no interval of twos and fives remeshes after: YADE shows the
/// pressures of a new network before it has solved them.
fn between_remeshes(step: u64) -> u64 {
    (1..=step).rev().find(|s| s % 2 != 0 && s % 5 != 0).unwrap_or(1)
}

#[derive(Serialize)]
struct Sweep<'a> {
    #[serde(flatten)]
    job: Job<'a>,
    solver: u32,
    blas_threads: usize,
}

/// Runs it.
///
/// # Errors
/// As [`Bench::yade`]; or why ours cannot go on.
pub fn run(
    bench: &Bench,
    (way, name): (Way, &str),
    packing: &Packing,
    loading: &Loading,
    threads: usize,
) -> Result<Course> {
    let mode = match way {
        Way::Yade => {
            let job = Job::new(packing, loading, Change::default());
            let job = Sweep { job, solver: SOLVER, blas_threads: BLAS_THREADS };
            let script = format!("{LOADED}\n{SCRIPT}");
            return Ok(bench.yade::<Course>(name, &script, threads, &job)?.result);
        }
        Way::AtOnce => RemeshMode::AtOnce,
        Way::Background => RemeshMode::Background,
    };
    let mut plan = Plan::from_toml(&loading.scene(packing), None)?;
    // YADE keeps no such book.
    plan.output.energy = false;
    if let Some(fluid) = &mut plan.fluid {
        fluid.acceleration.remesh = mode;
    }
    let mut simulation = Simulation::new(plan)?;
    bench.step(name, || ours(&mut simulation, loading))
}

fn ours(simulation: &mut Simulation, loading: &Loading) -> Result<Course> {
    let mut course = Course { displacement: vec![], pressure: vec![], pores: 0, seconds: 0.0 };
    for step in 1..=loading.steps {
        let clock = Instant::now();
        simulation.advance()?;
        if step > 1 {
            course.seconds += clock.elapsed().as_secs_f64();
        }
        if loading.samples.contains(&step) {
            let seen = simulation.observe();
            course.displacement.push(seen.wall_displacement[WallId::YMax.index()]);
            course.pressure.push(simulation.coupled().probe_pressures().collect());
        }
    }
    let flow = simulation.coupled().storage_flow();
    course.pores = flow.map_or(0, |flow| flow.pressure().len() as u64);
    Ok(course)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_lie_between_remeshes() {
        let looks: Vec<u64> = (1..=LOOKS).map(|k| between_remeshes(k * STEPS / LOOKS)).collect();
        assert!(looks.windows(2).all(|pair| pair[0] < pair[1]), "{looks:?}");
        for interval in [2, 5, 10, 1000] {
            assert!(looks.iter().all(|step| step % interval != 0), "{looks:?}");
        }
        assert_eq!((looks[0], looks[31]), (37, 1199));
    }
}
