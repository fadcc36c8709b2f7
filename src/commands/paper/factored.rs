//! Analysis and factorization with the BLAS on all cores, which the program itself never
//! does: the bits of its results would depend on their number.

use std::time::Instant;

use dempfv::solver::{SolverKind, blas};
use serde::{Deserialize, Serialize};

use super::built::Input;
use super::specimens::Specimen;
use crate::commands::Error;
use crate::commands::bench::Bench;

/// What they take with the BLAS on several cores (s).
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
    bench.remembered(&name, &(specimen.origin(), threads), || {
        bench.step(&name, || factor(&Input::of(specimen, &packing)?, threads))
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
    bench.known(&name(specimen), &(specimen.origin(), threads))
}

/// Name of a measurement.
pub fn name(specimen: &Specimen) -> String {
    format!("factor-{}-blas", specimen.spheres)
}

fn factor(input: &Input, threads: usize) -> Result<Factored, Error> {
    let (network, derivatives) = input.network()?;
    let operators = input.operators(&network, derivatives)?;
    let fails = |e| Error::from(dempfv::Error::from(e));
    let start = Instant::now();
    let symbolic =
        SolverKind::default().backend().analyze(&operators.matrix, None).map_err(fails)?;
    let analyze_s = start.elapsed().as_secs_f64();
    // No other thread factors or solves now: runs are made one after another.
    blas::set_threads(threads);
    let start = Instant::now();
    let factor = symbolic.factor(&operators.matrix).map_err(fails);
    let factor_s = start.elapsed().as_secs_f64();
    // What comes after this in the same process keeps the promise of equal bits.
    blas::set_threads(1);
    factor.map(|_| Factored { analyze_s, factor_s })
}
