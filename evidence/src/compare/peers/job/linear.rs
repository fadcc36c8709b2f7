//! One system through one of our solvers.

use std::path::PathBuf;
use std::time::Instant;

use dempfv::InputError;
use dempfv::solver::{SolverKind, blas};
use dempfv_report::machine;
use serde::{Deserialize, Serialize};

use super::{System, solver_failed};
use crate::Error;
use crate::bench::sample::Sample;

/// What is to be solved, how, and how often. The scripts for other solvers read the same
/// keys.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Linear {
    pub system: PathBuf,
    /// Where the solution goes, as 64-bit numbers.
    pub solution: PathBuf,
    pub solver: String,
    /// Threads of the BLAS, where they are not to be what the solver chooses.
    pub blas_threads: Option<usize>,
    /// Whether the solver is told where the pores are.
    pub with_points: bool,
    pub threads: usize,
    pub factors: usize,
    pub solves: usize,
    /// Number of the run.
    pub run: usize,
}

/// What was measured: times in s, memory in bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solved {
    /// Ordering and symbolic analysis.
    pub analyze_s: Vec<f64>,
    pub factor_s: Vec<f64>,
    pub solve_s: Vec<f64>,
    /// Entries of the factor, as the solver counts.
    pub nnz_l: f64,
    /// Operations of the factorization, where the solver tells.
    #[serde(default)]
    pub flops: Option<f64>,
    /// Memory of the factor, as the solver counts.
    pub factor_bytes: f64,
    /// Memory of the process with the system read, before the ordering.
    pub base_bytes: f64,
    /// The most that it held after that.
    pub peak_bytes: f64,
    pub ordering: String,
    pub version: String,
}

impl Linear {
    /// Solves it.
    ///
    /// # Errors
    /// There is no such solver or no such file; the solver fails.
    pub fn measure(&self) -> Result<Solved, Error> {
        let kind: SolverKind = self.solver.parse().map_err(|e| {
            dempfv::Error::from(InputError::new(format!("{e}"), "name a solver of ours"))
        })?;
        let failed = |e| solver_failed(kind.name(), &e);
        if let Some(threads) = self.blas_threads {
            blas::set_threads(threads);
        }
        let System { matrix, rhs, points, .. } = System::read(&self.system)?;
        machine::forget_peak();
        let memory = |key| machine::own_memory(key).map_or(f64::NAN, |size| size as f64);
        let base_bytes = memory(machine::HELD);
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let points = self.with_points.then_some(&points[..]);
        let symbolic = kind.backend().analyze(&matrix, points).map_err(failed)?;
        let analyze_s = vec![lap()];
        let mut factor = symbolic.factor(&matrix).map_err(failed)?;
        let mut factor_s = vec![lap()];
        for _ in 1..self.factors {
            factor = factor.refactor(&matrix).map_err(failed)?;
            factor_s.push(lap());
        }
        let mut x = vec![0.0; matrix.n];
        let mut solve = || -> Result<Vec<f64>, Error> {
            let mut times = vec![];
            for _ in 0..self.solves {
                lap();
                factor.solve(&rhs, &mut x).map_err(failed)?;
                times.push(lap());
            }
            Ok(times)
        };
        let mut solve_s = solve()?;
        // With one right-hand side the BLAS may be faster on one thread.
        if self.blas_threads.is_some_and(|threads| threads > 1) {
            blas::set_threads(1);
            let alone = Sample(solve()?);
            if alone.median() < Sample(solve_s.clone()).median() {
                solve_s = alone.0;
            }
        }
        let analysis = factor.analysis();
        let peak_bytes = memory(machine::PEAK);
        let bytes: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
        dempfv::io::atomic::write(&self.solution, &bytes)?;
        Ok(Solved {
            analyze_s,
            factor_s,
            solve_s,
            nnz_l: analysis.nnz_l as f64,
            flops: Some(analysis.flops),
            factor_bytes: factor.memory_bytes() as f64,
            base_bytes,
            peak_bytes,
            ordering: analysis.ordering.to_owned(),
            version: dempfv_report::versions::all().remove("cholmod").unwrap_or_default(),
        })
    }
}
