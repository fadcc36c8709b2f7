//! What a run leaves in `summary.json`, and says at its end.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dempfv::Calls;
use dempfv::coupling::{Coupled, GpuUse};
use dempfv::dem::EnergyBalance;
use dempfv::scene::{Dem, TimeStep};
use dempfv::simulation::{Advice, Estimate, Specimen};
use dempfv::simulation::{Consolidation, Grading, Outcome, Simulation, StageOutcome};
use dempfv::solver::SolverKind;
use dempfv_report::format::{bytes, count, duration, si, three_digits};
use dempfv_report::table;
use dempfv_report::{machine, versions};
use serde::Serialize;

use super::super::kernels;
use super::accuracy::Accuracy;
use super::remesh::Remesh;
use super::restart::Restart;

/// How a run ended.
pub struct Status {
    /// All stages are done.
    pub finished: bool,
    /// Ctrl-C ended it.
    pub interrupted: bool,
    /// Why it could not go on.
    pub error: Option<String>,
    /// A warning of the memory that there was at its beginning.
    pub tight: Option<String>,
}

/// Everything about a run that fits on a page.
#[derive(Serialize)]
pub struct Report {
    title: String,
    finished: bool,
    /// Ctrl-C ended the run.
    pub interrupted: bool,
    error: Option<String>,
    /// The checkpoint that this session went on from, and what its scene has changed.
    restart: Option<Restart>,
    particles: usize,
    pores: usize,
    unknowns: usize,
    /// Spheres that are a vertex of no pore, by the user's numbers.
    hidden: Vec<u32>,
    contacts: usize,
    /// Diameters by mass, as they are at the end.
    grading: Option<Grading>,
    /// Bonds that hold and that have broken; `None` where there are none.
    bonds: Option<BondCount>,
    /// Steps since the simulation began, restarts included.
    steps: u64,
    steps_this_session: u64,
    model_time_s: f64,
    /// Of this session, as the times below.
    wall_s: f64,
    /// `None` where nothing moved.
    ms_per_step: Option<f64>,
    phases_ms: BTreeMap<&'static str, f64>,
    remeshes: u64,
    /// How often this process called for triangulations, factorizations and neighbour lists.
    calls: Calls,
    /// What happened at them, in this session; `None` without fluid.
    remesh: Option<Remesh>,
    /// Largest relative residual of the first solves after factorizations.
    largest_residual: f64,
    /// Largest relative imbalance of fluid mass of any step.
    largest_imbalance: f64,
    /// The error that the run keeps to; `None` without `[accuracy]`.
    accuracy: Option<Accuracy>,
    /// Energy by cause (J) since the last stage that grew spheres; `None` where it is not tracked.
    energy: Option<EnergyBalance>,
    peak_memory_bytes: Option<u64>,
    threads: usize,
    solver: Option<&'static str>,
    /// The solver that has the last factor: `auto` leaves it to another.
    solved_by: Option<&'static str>,
    /// What became of the factorizations; `None` unless the solver asks for a GPU.
    gpu: Option<GpuUse>,
    effects: Vec<&'static str>,
    /// What dimensionless numbers say about the effects of the scene.
    advice: Vec<Advice>,
    /// What a user should know, a sentence each.
    warnings: Vec<String>,
    versions: BTreeMap<&'static str, String>,
    state_hash: String,
    stages: Vec<FinishedStage>,
    #[serde(skip)]
    folder: PathBuf,
}

/// What became of the bonds.
#[derive(Serialize)]
struct BondCount {
    intact: u64,
    broken: u64,
}

/// A stage with what it found out as one more key, `consolidate` for example. (Checkpoints
/// keep the outcome as a field: their encoding has no such keys.)
#[derive(Serialize)]
struct FinishedStage {
    name: String,
    steps: u64,
    model_time_s: f64,
    /// Time step, the stage's own or that of `[dem]`; `None` where nothing moves.
    dt: Option<TimeStep>,
    /// Local damping (1), likewise.
    damping: Option<f64>,
    #[serde(flatten)]
    outcome: Outcome,
}

impl FinishedStage {
    fn of(mechanics: Option<Dem>, done: &StageOutcome) -> FinishedStage {
        FinishedStage {
            name: done.name.clone(),
            steps: done.steps,
            model_time_s: done.model_time_s,
            dt: mechanics.as_ref().map(|m| m.dt),
            damping: mechanics.map(|m| m.options.damping),
            outcome: done.outcome.clone(),
        }
    }
}

