//! A coupled step: YADE and ours by turns; and the solves in our own time loop.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Contest;
use super::job::{Job, Run, Steps};
use super::sizes::Placed;
use crate::Error;
use crate::bench::sample::{Sample, worst};
use crate::compare::time::{INTERVAL, Specimen, Times, Tuning, YadeRun};

/// Packings of more spheres are run with that of YADE's solvers that was faster before.
const TRIED: usize = 20_000;
/// Packings of more spheres take two runs each.
const LARGE: usize = 100_000;
/// What the scene of a coupled step says of accuracy: what the contest allows. It bounds an
/// estimate that is on the safe side of the error; that is measured in each.
pub const TOLERANCE: &str = "1e-6";
/// What it says where a solve of ours is to leave the residual that CHOLMOD leaves: the
/// larger of these two that does, as was tried. In the smaller packing the spheres begin to
/// move while the contest lasts, and predictions err more: two corrections then leave a few
/// 1e-12, and a third is taken. The estimated error that this bounds is smaller than the residual,
/// which the stiffest throats rule.
fn all_digits(spheres: usize) -> &'static str {
    if spheres > TRIED { "1e-12" } else { "5e-14" }
}
/// Phases of our step, by their names in summaries.
pub const PHASES: [&str; 5] = ["contacts", "integration", "volume_rates", "solve", "fluid_forces"];
/// Phases of our remesh.
pub const REMESH: [&str; 3] = ["network", "analyze", "factor"];

/// How our time loop is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Way {
    /// A remesh stops the steps.
    InTurn,
    /// The next network is made beside the steps.
    Background,
}

impl Way {
    const ALL: [Way; 2] = [Way::InTurn, Way::Background];

    /// What the scene says for it.
    pub fn keys(self) -> &'static str {
        match self {
            Way::InTurn => "",
            Way::Background => "remesh = \"background\"\nparallel_tasks = true\n",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Way::InTurn => "in-turn",
            Way::Background => "background",
        }
    }
}

/// One packing in both programs.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub spheres: usize,
    pub pores: u64,
    /// YADE's fastest way.
    pub tuning: Tuning,
    /// A step, and a step with its share of a remesh every 200 (s).
    pub yade_step_s: Sample,
    pub yade_s: Sample,
    /// One remesh's network in YADE (s).
    pub yade_network_s: Sample,
    pub ours: Vec<Side>,
    pub pressure: Steps,
}

/// Ours, run in one way.
#[derive(Serialize, Deserialize)]
pub struct Side {
    pub way: Way,
    pub steps: u64,
    /// A step with its share of a remesh every 200 (s): a whole number of intervals, by the
    /// clock.
    pub whole_s: Sample,
    /// The same without the time of remeshes that stopped the steps (s).
    pub step_s: Sample,
    /// Time per step in each of [`PHASES`] (s), median run.
    pub phases_s: Vec<f64>,
    /// Time per remesh in each of [`REMESH`] (s), median run.
    pub remesh_s: Vec<f64>,
    pub peak_bytes: f64,
    /// Between spheres and with walls, at the end.
    pub contacts: f64,
}

/// The solves in our time loop on one packing, by solver.
#[derive(Serialize, Deserialize)]
pub struct Inside {
    pub spheres: usize,
    pub steps: usize,
    pub sides: Vec<InsideSide>,
}

/// One solver in the time loop.
#[derive(Serialize, Deserialize)]
pub struct InsideSide {
    pub solver: String,
    /// The tolerance that the scene asks for; none where it leaves the default.
    pub tolerance: Option<String>,
    pub unknowns: f64,
    pub nnz_l: f64,
    /// Of each step but the first ten (s).
    pub solve_s: Sample,
    /// Worst of the checks.
    pub residual: f64,
    pub pressure_error: f64,
}

/// Runs both programs by turns. `before`: how YADE was the fastest on a smaller packing.
///
/// # Errors
/// One of them fails.
pub fn measure(contest: &Contest, placed: &Placed, before: Option<Tuning>) -> Result<Case, Error> {
    let specimen = Specimen::new(placed.spheres, placed.path.clone(), placed.bounds);
    let tuning = tuning(contest, &specimen, before)?;
    let runs = if placed.spheres > LARGE { contest.runs.min(2) } else { contest.runs };
    let mut case = Case {
        spheres: placed.spheres,
        pores: 0,
        tuning,
        yade_step_s: Sample::default(),
        yade_s: Sample::default(),
        yade_network_s: Sample::default(),
        ours: vec![],
        pressure: pressure(contest, placed)?,
    };
    let mut summaries: Vec<Vec<Value>> = vec![vec![]; Way::ALL.len()];
    // The first run with many spheres is that which showed the fastest way.
    let first = usize::from(placed.spheres <= LARGE);
    for run in first..first + runs {
        let (times, pores) = yade(contest, &specimen, tuning, run)?;
        case.pores = pores;
        case.yade_step_s.0.push(1e-3 * times.step.all);
        case.yade_s.0.push(1e-3 * times.per_step(INTERVAL));
        case.yade_network_s.0.push(1e-3 * times.remesh.network());
        for (way, summaries) in Way::ALL.into_iter().zip(&mut summaries) {
            summaries.push(ours(contest, placed, way, run)?);
        }
    }
    case.ours = Way::ALL.into_iter().zip(summaries).map(|(way, s)| Side::new(way, s)).collect();
    Ok(case)
}

