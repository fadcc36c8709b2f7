//! What a solver will take for a system that is not there yet: time and memory.
//!
//! Every backend has a [`CostModel`] of its own. Its constants were fitted to measurements on
//! networks of settled spheres with 118,199, 239,227, 817,690 and 2,192,699 unknowns, on two
//! cores of a Xeon with AVX-512 whose memory gives 10.7 GB/s to one core and 20.5 to two
//! (November 2026; the tables are in `benches/report.md` of the repository). At these sizes the
//! model is within 25 % of what was measured; on other machines within a factor of two or so.

use super::Analysis;

/// From this many unknowns on the frontal solver is the faster one: some 1,500
/// spheres. Below, where a factor lies in the processor's cache whatever its
/// precision, one solve by CHOLMOD takes less than two corrections.
pub const FRONTAL_FROM: usize = 8_000;

/// What a cost depends on.
///
/// ```
/// use dempfv::solver::{SolverKind, SystemSize};
/// let size = SystemSize::of_network(118_199, 2);
/// let cost = SolverKind::default().cost(&size);
/// // A remesh is measured in tenths of a second, a step in milliseconds.
/// assert!(cost.analysis + cost.factorization < 0.5);
/// assert!(cost.solve_to(1e-6) < 0.01);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemSize {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Entries of the factor L and operations of the factorization, where the pattern has been
    /// analyzed; else they are estimated as those of a network of pores.
    pub factor: Option<Fill>,
    /// True where the unknowns have coordinates to be ordered by.
    pub has_coordinates: bool,
    /// Number of threads.
    pub threads: usize,
}

/// How much an ordering fills in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Entries of the factor L.
    pub nnz_l: f64,
    /// Floating point operations of the factorization.
    pub flops: f64,
}

impl SystemSize {
    /// A network of pores of which nothing else is known.
    pub fn of_network(unknowns: usize, threads: usize) -> SystemSize {
        SystemSize { unknowns, factor: None, has_coordinates: true, threads }
    }

    /// The same, with what an analysis has found.
    pub fn with_analysis(self, analysis: &Analysis) -> SystemSize {
        let Analysis { nnz_l, flops, .. } = *analysis;
        SystemSize { factor: Some(Fill { nnz_l: nnz_l as f64, flops }), ..self }
    }

    /// Entries and operations: as they were found, or estimated.
    pub fn fill(&self) -> Fill {
        self.factor.unwrap_or_else(|| {
            let (nnz_l, flops) = match self.has_coordinates {
                true => (MINIMUM_CUTS_ENTRIES_OF_METIS, MINIMUM_CUTS_FLOPS_OF_METIS),
                false => (1.0, 1.0),
            };
            let metis = metis_fill(self.unknowns as f64);
            Fill { nnz_l: nnz_l * metis.nnz_l, flops: flops * metis.flops }
        })
    }
}

/// Entries and operations that METIS leaves for a network of pores: n (2.86 ∛n − 12.4) and
/// 0.85 n², within 2 and 8 % from 5,491 to 2,192,699 unknowns. Nested dissection of a graph in
/// space has factors of O(n^(4/3)) entries and O(n²) operations (George 1973).
fn metis_fill(n: f64) -> Fill {
    let per_unknown = (2.86 * n.cbrt() - 12.4).max(3.0);
    Fill { nnz_l: n * per_unknown, flops: 0.85 * n * n }
}

/// Entries and operations that [`ordering::order`](super::ordering::order) leaves over those of
/// METIS (1): 0.93 to 0.99 and 0.88 to 1.0 in networks of 5,491 to 2,192,699 unknowns.
const MINIMUM_CUTS_ENTRIES_OF_METIS: f64 = 0.95;
const MINIMUM_CUTS_FLOPS_OF_METIS: f64 = 0.90;