impl Report {
    /// Sums up a simulation after `steps` steps in this session.
    pub fn new(
        simulation: &Simulation,
        threads: usize,
        wall: Duration,
        steps: u64,
        status: Status,
        (restart, folder): (Option<Restart>, &Path),
    ) -> Report {
        let (plan, coupled) = (simulation.plan(), simulation.coupled());
        let seen = simulation.observe();
        let (pores, unknowns) = networks(simulation);
        let wall_s = wall.as_secs_f64();
        let kernels = plan.fluid.as_ref().and_then(|fluid| kernels::warning(fluid.solver));
        let stage = |(stage, done)| FinishedStage::of(plan.mechanics(stage), done);
        Report {
            title: plan.title.clone(),
            finished: status.finished,
            interrupted: status.interrupted,
            error: status.error,
            restart,
            particles: coupled.dem().storage().len(),
            pores,
            unknowns,
            hidden: hidden(coupled),
            contacts: seen.contacts,
            grading: Grading::of(&coupled.dem().storage().radius),
            bonds: plan.bonds.is_some().then(|| BondCount {
                intact: coupled.dem().intact_bonds(),
                broken: coupled.dem().broken_bonds(),
            }),
            steps: simulation.step(),
            model_time_s: simulation.time(),
            wall_s,
            steps_this_session: steps,
            ms_per_step: (steps > 0).then(|| 1e3 * wall_s / steps as f64),
            phases_ms: coupled.phases().in_ms().collect(),
            remeshes: simulation.remeshes(),
            calls: Calls::so_far(),
            remesh: plan.fluid.is_some().then(|| Remesh::of(coupled)),
            largest_residual: coupled.largest_residual(),
            largest_imbalance: coupled.largest_imbalance(),
            accuracy: Accuracy::of(simulation),
            energy: coupled.dem().energy_balance(),
            peak_memory_bytes: machine::own_memory(machine::PEAK),
            threads,
            solver: plan.fluid.as_ref().map(|f| f.solver.name()),
            solved_by: coupled.storage_flow().and_then(|flow| flow.solved_by()),
            gpu: plan
                .fluid
                .as_ref()
                .filter(|f| matches!(f.solver, SolverKind::CholmodGpu(_)))
                .map(|_| coupled.gpu_use().clone()),
            effects: plan.effects_on(),
            advice: advice(simulation),
            warnings: status
                .tight
                .into_iter()
                .chain(simulation.warnings())
                .chain(kernels)
                .collect(),
            versions: versions::all(),
            state_hash: simulation.state_hash(),
            stages: plan.stages.iter().zip(simulation.outcomes()).map(stage).collect(),
            folder: folder.to_owned(),
        }
    }

    fn consolidation(&self) -> Option<&Consolidation> {
        self.stages.iter().rev().find_map(|s| match &s.outcome {
            Outcome::Consolidate(c) => Some(c),
            _ => None,
        })
    }
}

/// What a GPU did, by its own counters, or why it did not.
fn gpu_line(gpu: &GpuUse) -> String {
    let mut parts = vec![];
    if let Some(work) = &gpu.work {
        parts.push(format!(
            "{} factorizations on {} ({} calls, {:.0} % of the last one's operations)",
            count(gpu.factorizations),
            work.name,
            count(work.calls()),
            100.0 * work.share.min(1.0)
        ));
    }
    if let Some(reason) = &gpu.reason {
        parts.push(format!("{} on the CPU: {reason}", count(gpu.fallbacks)));
    }
    if parts.is_empty() {
        "GPU: nothing was factored".to_owned()
    } else {
        format!("GPU: {}", parts.join("; "))
    }
}

/// What the sizes of the spheres, as they are now, say about the effects of the plan.
fn advice(simulation: &Simulation) -> Vec<Advice> {
    let (plan, dem) = (simulation.plan(), simulation.coupled().dem());
    let (radii, bounds) = (&dem.storage().radius, dem.box_());
    let specimen = Specimen::of_radii(radii).in_box(radii, &bounds, plan);
    let estimate = Estimate::of(plan, &specimen);
    estimate.map_or_else(|_| vec![], |e| Advice::of(plan, &specimen, &e, &bounds))
}

fn hidden(coupled: &Coupled) -> Vec<u32> {
    let Some(flow) = coupled.storage_flow() else { return vec![] };
    let id = &coupled.dem().storage().id;
    let mut numbers: Vec<u32> =
        flow.network().tessellation.hidden.iter().map(|&i| id[i as usize]).collect();
    numbers.sort_unstable();
    numbers
}

/// Pores and unknowns of the current network; where there is none, of the
/// last static flow.
fn networks(simulation: &Simulation) -> (usize, usize) {
    if let Some(flow) = simulation.coupled().storage_flow() {
        return (flow.network().pores(), flow.operators().unknowns());
    }
    let test = simulation.outcomes().iter().rev().find_map(|o| match &o.outcome {
        Outcome::Permeability(test) => Some((test.pores as usize, test.unknowns as usize)),
        _ => None,
    });
    test.unwrap_or_default()
}