/// YADE's fastest way: each of its solvers with one thread of the BLAS and with all.
fn tuning(contest: &Contest, specimen: &Specimen, before: Option<Tuning>) -> Result<Tuning, Error> {
    let known = before.filter(|_| specimen.spheres > TRIED).map(|tuning| [tuning.solver]);
    let mut fastest = (f64::INFINITY, Tuning { solver: Tuning::DEFAULT, blas_threads: 1 });
    for &solver in known.as_ref().map_or(&Tuning::SOLVERS[..], |one| &one[..]) {
        for tuning in Tuning::all(solver, contest.threads) {
            let (times, _) = yade(contest, specimen, tuning, 0)?;
            if times.per_step(INTERVAL) < fastest.0 {
                fastest = (times.per_step(INTERVAL), tuning);
            }
        }
    }
    Ok(fastest.1)
}

fn yade(
    contest: &Contest,
    specimen: &Specimen,
    tuning: Tuning,
    run: usize,
) -> Result<(Times, u64), Error> {
    YadeRun::new(specimen, contest.threads, tuning, run)
        .yade(contest.bench)
        .map(|(side, pores)| (side.times, pores))
}

/// Our run: whole intervals between remeshes, so that each has its share.
fn ours(contest: &Contest, placed: &Placed, way: Way, run: usize) -> Result<Value, Error> {
    let intervals = if placed.spheres > LARGE { 2 } else { 3 };
    let steps = intervals * INTERVAL as u64;
    let scene = scene(placed, steps, &(asks_for(TOLERANCE) + way.keys()), contest.ours);
    let name = format!("coupled-{}-{}-run{run}", placed.spheres, way.name());
    let bench = contest.bench;
    bench.remembered(&name, &(&scene, run), || {
        Ok(bench.ours(&name, &scene, contest.threads)?.summary)
    })
}

/// How far our pressures are from the direct solution, in a run of its own.
fn pressure(contest: &Contest, placed: &Placed) -> Result<Steps, Error> {
    // After a remesh that has a predecessor too, whose steps are few with many spheres.
    let steps = if placed.spheres > LARGE { 24 } else { 240 };
    let scene = scene(placed, steps as u64, &asks_for(TOLERANCE), contest.ours);
    let scene = match placed.spheres > LARGE {
        true => scene.replace("remesh_interval = 200", "remesh_interval = 12"),
        false => scene,
    };
    let checks = match placed.spheres > LARGE {
        true => vec![11, 13, 24],
        false => vec![1, 2, 10, 199, 200, 201, 202, 240],
    };
    run(contest, &format!("pressure-{}", placed.spheres), Run { scene, steps, checks, run: 0 })
}

fn run(contest: &Contest, name: &str, job: Run) -> Result<Steps, Error> {
    let bench = contest.bench;
    bench.remembered(name, &job, || bench.job(name, &Job::Run(job.clone()), contest.threads))
}

/// Solves in the time loop with CHOLMOD and with ours, by turns.
///
/// # Errors
/// A run fails.
pub fn inside(contest: &Contest, placed: &Placed) -> Result<Inside, Error> {
    let steps = contest.scaled(3_000_000 / placed.spheres as u64).clamp(40, 150) as usize;
    let runs = if placed.spheres > LARGE { 1 } else { contest.runs.min(2) };
    // A check takes a factorization by CHOLMOD.
    let checks = match placed.spheres > LARGE {
        true => vec![steps],
        false => vec![steps / 2, steps * 5 / 6, steps],
    };
    let mut solvers = vec![("cholmod", None)];
    if contest.ours != "cholmod" {
        let ours =
            [(contest.ours, Some(all_digits(placed.spheres))), (contest.ours, Some(TOLERANCE))];
        solvers.extend([ours[0], ("cholmod", Some(TOLERANCE)), ours[1]]);
    }
    let mut sides: Vec<InsideSide> = vec![];
    for number in 0..runs {
        for &(solver, tolerance) in &solvers {
            let kind = if tolerance == Some(TOLERANCE) { "-rough" } else { "" };
            let keys = tolerance.map_or(String::new(), asks_for);
            let scene = scene(placed, steps as u64, &keys, solver);
            let name = format!("inside-{}-{solver}{kind}-run{number}", placed.spheres);
            let job = Run { scene, steps, checks: checks.clone(), run: number };
            let done = run(contest, &name, job)?;
            let residual = worst(done.residuals.iter().copied());
            let error = worst(done.pressure_errors.iter().copied());
            // The first steps have nothing to start from.
            let solves = &done.solve_s[done.solve_s.len().min(10)..];
            let same = |s: &&mut InsideSide| s.solver == solver && s.tolerance() == tolerance;
            match sides.iter_mut().find(same) {
                Some(side) => {
                    side.solve_s.0.extend(solves);
                    side.residual = worst([side.residual, residual]);
                    side.pressure_error = worst([side.pressure_error, error]);
                }
                None => sides.push(InsideSide {
                    solver: solver.to_owned(),
                    tolerance: tolerance.map(str::to_owned),
                    unknowns: done.unknowns,
                    nnz_l: done.nnz_l,
                    solve_s: Sample(solves.to_vec()),
                    residual,
                    pressure_error: error,
                }),
            }
        }
    }
    Ok(Inside { spheres: placed.spheres, steps, sides })
}

