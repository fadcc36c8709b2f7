//! CHOLMOD's analysis and factorization by themselves: with the BLAS on all cores, which the
//! program itself never does (the bits of its results would depend on their number), and on
//! a GPU.

use std::time::Instant;

use dempfv::solver::{SolverKind, blas};
use serde::{Deserialize, Serialize};

use super::built::Input;
use super::specimens::Specimen;
use crate::Error;
use crate::bench::Bench;

/// What they take (s).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Factored {
    /// Ordering and symbolic analysis.
    pub analyze_s: f64,
    /// Numeric factorization.
    pub factor_s: f64,
}

/// Factors the matrix of a specimen, or returns what an earlier call measured.
///
/// # Errors
/// The packing has no network, the solver fails, or the result cannot be kept.
pub fn measure(bench: &Bench, specimen: &Specimen, threads: usize) -> Result<Factored, Error> {
    let packing = specimen.packing(bench)?;
    let name = name(specimen);
    bench.remembered(&name, &input(specimen, threads), || {
        bench.step(&name, || {
            let blas = threads;
            factor(&Input::of(specimen, &packing)?, SolverKind::Cholmod, blas, 1)
        })
    })
}

/// What an earlier call measured.
///
/// # Errors
/// None that a user could cause.
pub fn known(
    bench: &Bench,
    specimen: &Specimen,
    threads: usize,
) -> Result<Option<Factored>, Error> {
    bench.known(&name(specimen), &input(specimen, threads))
}

/// What a measurement depends on.
fn input(specimen: &Specimen, threads: usize) -> (&'static str, String, usize) {
    (SolverKind::Cholmod.name(), specimen.origin(), threads)
}

/// Name of a measurement.
pub fn name(specimen: &Specimen) -> String {
    format!("factor-{}-blas", specimen.spheres)
}

/// Factors a matrix several times in one process, and tells the fastest: the first on a GPU
/// is a cold start.
///
/// # Errors
/// There is no network, or the solver fails.
pub fn factor(
    input: &Input,
    solver: SolverKind,
    blas_threads: usize,
    times: usize,
) -> Result<Factored, Error> {
    let (network, derivatives) = input.network()?;
    let operators = input.operators(&network, derivatives)?;
    let fails = |e| Error::from(dempfv::Error::from(e));
    let start = Instant::now();
    let symbolic = solver.backend().analyze(&operators.matrix, None).map_err(fails)?;
    let analyze_s = start.elapsed().as_secs_f64();
    // No other thread factors or solves now: runs are made one after another.
    blas::set_threads(blas_threads);
    let start = Instant::now();
    let mut factor = symbolic.factor(&operators.matrix);
    let mut factor_s = start.elapsed().as_secs_f64();
    for _ in 1..times {
        let start = Instant::now();
        factor = factor.and_then(|factor| factor.refactor(&operators.matrix));
        factor_s = factor_s.min(start.elapsed().as_secs_f64());
    }
    // What comes after this in the same process keeps the promise of equal bits.
    blas::set_threads(1);
    factor.map(|_| Factored { analyze_s, factor_s }).map_err(fails)
}