/// A stage's result in a few words.
pub fn headline(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Compact(c) => format!(
            "σ {}, porosity {}, {} contacts a sphere",
            si(c.stress_pa, "Pa"),
            three_digits(c.porosity),
            three_digits(c.coordination_number)
        ),
        Outcome::Cycle(c) => {
            format!(
                "E_oed {} loading, {} unloading",
                si(c.modulus_pa, "Pa"),
                si(c.unloading_modulus_pa, "Pa")
            )
        }
        Outcome::Permeability(p) => format!(
            "k_{} = {:.3e} m² ({}{}Kozeny-Carman with {} {:.3e} m²)",
            p.axis,
            p.permeability_m2,
            p.slip_walls.map_or("", |slip| if slip {
                "slip at walls; "
            } else {
                "no slip at walls; "
            }),
            p.core_permeability_m2
                .map_or(String::new(), |k| format!("{k:.3e} m² away from them, ")),
            p.kozeny_carman_constant,
            p.kozeny_carman_m2
        ),
        Outcome::Flow(f) => {
            let within = f.imposed_flux_m3_s.iter();
            let entering: f64 = f.flux_m3_s.iter().chain(within).map(|q| q.max(0.0)).sum();
            format!("{entering:.3e} m³/s enter, mean pressure {}", si(f.mean_pressure_pa, "Pa"))
        }
        Outcome::Consolidate(c) => format!(
            "settlement {} of {}, U off Terzaghi by {:.3} at most",
            si(c.samples.last().map_or(0.0, |s| s.settlement_m), "m"),
            si(c.final_settlement_m, "m"),
            c.largest_error(0.1, f64::INFINITY)
        ),
        Outcome::Run(m) => {
            let [x, y, z] = m.strain.map(three_digits);
            format!("strain {x}, {y}, {z}, unbalanced {:.1e}", m.unbalanced_force)
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.title)?;
        if let Some(restart) = &self.restart {
            writeln!(f, "{restart}")?;
        }
        for stage in &self.stages {
            writeln!(
                f,
                "  {:<14} {:>9} steps  {}",
                stage.name,
                count(stage.steps),
                headline(&stage.outcome)
            )?;
        }
        if let Some(c) = self.consolidation() {
            write!(f, "\n{}", against_terzaghi(c))?;
        }
        let phases: Vec<String> = self
            .phases_ms
            .iter()
            .filter(|(_, ms)| **ms > 0.0)
            .map(|(name, ms)| format!("{} {:.1} s", name.replace('_', " "), ms / 1e3))
            .collect();
        let memory = self
            .peak_memory_bytes
            .map_or(String::new(), |b| format!(", at most {}", bytes(b as f64)));
        let threads =
            if self.threads == 1 { "1 thread" } else { &format!("{} threads", self.threads) };
        let pace = self.ms_per_step.map_or(String::new(), |ms| {
            format!("{} steps, {ms:.3} ms each, ", count(self.steps_this_session))
        });
        writeln!(f, "\n  {pace}{} on {threads}{memory}", duration(self.wall_s))?;
        if !phases.is_empty() {
            writeln!(f, "  {}", phases.join(", "))?;
        }
        if let Some(line) = self.remesh.as_ref().and_then(Remesh::line) {
            writeln!(f, "  {line}")?;
        }
        if let Some(accuracy) = &self.accuracy {
            writeln!(f, "  {accuracy}")?;
        }
        if let Some(gpu) = &self.gpu {
            writeln!(f, "  {}", gpu_line(gpu))?;
        }
        self.warnings.iter().try_for_each(|w| writeln!(f, "  warning: {w}"))?;
        if !self.finished {
            writeln!(
                f,
                "  not finished: go on with --restart {}",
                self.folder.join(super::CHECKPOINT).display()
            )?;
        }
        writeln!(f, "  state {}", self.state_hash)?;
        self.write_files(f)
    }
}

impl Report {
    fn write_files(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names: Vec<String> = std::fs::read_dir(&self.folder)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|e| e.file_name().into_string().ok())
            .filter(|n| !n.ends_with(".vtu"))
            .collect();
        names.sort();
        writeln!(f, "  in {}: {}", self.folder.display(), names.join(", "))
    }
}

/// Measured and predicted degree of consolidation at round time factors.
fn against_terzaghi(c: &Consolidation) -> String {
    let layers = c.wall_layers();
    let rows: Vec<Vec<String>> = [0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5]
        .into_iter()
        .filter_map(|at| c.samples.iter().find(|s| s.time_factor >= at))
        .map(|s| {
            let plain = dempfv::theory::degree_of_consolidation(s.time_factor);
            let theory = layers.degree(s.time_factor);
            [s.time_factor, s.degree, theory, plain, s.degree - theory]
                .map(|v| format!("{v:.3}"))
                .to_vec()
        })
        .collect();
    table(&["T_v", "U measured", "Terzaghi, wall layers", "Terzaghi", "difference"], &rows)
}
