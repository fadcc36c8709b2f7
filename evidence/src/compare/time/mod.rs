//! The part `time` of the comparison: the same coupled steps in both programs, phase by
//! phase, and the memory that they take.

mod measured;
mod record;
mod runs;
mod section;

use std::path::{Path, PathBuf};
use std::time::Duration;

use dempfv_report::machine;
use serde::{Deserialize, Serialize};

pub use self::measured::Times;
use self::runs::Job;
pub use self::runs::{Job as YadeRun, Specimen, Tuning};
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;

/// Packings of up to so many spheres are measured [`REPEATS`] times; the largest of them
/// shows which of YADE's solvers is the faster.
const SMALL: usize = 5_000;
const REPEATS: usize = 3;
/// Steps between remeshes that times per step are quoted for, as in the paper.
pub const INTERVAL: f64 = 200.0;
/// How long the machine is looked at before the first run.
const LOOK: Duration = Duration::from_secs(2);

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    /// Cores that other programs kept busy just before.
    busy_cores: Option<f64>,
    /// YADE's solvers on one packing.
    trials: Vec<Trial>,
    cases: Vec<Case>,
}

/// One way to let YADE solve.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Trial {
    spheres: usize,
    threads: usize,
    tuning: Tuning,
    times: Times,
}

/// Both programs on one packing with one number of threads.
#[derive(Serialize, Deserialize)]
struct Case {
    spheres: usize,
    pores: u64,
    threads: usize,
    /// How YADE solved: the fastest way.
    tuning: Tuning,
    /// Number of runs of each program; of their times the median run is kept.
    runs: usize,
    /// Steps of each run.
    steps: u64,
    yade: Side,
    ours: Side,
}

/// One program in a case.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Side {
    pub times: Times,
    /// The most memory that the process held (bytes).
    peak_memory_bytes: u64,
    /// What of it the program takes before it has any sphere (bytes), where known.
    base_memory_bytes: Option<u64>,
}

impl super::Part for Part {
    const NAME: &'static str = "time";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Part, Error> {
        let specimens = runs::specimens(bench, packings)?;
        let busy_cores = machine::busy_cores(LOOK);
        let threads: &[usize] = match std::thread::available_parallelism().map_or(1, usize::from) {
            1 => &[1],
            _ => &[1, 2],
        };
        let (trials, solver) = solver_trials(bench, &specimens, threads)?;
        let mut cases = Vec::new();
        for specimen in &specimens {
            for &threads in threads {
                cases.push(Case::measure(bench, specimen, threads, solver)?);
            }
        }
        Ok(Part { busy_cores, trials, cases })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        vec![]
    }

    fn headline(&self) -> Option<String> {
        section::headline(self)
    }

    fn section(&self, folder: &Path) -> Result<String, Error> {
        section::write(self, folder)
    }
}

/// YADE's two ways to CHOLMOD on the largest of the small packings, and the faster one.
fn solver_trials(
    bench: &Bench,
    specimens: &[Specimen],
    threads: &[usize],
) -> Result<(Vec<Trial>, u32), Error> {
    let small = specimens.iter().filter(|s| s.spheres <= SMALL).max_by_key(|s| s.spheres);
    let Some(specimen) = small.or(specimens.first()) else { return Ok((vec![], Tuning::DEFAULT)) };
    let mut trials = Vec::new();
    for &threads in threads {
        for solver in Tuning::SOLVERS {
            for tuning in Tuning::all(solver, threads) {
                let side = Job::new(specimen, threads, tuning, 0).yade(bench)?.0;
                trials.push(Trial {
                    spheres: specimen.spheres,
                    threads,
                    tuning,
                    times: side.times,
                });
            }
        }
    }
    // With all threads, as most who wait for it will run it.
    let most = threads.iter().copied().max().unwrap_or(1);
    let fastest = trials
        .iter()
        .filter(|t| t.threads == most)
        .min_by(|a, b| a.times.per_step(INTERVAL).total_cmp(&b.times.per_step(INTERVAL)));
    let solver = fastest.map_or(Tuning::DEFAULT, |t| t.tuning.solver);
    Ok((trials, solver))
}

impl Case {
    /// Runs of YADE and of ours by turns, so that a drift of the machine's speed meets
    /// both; before them, one run of YADE with one thread of the BLAS and one with all
    /// shows which is its faster way.
    fn measure(
        bench: &Bench,
        specimen: &Specimen,
        threads: usize,
        solver: u32,
    ) -> Result<Case, Error> {
        let time = |side: &Side| side.times.per_step(INTERVAL);
        let mut tuning = Tuning { solver, blas_threads: 1 };
        let (mut alone, pores) = Job::new(specimen, threads, tuning, 0).yade(bench)?;
        for other in Tuning::all(solver, threads).skip(1) {
            let (side, _) = Job::new(specimen, threads, other, 0).yade(bench)?;
            if time(&side) < time(&alone) {
                (tuning, alone) = (other, side);
            }
        }
        let small = specimen.spheres <= SMALL;
        let runs = if small { 1..=REPEATS } else { 0..=0 };
        let (mut yade, mut ours) = (vec![], vec![]);
        for run in runs {
            let job = Job::new(specimen, threads, tuning, run);
            yade.push(if small { job.yade(bench)?.0 } else { alone });
            ours.push(job.ours(bench)?);
        }
        Ok(Case {
            spheres: specimen.spheres,
            pores,
            threads,
            tuning,
            runs: yade.len(),
            steps: Job::new(specimen, threads, tuning, 0).steps,
            yade: median(yade),
            ours: median(ours),
        })
    }
}

/// The run with the median time per step; there is at least one.
fn median(mut runs: Vec<Side>) -> Side {
    let time = |s: &Side| s.times.per_step(INTERVAL);
    runs.sort_by(|a, b| time(a).total_cmp(&time(b)));
    runs[runs.len() / 2]
}
