//! Times faer's sparse Cholesky factorization on a system that `dempfv compare peers` has
//! written: `faer-peer JOB.json RESULT.json`.

mod metis;
mod system;

use std::path::{Path, PathBuf};
use std::time::Instant;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::Perm;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use serde::{Deserialize, Serialize};

use system::System;

/// What is to be done.
#[derive(Deserialize)]
struct Job {
    system: PathBuf,
    /// Where the solution goes, as 64-bit numbers.
    solution: PathBuf,
    threads: usize,
    factors: usize,
    solves: usize,
}

/// What was measured (s, bytes); the same keys for every solver.
#[derive(Serialize)]
struct Answer {
    analyze_s: Vec<f64>,
    factor_s: Vec<f64>,
    solve_s: Vec<f64>,
    nnz_l: f64,
    factor_bytes: f64,
    base_bytes: f64,
    peak_bytes: f64,
    ordering: String,
    version: String,
}

fn main() -> Result<(), String> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [job, result] = arguments.as_slice() else {
        return Err("faer-peer JOB.json RESULT.json".to_owned());
    };
    let text = std::fs::read(job).map_err(|e| format!("{}: {e}", job.display()))?;
    let job: Job = serde_json::from_slice(&text).map_err(|e| e.to_string())?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .build_global()
        .map_err(|e| e.to_string())?;
    let answer = measure(&job)?;
    let text = serde_json::to_string(&answer).map_err(|e| e.to_string())?;
    std::fs::write(result, text).map_err(|e| format!("{}: {e}", result.display()))
}

fn measure(job: &Job) -> Result<Answer, String> {
    let system = System::read(&job.system)?;
    let n = system.n;
    reset_peak();
    let base_bytes = status("VmRSS:");
    let start = Instant::now();
    let permutation = order(&system)?;
    let symbolic = analyze(&system, permutation)?;
    let analyze_s = vec![start.elapsed().as_secs_f64()];
    let pattern =
        SymbolicSparseColMatRef::new_checked(n, n, &system.col_ptr, None, &system.row_idx);
    let matrix = SparseColMatRef::new(pattern, &system.values);
    // Faster on one thread at times: both ways are tried but with the largest.
    let together = Par::rayon(job.threads);
    let ways = if job.factors > 1 { vec![together, Par::Seq] } else { vec![together] };
    let mut x = vec![0.0; n];
    let (mut factor_s, mut solve_s) = (vec![], vec![]);
    let mut values = vec![0.0; symbolic.len_val()];
    for par in ways {
        let memory = symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default());
        let mut memory = MemBuffer::new(memory);
        let (mut factors, mut solves) = (vec![], vec![]);
        for _ in 0..job.factors {
            let start = Instant::now();
            let stack = MemStack::new(&mut memory);
            let rule = LltRegularization::default();
            let params = Default::default();
            let factor = symbolic
                .factorize_numeric_llt(&mut values, matrix, Side::Lower, rule, par, stack, params)
                .map_err(|e| format!("faer: {e:?}"))?;
            factors.push(start.elapsed().as_secs_f64());
            solves = solve(&symbolic, factor, &system.rhs, &mut x, job.solves, par);
        }
        keep_faster(&mut factor_s, factors);
        keep_faster(&mut solve_s, solves);
    }
    write(&job.solution, &x)?;
    Ok(Answer {
        analyze_s,
        factor_s,
        solve_s,
        nnz_l: symbolic.len_val() as f64,
        factor_bytes: 8.0 * symbolic.len_val() as f64,
        base_bytes,
        peak_bytes: status("VmHWM:"),
        ordering: "METIS".to_owned(),
        version: "0.24".to_owned(),
    })
}

/// Keeps the series of times whose best is the better one.
fn keep_faster(kept: &mut Vec<f64>, other: Vec<f64>) {
    let best = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
    if best(&other) < best(kept) {
        *kept = other;
    }
}

fn solve(
    symbolic: &SymbolicCholesky<usize>,
    factor: LltRef<'_, usize, f64>,
    rhs: &[f64],
    x: &mut [f64],
    solves: usize,
    par: Par,
) -> Vec<f64> {
    let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(1, par));
    let times = (0..solves).map(|_| {
        let start = Instant::now();
        x.copy_from_slice(rhs);
        let rows = x.len();
        let x = MatMut::from_column_major_slice_mut(&mut *x, rows, 1);
        factor.solve_in_place_with_conj(Conj::No, x, par, MemStack::new(&mut memory));
        start.elapsed().as_secs_f64()
    });
    times.collect()
}

/// METIS on the graph of the matrix.
fn order(system: &System) -> Result<Vec<usize>, String> {
    let n = system.n;
    let mut starts = vec![0; n + 1];
    let pairs = || {
        (0..n).flat_map(|j| {
            let rows = &system.row_idx[system.col_ptr[j]..system.col_ptr[j + 1]];
            rows.iter().filter(move |&&i| i != j).map(move |&i| (i, j))
        })
    };
    for (i, j) in pairs() {
        starts[i + 1] += 1;
        starts[j + 1] += 1;
    }
    for k in 0..n {
        starts[k + 1] += starts[k];
    }
    let mut next = starts.clone();
    let mut neighbours = vec![0; starts[n] as usize];
    for (i, j) in pairs() {
        for (a, b) in [(i, j), (j, i)] {
            neighbours[next[a] as usize] = i32::try_from(b).map_err(|e| e.to_string())?;
            next[a] += 1;
        }
    }
    metis::order(&mut starts, &mut neighbours)
}

fn analyze(system: &System, forward: Vec<usize>) -> Result<SymbolicCholesky<usize>, String> {
    let n = system.n;
    let mut inverse = vec![0; n];
    for (k, &v) in forward.iter().enumerate() {
        inverse[v] = k;
    }
    let permutation = Perm::new_checked(forward.into(), inverse.into(), n);
    let pattern =
        SymbolicSparseColMatRef::new_checked(n, n, &system.col_ptr, None, &system.row_idx);
    let params = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    factorize_symbolic_cholesky(
        pattern,
        Side::Lower,
        SymmetricOrdering::Custom(permutation.as_ref()),
        params,
    )
    .map_err(|e| format!("faer: {e:?}"))
}

fn write(path: &Path, x: &[f64]) -> Result<(), String> {
    let bytes: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// From here on the peak is that of what follows.
fn reset_peak() {
    // Where the system refuses, the peak includes the reading of the file.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// A size of this process, in bytes.
fn status(key: &str) -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix(key)).unwrap_or_default();
    1024.0 * line.trim().trim_end_matches("kB").trim().parse::<f64>().unwrap_or(f64::NAN)
}
