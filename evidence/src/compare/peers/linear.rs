//! The linear systems of real networks through every solver, by turns.

use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use super::Contest;
use super::job::{Errors, Job, Linear, Made, Solved, System, Systemize};
use super::sizes::Placed;
use crate::Error;
use crate::bench::sample::{Sample, worst};

/// The script that runs PARDISO.
const PARDISO: &str = include_str!("../scripts/pardiso.py");
/// Systems of more unknowns are factored once.
const LARGE: usize = 1_000_000;
/// Systems of more unknowns than this are factored in two runs only.
const MEDIUM: usize = 500_000;

/// One system in all solvers.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub spheres: usize,
    pub origin: String,
    pub unknowns: usize,
    pub entries: usize,
    pub sides: Vec<Side>,
    /// Solvers that failed, and how.
    pub failed: Vec<String>,
}

/// One solver.
#[derive(Serialize, Deserialize)]
pub struct Side {
    /// Its name in the report.
    pub name: String,
    pub ordering: String,
    pub version: String,
    pub analyze_s: Sample,
    pub factor_s: Sample,
    pub solve_s: Sample,
    pub nnz_l: f64,
    pub flops: Option<f64>,
    pub factor_bytes: f64,
    pub base_bytes: f64,
    /// The most that the process held, system included.
    pub peak_bytes: f64,
    pub errors: Errors,
}

impl Case {
    /// The solver with this name, if it was measured.
    pub fn side(&self, name: &str) -> Option<&Side> {
        self.sides.iter().find(|side| side.name == name)
    }
}

impl Side {
    /// The most memory that the process took beyond the system itself (bytes).
    pub fn taken(&self) -> f64 {
        self.peak_bytes - self.base_bytes
    }
}

/// Names of the solvers in the report.
pub const CHOLMOD: &str = "CHOLMOD";
/// See [`CHOLMOD`].
pub const PARDISO_NAME: &str = "PARDISO";
/// See [`CHOLMOD`].
pub const FAER: &str = "faer";

/// Runs the solvers by turns.
///
/// # Errors
/// One of them fails.
pub fn measure(contest: &Contest, placed: &Placed) -> Result<Case, Error> {
    let bench = contest.bench;
    let name = format!("linear-{}", placed.spheres);
    let file = bench.folder.join("scenes").join(format!("{name}.system"));
    let systemize = Systemize { packing: placed.path.clone(), file: file.clone() };
    let made = || bench.job::<Made>(&name, &Job::Systemize(systemize.clone()), contest.threads);
    // Someone may have removed the file, which is large.
    let made = match file.is_file() {
        true => bench.remembered(&name, &systemize, made)?,
        false => {
            bench.forget(&format!("{name}."))?;
            bench.remembered(&name, &systemize, made)?
        }
    };
    let runs = match made.unknowns {
        n if n > LARGE => 1,
        n if n > MEDIUM => contest.runs.min(2),
        _ => contest.runs,
    };
    let (mut sides, mut failed): (Vec<Side>, Vec<String>) = (vec![], vec![]);
    for run in 0..runs {
        for solver in solvers(contest) {
            let done = one(contest, &file, made.unknowns, &name, &solver, run);
            // The largest systems may be too large for one or the other.
            let (solved, errors) = match done {
                Ok(done) => done,
                Err(error @ Error::Peer { .. }) => {
                    failed.push(format!("{}: {error}", solver.title));
                    continue;
                }
                Err(error) => return Err(error),
            };
            match sides.iter_mut().find(|side| side.name == solver.title) {
                Some(side) => side.add(solved, errors),
                None => sides.push(Side::new(&solver.title, solved, errors)),
            }
        }
    }
    let Made { unknowns, entries } = made;
    let (spheres, origin) = (placed.spheres, placed.origin.clone());
    Ok(Case { spheres, origin, unknowns, entries, sides, failed })
}

/// A solver that is run, and by which program.
struct Solver {
    title: String,
    by: By,
}

