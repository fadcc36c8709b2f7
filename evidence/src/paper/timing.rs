//! A run of a specimen under the paper's load, and what its summary tells.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use dempfv::solver::{GpuOptions, SolverKind};
use dempfv_report::machine;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::specimens::{STRESS, Specimen};
use crate::Error;
use crate::bench::Bench;

/// Steps of the paper's runs, and from one remesh to the next.
pub const STEPS: u64 = 600;
/// See [`STEPS`].
pub const INTERVAL: u64 = 200;

/// Phases of a remesh, by their names in summaries.
pub const REMESH: [&str; 3] = ["network", "analyze", "factor"];
/// Phases of a step.
pub const STEP: [&str; 5] = ["contacts", "integration", "volume_rates", "solve", "fluid_forces"];

/// How long to look at what other programs do, before a run.
const LOOK: Duration = Duration::from_secs(1);
/// Key of it, beside those of the summary.
const BUSY: &str = "cores_busy_with_other_programs";

/// Key of the time of a step without parallel tasks, of runs by turns with those that have
/// them (s): a machine's speed drifts by more than they gain.
const IN_TURN: &str = "step_without_tasks_s";

/// How a specimen is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Mode {
    /// One core, one remesh, then steps between two remeshes.
    OneCore,
    /// The same with all cores.
    AllCores,
    /// As `AllCores`, with the fluid's tasks beside the contacts.
    Tasks,
    /// One core, a remesh at every step: the paper's steps with none of its accelerations.
    Plain,
    /// One core, the paper's steps with a factor that serves from one remesh to the next.
    Reuse,
    /// As `Reuse`, on all cores, the next factor made in the background.
    Background,
    /// The paper's steps with all of its accelerations but the GPU.
    Accelerated,
    /// The plain path with the swap points of `Accelerated`: one core, one task after another,
    /// networks of the same positions in use over the same steps.
    Ahead,
    /// As `OneCore`, with CHOLMOD, the paper's solver, instead of the default one.
    Cholmod,
    /// As `Accelerated`, with CHOLMOD.
    AcceleratedCholmod,
    /// As `AllCores`, with the factorization on a GPU; not one of [`Mode::ALL`], which every
    /// machine can run.
    Gpu,
}

impl Mode {
    /// Every mode that needs no GPU.
    pub const ALL: [Mode; 10] = [
        Mode::OneCore,
        Mode::AllCores,
        Mode::Tasks,
        Mode::Plain,
        Mode::Reuse,
        Mode::Background,
        Mode::Accelerated,
        Mode::Ahead,
        Mode::Cholmod,
        Mode::AcceleratedCholmod,
    ];

    /// Its name in files.
    pub const fn name(self) -> &'static str {
        [
            "one-core",
            "all-cores",
            "tasks",
            "plain",
            "reuse",
            "background",
            "accelerated",
            "ahead",
            "cholmod",
            "accelerated-cholmod",
            "gpu",
        ][self as usize]
    }

    /// True for the paper's steps from the first to the last; else for those after one remesh.
    const fn is_whole(self) -> bool {
        match self {
            Mode::Plain | Mode::Reuse | Mode::Background | Mode::Ahead => true,
            Mode::Accelerated | Mode::AcceleratedCholmod => true,
            Mode::OneCore | Mode::AllCores | Mode::Tasks | Mode::Cholmod | Mode::Gpu => false,
        }
    }

    /// Threads that it runs on where there are `all`.
    pub const fn threads(self, all: usize) -> usize {
        match self {
            Mode::OneCore | Mode::Plain | Mode::Reuse | Mode::Ahead | Mode::Cholmod => 1,
            Mode::AllCores | Mode::Tasks | Mode::Gpu => all,
            Mode::Background | Mode::Accelerated | Mode::AcceleratedCholmod => all,
        }
    }

    /// Steps of a specimen's run.
    pub const fn steps(self, specimen: &Specimen) -> u64 {
        if self.is_whole() { STEPS } else { specimen.steps }
    }

    /// Steps from one remesh to the next.
    pub const fn interval(self, specimen: &Specimen) -> u64 {
        match self {
            Mode::Plain => 1,
            _ if self.is_whole() => INTERVAL,
            _ => specimen.steps,
        }
    }

    /// True where remeshes do not stop the time loop.
    pub const fn is_in_background(self) -> bool {
        matches!(self, Mode::Background | Mode::Accelerated | Mode::AcceleratedCholmod)
    }

    /// Runs of which the fastest counts.
    pub const fn repeats(self, specimen: &Specimen) -> usize {
        if self.is_whole() { 1 } else { specimen.repeats }
    }

    /// The solver. It is named in the scene, so that times of one do not pass for those of
    /// another when the default changes.
    fn solver(self) -> SolverKind {
        match self {
            Mode::Cholmod | Mode::AcceleratedCholmod => SolverKind::Cholmod,
            Mode::Gpu => SolverKind::CholmodGpu(GpuOptions::default()),
            _ => SolverKind::default(),
        }
    }

    /// Further keys of the scene's `[fluid]`.
    const fn keys(self) -> &'static str {
        match self {
            Mode::OneCore | Mode::AllCores | Mode::Plain | Mode::Reuse => "",
            Mode::Cholmod | Mode::Gpu => "",
            Mode::Tasks => "parallel_tasks = true",
            Mode::Ahead => "remesh = \"ahead\"",
            Mode::Background => "remesh = \"background\"",
            Mode::Accelerated | Mode::AcceleratedCholmod => {
                "remesh = \"background\"\nparallel_tasks = true"
            }
        }
    }
}