impl Inside {
    /// A solver's side with the tolerance of coupled steps, or that with all digits, if it
    /// was measured.
    pub fn side(&self, solver: &str, rough: bool) -> Option<&InsideSide> {
        let is_rough = |side: &InsideSide| side.tolerance() == Some(TOLERANCE);
        self.sides.iter().find(|side| side.solver == solver && is_rough(side) == rough)
    }
}

impl InsideSide {
    /// The tolerance that the scene asks for; none where it leaves the default.
    pub fn tolerance(&self) -> Option<&str> {
        self.tolerance.as_deref()
    }
}

impl Side {
    fn new(way: Way, mut summaries: Vec<Value>) -> Side {
        let number = |s: &Value, key: &str| s[key].as_f64().unwrap_or(f64::NAN);
        let phase = |s: &Value, name: &str| 1e-3 * number(&s["phases_ms"], name);
        let stopped = |s: &Value| match way {
            Way::InTurn => REMESH.iter().map(|name| phase(s, name)).sum(),
            Way::Background => 0.0,
        };
        let per_step = |s: &Value, time: f64| time / number(s, "steps");
        let whole = |s: &Value| per_step(s, number(s, "wall_s"));
        summaries.sort_by(|a, b| whole(a).total_cmp(&whole(b)));
        let middle = summaries.get(summaries.len() / 2).cloned().unwrap_or_default();
        let peaks = summaries.iter().map(|s| number(s, "peak_memory_bytes"));
        Side {
            way,
            steps: number(&middle, "steps") as u64,
            whole_s: summaries.iter().map(whole).collect(),
            step_s: summaries
                .iter()
                .map(|s| per_step(s, number(s, "wall_s") - stopped(s)))
                .collect(),
            phases_s: PHASES.iter().map(|name| per_step(&middle, phase(&middle, name))).collect(),
            remesh_s: REMESH
                .iter()
                .map(|name| phase(&middle, name) / number(&middle, "remeshes"))
                .collect(),
            peak_bytes: peaks.fold(f64::NAN, f64::max),
            contacts: number(&middle, "contacts"),
        }
    }
}

/// What a scene says for a tolerance.
fn asks_for(tolerance: &str) -> String {
    format!("tolerance = {tolerance}\n")
}

/// The paper's specimen, as YADE's script has it.
fn scene(placed: &Placed, steps: u64, keys: &str, solver: &str) -> String {
    format!(
        "title = \"{} spheres\"\n\
         [particles]\npacking = {:?}\ndensity = 2600.0\nyoung = 1.0e6\n\
         stiffness_ratio = 0.5\nfriction_angle = 30.0\n\
         [walls]\nfriction_angle = 0.0\n\
         [dem]\ndt = 1.0e-6\ndamping = 0.2\n\
         [fluid]\nviscosity = 1.0e-3\nclamp = \"yade\"\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = 200\nsolver = {solver:?}\n{keys}\n\
         [[stage]]\nkind = \"run\"\nsteps = {steps}\nwalls = {{ y_max = {{ stress = 1.0e3 }} }}\n\
         [output]\nhistory_every = {steps}\npictures = false\n",
        placed.spheres, placed.path,
    )
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Ten steps in 3 s, of them 2 s in two remeshes: by hand.
    #[test]
    fn remeshes_that_stop_the_steps_are_told_apart() {
        let summary = json!({
            "steps": 10, "remeshes": 2, "wall_s": 3.0, "peak_memory_bytes": 7,
            "phases_ms": { "network": 200.0, "analyze": 800.0, "factor": 1000.0, "solve": 500.0 },
        });
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let side = Side::new(Way::InTurn, vec![summary.clone()]);
        near(side.whole_s.median(), 0.3);
        near(side.step_s.median(), 0.1);
        near(side.phases_s[3], 0.05);
        near(side.remesh_s[2], 0.5);
        let side = Side::new(Way::Background, vec![summary]);
        near(side.step_s.median(), 0.3);
    }
}
