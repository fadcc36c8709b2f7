//! `dempfv solve`: one linear system through the solvers.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use dempfv::io::matrix_market;
use dempfv::solver::{
    Analysis, Placement, SolverError, SolverKind, SymmetricCsc, UnknownSolver, blas,
};
use dempfv::{Error, InputError};
use dempfv_report::format::{bytes, count, duration};
use serde::Serialize;

use super::accuracy::Accuracy;
use super::kernels;

/// Solves are repeated for about this long (s), and the fastest is told.
const MEASURE_FOR: f64 = 0.2;

/// What `solve` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Symmetric positive definite matrix (Matrix Market)
    pub matrix: PathBuf,

    /// Right-hand side (Matrix Market, one column); the row sums of the matrix if not
    /// given, so that the solution is known to be all ones
    pub right_hand_side: Option<PathBuf>,

    /// Solver to use; each one in turn if not given
    #[arg(long, value_name = "NAME", value_parser = parse_solver)]
    pub solver: Option<SolverKind>,

    /// Also write the solution (Matrix Market), that of the last solver
    #[arg(long, value_name = "FILE")]
    pub solution: Option<PathBuf>,

    /// Replace a solution that is already there
    #[arg(long, requires = "solution")]
    pub force: bool,

    /// Number of the GPU, with `--solver cholmod-gpu`
    #[arg(long, value_name = "N", requires = "solver")]
    pub gpu_device: Option<u32>,

    /// The most memory to take on the GPU (bytes), with `--solver cholmod-gpu`; 40 % of what is
    /// free if not given
    #[arg(long, value_name = "BYTES", requires = "solver")]
    pub gpu_memory: Option<u64>,
}

fn parse_solver(name: &str) -> Result<SolverKind, UnknownSolver> {
    name.parse()
}

/// How each solver did.
#[derive(Debug, Serialize)]
pub struct Report {
    matrix: PathBuf,
    right_hand_side: Option<PathBuf>,
    unknowns: usize,
    /// Entries of the lower triangle with the diagonal.
    entries: usize,
    /// What CHOLMOD computes with.
    blas: String,
    blas_threads: Option<usize>,
    warnings: Vec<String>,
    solvers: Vec<SolverReport>,
    /// Solvers that are not for this matrix.
    refused: Vec<Refusal>,
}

/// A solver that is not for the matrix.
#[derive(Debug, Serialize)]
struct Refusal {
    solver: &'static str,
    reason: String,
}

/// How one solver did. Times in seconds.
#[derive(Debug, Serialize)]
struct SolverReport {
    solver: &'static str,
    /// The solver that has the factor: `auto` leaves it to another.
    solved_by: &'static str,
    #[serde(flatten)]
    analysis: Analysis,
    /// Ordering and symbolic analysis.
    analyze_s: f64,
    factor_s: f64,
    /// The fastest of several solves.
    solve_s: f64,
    /// Relative residual in the maximum norm.
    residual: f64,
    /// Largest error of an unknown where the solution is known.
    forward_error: Option<f64>,
    #[serde(flatten)]
    accuracy: Accuracy,
    memory_bytes: usize,
    /// Where the factorization was computed.
    placement: Placement,
}

/// Reads the system and solves it.
///
/// # Errors
/// [`Error::Input`] for what is wrong in the files, [`Error::System`] when a solver fails.
pub fn run(args: &Args) -> Result<Report, Error> {
    if let Some(file) = args.solution.as_ref().filter(|file| !args.force && file.exists()) {
        let what = format!("--solution {} is there already", file.display());
        return Err(InputError::new(what, "give --force to replace it, or another name").into());
    }
    let a = matrix_market::read_matrix(&args.matrix)?;
    let b = match &args.right_hand_side {
        Some(path) => matrix_market::read_vector(path, a.n)?,
        None => row_sums(&a)?,
    };
    let known = args.right_hand_side.is_none().then_some(1.0);
    let chosen = args.solver.as_slice();
    let built: Vec<SolverKind> =
        SolverKind::ALL.iter().copied().filter(|kind| kind.is_built()).collect();
    let mut kinds = if chosen.is_empty() { built } else { chosen.to_vec() };
    if args.gpu_device.is_some() || args.gpu_memory.is_some() {
        let [SolverKind::CholmodGpu(options)] = kinds.as_mut_slice() else {
            let what = "--gpu-device and --gpu-memory are for a solver that uses a GPU";
            return Err(InputError::new(what, "give --solver cholmod-gpu").into());
        };
        options.device = args.gpu_device.unwrap_or(0);
        options.memory = args.gpu_memory;
    }
    let mut warnings = Vec::from_iter(kinds.iter().find_map(|&kind| kernels::warning(kind)));
    let (mut solvers, mut refused) = (vec![], vec![]);
    let mut x = vec![0.0; a.n];
    for kind in kinds {
        match measure(kind, &a, &b, &mut x, known) {
            Ok(report) => {
                warnings.extend(report.accuracy.warning(report.solver));
                solvers.push(report);
            }
            // Nobody asked for a solver of networks' matrices only.
            Err(
                reason
                @ (SolverError::PositiveOffDiagonal { .. } | SolverError::NotDominant { .. }),
            ) if args.solver.is_none() => {
                refused.push(Refusal { solver: kind.name(), reason: reason.to_string() });
            }
            Err(e) => return Err(failed(e, kind, &args.matrix)),
        }
    }
    if let Some(file) = args.solution.as_ref().filter(|_| !solvers.is_empty()) {
        matrix_market::write_vector(file, &x)?;
    }
    Ok(Report {
        matrix: args.matrix.clone(),
        right_hand_side: args.right_hand_side.clone(),
        unknowns: a.n,
        entries: a.nnz(),
        blas: blas::description(),
        blas_threads: blas::threads(),
        warnings,
        solvers,
        refused,
    })
}