/// The `summary.json` of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Timing(Value);

/// Runs a specimen, or returns what an earlier call measured.
///
/// # Errors
/// The run fails, or its result cannot be kept.
pub fn measure(
    bench: &Bench,
    specimen: &Specimen,
    mode: Mode,
    threads: usize,
) -> Result<Timing, Error> {
    let packing = specimen.packing(bench)?;
    let (name, input) = point(specimen, mode, threads);
    bench.remembered(&name, &input, || {
        let busy = machine::busy_cores(LOOK);
        let run = |mode: Mode| {
            let scene = scene(&packing, specimen, mode);
            bench.ours(&self::name(specimen, mode), &scene, threads).map(|run| Timing(run.summary))
        };
        let mut fastest = run(mode)?;
        let mut in_turn = f64::INFINITY;
        for _ in 1..mode.repeats(specimen) {
            if mode == Mode::Tasks {
                in_turn = in_turn.min(run(Mode::AllCores)?.step());
            }
            let again = run(mode)?;
            if again.step() < fastest.step() {
                fastest = again;
            }
        }
        fastest.0[BUSY] = busy.into();
        if in_turn.is_finite() {
            fastest.0[IN_TURN] = in_turn.into();
        }
        Ok(fastest)
    })
}

/// Runs a specimen, whatever an earlier call measured.
///
/// # Errors
/// The run fails.
pub fn run(
    bench: &Bench,
    specimen: &Specimen,
    mode: Mode,
    threads: usize,
) -> Result<Timing, Error> {
    let scene = scene(&specimen.packing(bench)?, specimen, mode);
    bench.ours(&name(specimen, mode), &scene, threads).map(|run| Timing(run.summary))
}

/// What an earlier call measured.
///
/// # Errors
/// None that a user could cause.
pub fn known(
    bench: &Bench,
    specimen: &Specimen,
    mode: Mode,
    threads: usize,
) -> Result<Option<Timing>, Error> {
    let (name, input) = point(specimen, mode, threads);
    bench.known(&name, &input)
}

/// Name of a measurement.
pub fn name(specimen: &Specimen, mode: Mode) -> String {
    format!("run-{}-{}", specimen.spheres, mode.name())
}

/// Name of a measurement, and what it depends on.
fn point(specimen: &Specimen, mode: Mode, threads: usize) -> (String, String) {
    // Where the packing lies makes no difference.
    let scene = scene(Path::new(&specimen.origin()), specimen, mode);
    (name(specimen, mode), format!("{scene}# {threads} threads"))
}

/// The paper's oedometer: 1 kPa on a wall that is drained, every other wall stands still and
/// lets nothing through.
pub fn scene(packing: &Path, specimen: &Specimen, mode: Mode) -> String {
    let (steps, interval) = (mode.steps(specimen), mode.interval(specimen));
    let (solver, keys) = (mode.solver(), mode.keys());
    format!(
        "title = \"{} spheres\"\n\
         [particles]\npacking = {packing:?}\ndensity = 2600.0\nyoung = 1.0e6\n\
         stiffness_ratio = 0.5\nfriction_angle = 30.0\n\
         [dem]\ndt = 1.0e-6\ndamping = 0.2\n\
         [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = {interval}\nsolver = \"{solver}\"\n{keys}\n\
         [[stage]]\nkind = \"run\"\nsteps = {steps}\nwalls = {{ y_max = {{ stress = {STRESS:?} }} }}\n\
         [output]\nhistory_every = {interval}\npictures = false\n",
        specimen.spheres
    )
}