/// What a solver can be expected to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Entries of the factor and operations that this is for.
    pub fill: Fill,
    /// Time of ordering and symbolic analysis (s).
    pub analysis: f64,
    /// Time of the first factorization (s).
    pub factorization: f64,
    /// Time of a later one in the same memory (s).
    pub refactorization: f64,
    /// Time of one correction in a time loop (s): once through the factor in both directions
    /// ([`Factor::correct`](super::Factor::correct)), and the residual.
    pub correction: f64,
    /// Time of [`Factor::solve`](super::Factor::solve), to all digits (s).
    pub solve: f64,
    /// Memory that the factor holds (bytes).
    pub held_bytes: f64,
    /// Most memory that ordering and factorization take, the factor included (bytes).
    pub peak_bytes: f64,
    /// What a correction leaves of an error (1).
    pub correction_leaves: f64,
}

impl Cost {
    /// Corrections that bring a prediction of the pressures to a tolerance (1): one at least, and
    /// more than there are for a tolerance that is not positive.
    pub fn corrections_to(&self, tolerance: f64) -> u32 {
        let needed = (tolerance / PREDICTION_ERROR).ln() / self.correction_leaves.ln();
        // At least one: the prediction is not known to be good enough. Saturates.
        if needed.is_nan() { u32::MAX } else { needed.ceil().max(1.0) as u32 }
    }

    /// Time of a solve in a time loop that may leave a tolerance (s).
    pub fn solve_to(&self, tolerance: f64) -> f64 {
        f64::from(self.corrections_to(tolerance)) * self.correction
    }
}

/// Error of a predicted pressure relative to the largest (1): the median of the paper's
/// specimens in coupled motion.
const PREDICTION_ERROR: f64 = 2e-3;

/// A backend's constants. All times are those of two threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// Ordering by minimum cuts (s per n log₂ n).
    minimum_cuts: f64,
    /// METIS, with the symbolic analysis that CHOLMOD makes along with it (s per n log₂ n).
    metis: f64,
    /// Symbolic analysis (s per unknown).
    symbolic: f64,
    /// Factorization (s per operation, s per entry of L).
    factor_flop: f64,
    factor_entry: f64,
    /// Time of a later factorization over that of the first (1).
    refactorization: f64,
    /// Correction (s per entry of L, s per unknown).
    correction_entry: f64,
    correction_unknown: f64,
    /// Solve to all digits (s per entry of L, s per unknown).
    solve_entry: f64,
    solve_unknown: f64,
    /// Memory that the factor holds (bytes per entry of L, bytes per unknown).
    held_entry: f64,
    held_unknown: f64,
    /// What ordering and factorization take beyond it (bytes per unknown).
    work_unknown: f64,
    /// What a correction leaves of an error (1).
    correction_leaves: f64,
    /// Time of solves with a factor of less than [`CACHE_BYTES`] over what the constants say (1).
    solve_in_cache: f64,
    /// True where factorization and corrections use all threads.
    is_parallel: bool,
}

/// A factor of less than so many bytes stays in the processor's caches from solve to solve.
const CACHE_BYTES: f64 = 8e6;

/// Threads of the measurements.
const MEASURED_THREADS: f64 = 2.0;

/// Part of the work that one thread does alone (1). A correction takes 6.2 ms with one thread
/// and 3.1 with two at 118,199 unknowns; more were not measured.
const SERIAL_PART: f64 = 0.05;

/// CHOLMOD with the BLAS on one thread. Its symbolic analysis was measured together with METIS
/// only; by itself it is taken to be as fast as that of the frontal solver.
pub(super) const CHOLMOD: CostModel = CostModel {
    minimum_cuts: 2.6e-8,
    metis: 3.35e-7,
    symbolic: 3.2e-7,
    factor_flop: 1.0 / 7e10,
    factor_entry: 1.2e-8,
    refactorization: 1.0,
    correction_entry: 8e-10,
    correction_unknown: 1.62e-7,
    solve_entry: 8e-10,
    solve_unknown: 1.07e-7,
    // Supernodes hold a quarter more entries than L has, and 28 an unknown.
    held_entry: 10.0,
    held_unknown: 224.0,
    work_unknown: 370.0,
    correction_leaves: 1e-12,
    // 5,487 unknowns, 2026-11-30, a Xeon: 0.35 ms, where the constants of large systems say 1.07.
    solve_in_cache: 0.35,
    is_parallel: false,
};