/// The right-hand side whose solution is all ones.
fn row_sums(a: &SymmetricCsc) -> Result<Vec<f64>, dempfv::Error> {
    let mut b = vec![0.0; a.n];
    a.multiply(&vec![1.0; a.n], &mut b)?;
    Ok(b)
}

fn measure(
    kind: SolverKind,
    a: &SymmetricCsc,
    b: &[f64],
    x: &mut [f64],
    known: Option<f64>,
) -> Result<SolverReport, SolverError> {
    let start = Instant::now();
    let symbolic = kind.backend().analyze(a, None)?;
    let analyze_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut factor = symbolic.factor(a)?;
    let factor_s = start.elapsed().as_secs_f64();

    let residual = factor.solve_checked(a, b, x)?;
    let (mut solve_s, begin) = (f64::INFINITY, Instant::now());
    while solve_s == f64::INFINITY || begin.elapsed().as_secs_f64() < MEASURE_FOR {
        let start = Instant::now();
        factor.solve(b, x)?;
        solve_s = solve_s.min(start.elapsed().as_secs_f64());
    }
    let accuracy = Accuracy::of(&mut *factor, a, b, x)?;
    Ok(SolverReport {
        solver: kind.name(),
        solved_by: factor.solver(),
        analysis: factor.analysis(),
        analyze_s,
        factor_s,
        solve_s,
        residual,
        forward_error: known.map(|known| x.iter().map(|x| (x - known).abs()).fold(0.0, f64::max)),
        accuracy,
        memory_bytes: factor.memory_bytes(),
        placement: factor.placement().clone(),
    })
}

/// A solver's error with the file; an entry that is out of range was the user's.
fn failed(error: SolverError, kind: SolverKind, matrix: &Path) -> Error {
    match error {
        SolverError::RightHandSideNotFinite { row, value } => {
            // The files hold finite numbers, so their row sums overflowed.
            let what = format!("row {} of the matrix sums up to {value}", row + 1);
            InputError::new(what, "give a right-hand side").in_file(matrix).into()
        }
        source => Error::System { path: matrix.to_owned(), solver: kind.name(), source },
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unknowns, entries) = (count(self.unknowns as u64), count(self.entries as u64));
        writeln!(
            f,
            "{}: {unknowns} unknowns, {entries} entries on and below the diagonal",
            self.matrix.display()
        )?;
        match &self.right_hand_side {
            Some(path) => writeln!(f, "right-hand side: {}", path.display())?,
            None => {
                writeln!(f, "right-hand side: row sums of the matrix (the solution is all ones)")?
            }
        }
        let threads =
            self.blas_threads.map(|n| format!(", {n} thread{}", if n == 1 { "" } else { "s" }));
        if self.solvers.iter().any(|run| run.solved_by != SolverKind::Frontal.name()) {
            writeln!(f, "BLAS of CHOLMOD: {}{}", self.blas, threads.unwrap_or_default())?;
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        writeln!(f)?;
        writeln!(
            f,
            "{:<11} {:<9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
            "solver",
            "ordering",
            "analyze",
            "factor",
            "solve",
            "nnz(L)",
            "flops",
            "residual",
            "error",
            "condition",
            "memory"
        )?;
        self.solvers.iter().try_for_each(|run| {
            writeln!(
                f,
                "{:<11} {:<9} {:>9} {:>9} {:>9} {:>9.3e} {:>9.3e} {:>9.1e} {:>9} {:>9.1e} {:>9}",
                run.solver,
                run.analysis.ordering,
                duration(run.analyze_s),
                duration(run.factor_s),
                duration(run.solve_s),
                run.analysis.nnz_l as f64,
                run.analysis.flops,
                run.residual,
                run.forward_error.map_or("-".to_owned(), |e| format!("{e:.1e}")),
                run.accuracy.condition,
                bytes(run.memory_bytes as f64),
            )
        })?;
        self.refused.iter().try_for_each(|r| writeln!(f, "\n{}: {}", r.solver, r.reason))?;
        let mut left = self.solvers.iter().filter(|run| run.solver == SolverKind::Auto.name());
        left.try_for_each(|run| writeln!(f, "\n{}: by {}", run.solver, run.solved_by))?;
        self.solvers.iter().try_for_each(|run| match &run.placement {
            Placement::Cpu => Ok(()),
            Placement::Fallback { reason } => {
                writeln!(f, "\n{}: on the CPU, because {reason}", run.solver)
            }
            Placement::Gpu(work) => writeln!(
                f,
                "\n{}: {:.0} % of the operations on {} ({} SYRK, {} GEMM, {} POTRF, {} TRSM)",
                run.solver,
                100.0 * work.share.min(1.0),
                work.name,
                work.syrk_calls,
                work.gemm_calls,
                work.potrf_calls,
                work.trsm_calls
            ),
        })
    }
}