enum By {
    /// Ours, by its name, with so many threads of the BLAS if not its own choice.
    Own(String, Option<usize>),
    Pardiso,
    Faer,
}

/// All solvers, in the order in which they take turns.
fn solvers(contest: &Contest) -> Vec<Solver> {
    let mut found = vec![Solver {
        title: CHOLMOD.to_owned(),
        by: By::Own("cholmod".to_owned(), Some(contest.threads)),
    }];
    if contest.ours != "cholmod" {
        let title = contest.ours.to_owned();
        found.push(Solver { by: By::Own(title.clone(), None), title });
    }
    if contest.others.pardiso.is_some() {
        found.push(Solver { title: PARDISO_NAME.to_owned(), by: By::Pardiso });
    }
    if contest.others.faer.is_some() {
        found.push(Solver { title: FAER.to_owned(), by: By::Faer });
    }
    found
}

/// One run of one solver, judged.
fn one(
    contest: &Contest,
    file: &Path,
    unknowns: usize,
    name: &str,
    solver: &Solver,
    run: usize,
) -> Result<(Solved, Errors), Error> {
    let bench = contest.bench;
    let name = format!("{name}-{}-run{run}", solver.title.to_lowercase());
    let solution = bench.folder.join("jobs").join(format!("{name}.solution"));
    let (own, blas_threads) = match &solver.by {
        By::Own(own, blas) => (own.clone(), *blas),
        By::Pardiso | By::Faer => (String::new(), None),
    };
    let job = Linear {
        system: file.to_owned(),
        solution: solution.clone(),
        solver: own,
        blas_threads,
        // CHOLMOD as people have it: ordered by METIS.
        with_points: blas_threads.is_none(),
        threads: contest.threads,
        factors: if unknowns > LARGE { 1 } else { 2 },
        solves: if unknowns > LARGE { 3 } else { 7 },
        run,
    };
    bench.remembered(&name, &(&job, unknowns), || {
        let solved: Solved = match (&solver.by, &contest.others.pardiso, &contest.others.faer) {
            (By::Pardiso, Some(python), _) => {
                let command = Command::new(python);
                bench.script(&name, "Python", command, PARDISO, contest.threads, &job)?.result
            }
            (By::Faer, _, Some(faer)) => bench.ask(&name, "faer-peer", Command::new(faer), &job)?,
            _ => bench.job(&name, &Job::Linear(job.clone()), contest.threads)?,
        };
        let errors = System::read(file)?.judge(&solution)?;
        let _ = std::fs::remove_file(&solution);
        Ok((solved, errors))
    })
}

impl Side {
    fn new(name: &str, solved: Solved, errors: Errors) -> Side {
        let mut side = Side {
            name: name.to_owned(),
            ordering: solved.ordering.clone(),
            version: solved.version.clone(),
            analyze_s: Sample::default(),
            factor_s: Sample::default(),
            solve_s: Sample::default(),
            nnz_l: solved.nnz_l,
            flops: solved.flops,
            factor_bytes: solved.factor_bytes,
            base_bytes: solved.base_bytes,
            peak_bytes: solved.peak_bytes,
            errors,
        };
        side.add(solved, errors);
        side
    }

    fn add(&mut self, solved: Solved, errors: Errors) {
        self.analyze_s.0.extend(solved.analyze_s);
        self.factor_s.0.extend(solved.factor_s);
        // The first solve finds its work space.
        let warm = usize::from(solved.solve_s.len() > 1);
        self.solve_s.0.extend(&solved.solve_s[warm..]);
        if solved.peak_bytes > self.peak_bytes {
            (self.peak_bytes, self.base_bytes) = (solved.peak_bytes, solved.base_bytes);
        }
        self.errors.residual = worst([self.errors.residual, errors.residual]);
        self.errors.missing = worst([self.errors.missing, errors.missing]);
        self.errors.forward = worst([self.errors.forward, errors.forward]);
    }
}