impl Timing {
    /// A number of the summary; NaN if it is not there.
    pub fn number(&self, key: &str) -> f64 {
        self.0[key].as_f64().unwrap_or(f64::NAN)
    }

    /// A text of the summary; empty if it is not there.
    pub fn text(&self, key: &str) -> &str {
        self.0[key].as_str().unwrap_or_default()
    }

    /// Why not all factorizations were made on a GPU; `None` if they were.
    pub fn without_gpu(&self) -> Option<String> {
        let gpu = &self.0["gpu"];
        let calls: u64 = ["syrk_calls", "gemm_calls", "potrf_calls", "trsm_calls"]
            .iter()
            .filter_map(|key| gpu[key].as_u64())
            .sum();
        let reason = || gpu["reason"].as_str().unwrap_or("the run asked for none").to_owned();
        (calls == 0 || gpu["fallbacks"] != 0).then(reason)
    }

    /// The same run if each analysis and factorization took so long (s): its own were a cold
    /// start.
    pub fn with_factorization(mut self, analyze: f64, factor: f64) -> Timing {
        let remeshes = self.number("remeshes");
        for (phase, time) in [("analyze", analyze), ("factor", factor)] {
            let moved = 1e-3 * self.0["phases_ms"][phase].as_f64().unwrap_or(0.0) - time * remeshes;
            self.0["wall_s"] = (self.number("wall_s") - moved).into();
            self.0["phases_ms"][phase] = (1e3 * time * remeshes).into();
        }
        self
    }

    /// Name of the GPU that the run used.
    pub fn gpu_name(&self) -> &str {
        self.0["gpu"]["name"].as_str().unwrap_or_default()
    }

    /// Share of the factorization's operations that the GPU did (1).
    pub fn gpu_share(&self) -> f64 {
        self.0["gpu"]["share"].as_f64().unwrap_or(f64::NAN)
    }

    /// Cores that other programs kept busy just before, where the system told.
    pub fn busy_cores(&self) -> Option<f64> {
        self.0[BUSY].as_f64()
    }

    /// Time of a step without parallel tasks, measured by turns with this one (s).
    pub fn step_without_tasks(&self) -> Option<f64> {
        self.0[IN_TURN].as_f64()
    }

    /// Versions of the program and of its libraries when it was measured.
    pub fn versions(&self) -> BTreeMap<String, String> {
        let entries = self.0["versions"].as_object().into_iter().flatten();
        let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        entries.map(|(name, version)| (name.clone(), text(version))).collect()
    }

    /// Time of a phase of a step, mean over the steps (s).
    pub fn per_step(&self, phase: &str) -> f64 {
        self.phase(phase) / self.number("steps")
    }

    /// Time of a phase of a remesh, mean over the remeshes (s).
    pub fn per_remesh(&self, phase: &str) -> f64 {
        self.phase(phase) / self.number("remeshes")
    }

    /// Time of a remesh: network, analysis, factorization (s).
    pub fn remesh(&self) -> f64 {
        REMESH.iter().map(|phase| self.per_remesh(phase)).sum()
    }

    /// Time of a step between two remeshes, by the clock (s); of a run that remeshes in its
    /// time loop.
    pub fn step(&self) -> f64 {
        let remeshes: f64 = REMESH.iter().map(|phase| self.phase(phase)).sum();
        (self.number("wall_s") - remeshes) / self.number("steps")
    }

    /// Time of the whole run over its steps (s).
    pub fn wall_per_step(&self) -> f64 {
        self.number("wall_s") / self.number("steps")
    }

    /// Orderings and symbolic analyses; the other networks had the pattern of an earlier one.
    pub fn analyses(&self) -> f64 {
        self.0["remesh"]["analyses"].as_f64().unwrap_or(f64::NAN)
    }

    /// Total of a phase (s).
    fn phase(&self, name: &str) -> f64 {
        self.0["phases_ms"][name].as_f64().unwrap_or(f64::NAN) * 1e-3
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Ten steps of 3 s, of them 2 s in two remeshes: by hand.
    #[test]
    fn times_per_step_and_per_remesh() {
        let timing = Timing(json!({
            "steps": 10, "remeshes": 2, "wall_s": 3.0,
            "phases_ms": { "network": 200.0, "analyze": 800.0, "factor": 1000.0, "solve": 500.0 },
        }));
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(timing.remesh(), 1.0);
        near(timing.step(), 0.1);
        near(timing.wall_per_step(), 0.3);
        near(timing.per_step("solve"), 0.05);
        assert!(timing.per_step("nonsense").is_nan());
    }
}