/// The frontal solver.
pub(super) const FRONTAL: CostModel = CostModel {
    minimum_cuts: 2.6e-8,
    metis: 3.35e-7,
    symbolic: 3.2e-7,
    // With OpenBLAS's kernels for AVX-512. The solver's own, since 2026-11-30, were seen to take 0.8
    // of the time at 118,199 unknowns.
    factor_flop: 1.0 / 1.53e11,
    factor_entry: 5.2e-9,
    // Memory that was written to before.
    refactorization: 0.9,
    correction_entry: 2.0e-10,
    correction_unknown: 5e-9,
    solve_entry: 1.05e-9,
    solve_unknown: 0.0,
    held_entry: 2.3,
    held_unknown: 208.0,
    work_unknown: 420.0,
    correction_leaves: 4e-6,
    solve_in_cache: 1.0,
    is_parallel: true,
};

/// The model of [`Auto`](super::Auto) for so many unknowns.
pub(super) fn auto(unknowns: usize) -> CostModel {
    if unknowns < FRONTAL_FROM { CHOLMOD } else { FRONTAL }
}

impl CostModel {
    /// What a system of this size takes.
    pub fn cost(&self, size: &SystemSize) -> Cost {
        let n = size.unknowns as f64;
        let fill @ Fill { nnz_l, flops } = size.fill();
        let log = n.max(2.0).log2();
        let shared = threads_factor(size.threads);
        let solver = if self.is_parallel { shared } else { 1.0 };
        let analysis = match (size.has_coordinates, self.is_parallel) {
            (true, _) => shared * self.minimum_cuts * n * log + self.symbolic * n,
            // METIS comes with CHOLMOD's analysis, which the other solver does not read.
            (false, false) => self.metis * n * log,
            (false, true) => self.metis * n * log + self.symbolic * n,
        };
        let factorization = solver * (self.factor_flop * flops + self.factor_entry * nnz_l);
        let held_bytes = self.held_entry * nnz_l + self.held_unknown * n;
        let solver = if held_bytes < CACHE_BYTES { self.solve_in_cache * solver } else { solver };
        Cost {
            fill,
            analysis,
            factorization,
            refactorization: self.refactorization * factorization,
            correction: solver * (self.correction_entry * nnz_l + self.correction_unknown * n),
            solve: solver * (self.solve_entry * nnz_l + self.solve_unknown * n),
            held_bytes,
            peak_bytes: held_bytes + self.work_unknown * n,
            correction_leaves: self.correction_leaves,
        }
    }
}

/// Time with so many threads over that with those of the measurements (Amdahl 1967).
fn threads_factor(threads: usize) -> f64 {
    let time = |threads: f64| SERIAL_PART + (1.0 - SERIAL_PART) / threads;
    time(threads.max(1) as f64) / time(MEASURED_THREADS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(what: &str, value: f64, measured: f64, tolerance: f64) {
        let ratio = value / measured;
        let is_near = (1.0 - tolerance..1.0 + tolerance).contains(&ratio);
        assert!(is_near, "{what}: {value:e} against {measured:e}");
    }

    /// Unknowns, nnz(L), operations; analysis, factorization, solve (s); memory held and at
    /// most (MB).
    type Row = (usize, f64, f64, f64, f64, f64, f64, f64);

    fn check(model: CostModel, has_coordinates: bool, rows: &[Row]) {
        for &(unknowns, nnz_l, flops, analysis, factorization, solve, held, peak) in rows {
            let factor = Some(Fill { nnz_l, flops });
            let size = SystemSize { unknowns, factor, has_coordinates, threads: 2 };
            let cost = model.cost(&size);
            near("analysis", cost.analysis, analysis, 0.15);
            near("factorization", cost.factorization, factorization, 0.15);
            near("solve", cost.solve, solve, 0.25);
            near("held", cost.held_bytes, held * 1e6, 0.1);
            near("peak", cost.peak_bytes, peak * 1e6, 0.1);
            let guessed = model.cost(&SystemSize { factor: None, ..size }).fill;
            near("nnz(L)", guessed.nnz_l, nnz_l, 0.05);
            near("operations", guessed.flops, flops, 0.1);
        }
    }

    /// What the contest's report says of CHOLMOD with METIS.
    #[test]
    fn cholmod_takes_what_was_measured() {
        check(
            CHOLMOD,
            false,
            &[
                (118_199, 1.489e7, 1.22e10, 0.63, 0.39, 0.0243, 178.0, 221.0),
                (239_227, 3.882e7, 4.95e10, 1.41, 1.18, 0.0587, 447.0, 537.0),
                (817_690, 2.123e8, 6.02e11, 5.53, 10.8, 0.264, 2310.0, 2635.0),
                (2_192_699, 7.863e8, 3.86e12, 15.7, 58.7, 0.857, 8230.0, 8944.0),
            ],
        );
    }

    /// And of the frontal solver with coordinates.
    #[test]
    fn frontal_takes_what_was_measured() {
        check(
            FRONTAL,
            true,
            &[
                (118_199, 1.415e7, 1.10e10, 0.0821, 0.145, 0.0121, 59.2, 104.0),
                (239_227, 3.702e7, 4.50e10, 0.177, 0.495, 0.0434, 137.0, 225.0),
                (817_690, 1.997e8, 5.31e11, 0.693, 4.57, 0.240, 616.0, 1044.0),
                (2_192_699, 7.339e8, 3.43e12, 2.07, 24.3, 0.718, 2050.0, 3015.0),
            ],
        );
    }

    /// One correction for a tolerance of 1e-6, two for 1e-11, one of CHOLMOD's for either; and
    /// the times of the time loop.
    #[test]
    fn corrections_are_those_of_the_time_loop() {
        let size = |n| SystemSize::of_network(n, 2);
        for (n, rough, tolerance, fine) in [
            (118_199, 3.36e-3, 5e-14, 6.67e-3),
            (239_227, 9.19e-3, 1e-12, 15.7e-3),
            (817_690, 40.4e-3, 1e-12, 77.6e-3),
        ] {
            let cost = FRONTAL.cost(&size(n));
            assert_eq!((cost.corrections_to(1e-6), cost.corrections_to(tolerance)), (1, 2));
            near("rough", cost.solve_to(1e-6), rough, 0.15);
            near("fine", cost.solve_to(tolerance), fine, 0.2);
        }
        for (n, time) in [(118_199, 29.2e-3), (239_227, 71.6e-3), (817_690, 325e-3)] {
            let cost = CHOLMOD.cost(&size(n));
            assert_eq!((cost.corrections_to(1e-6), cost.corrections_to(1e-11)), (1, 1));
            near("CHOLMOD", cost.solve_to(1e-11), time, 0.15);
        }
    }

    /// More threads take less, but for what one does alone; CHOLMOD takes the same.
    #[test]
    fn threads_share_the_work() {
        let with = |threads, model: CostModel| {
            model.cost(&SystemSize::of_network(200_000, threads)).factorization
        };
        near("one", with(1, FRONTAL), 2.0 * with(2, FRONTAL), 0.06);
        assert!(with(16, FRONTAL) < 0.3 * with(2, FRONTAL));
        assert!(with(1000, FRONTAL) > 0.08 * with(2, FRONTAL));
        assert_eq!(with(1, CHOLMOD), with(8, CHOLMOD));
        let none = CHOLMOD.cost(&SystemSize::of_network(0, 0));
        assert!(none.analysis == 0.0 && none.solve == 0.0 && none.peak_bytes == 0.0);
    }
}
