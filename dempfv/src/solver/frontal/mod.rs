//! A multifrontal factorization for the matrices of flow networks, in single
//! precision and yet right to nearly all its digits; kept in half of that.
//!
//! The matrix of a network has no positive entry off its diagonal, and no row
//! whose sum is negative: what a pore loses is what its neighbours gain, and
//! what leaves through imposed pressures. Elimination keeps it so. A pivot can
//! therefore be had as a sum of sizes (the entries left in its column, and the
//! row excess, which is carried along) in place of a difference, and nothing
//! in the whole factorization cancels (Grassmann, Taksar and Heyman 1985; Alfa,
//! Xue and Ye 2002). Each entry of L has a relative error of about 10⁻⁶, however
//! many decades the conductances span, where plain Cholesky factorization in
//! single precision loses one digit for each decade of the condition number.
//!
//! What solves read of it is rounded to 16 bits an entry, or 8, so that no fluid is lost (see
//! [`packed`]), and large factors have blocks of [`low_rank`]. A solve with this
//! factor is a correction that gains five digits where the pressures are smooth. The residual
//! is evaluated in double precision from differences of pressures, and corrections are
//! repeated until they no longer help.
//!
//! Memory and traffic are a quarter of those of a factor in double precision. The
//! tree of fronts is worked through on all threads; results are the same bits
//! for any number.

mod block;
mod dense;
mod extend_add;
mod kernels;
mod low_rank;
mod m_matrix;
mod microkernel;
mod numeric;
mod packed;
mod pivot;
mod product;
mod register_tile;
mod schedule;
mod shape;
mod solve;
mod solve_right;
mod substitution;
mod supernodes;
mod symbolic;
mod tail;

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::{
    Analysis, Backend, Cost, Factor, Placement, Refinement, SolverError, Symbolic, SymmetricCsc,
    SystemSize, cholmod, cost, ordering, refine, require_size,
};
use crate::calls;
use crate::parallel::{advise_huge_pages, max_norm};
use m_matrix::MMatrix;
use numeric::{Factorization, PackedFactor, Stopped};
use packed::FactorLayout;
use schedule::Schedule;
use solve::Solve;
use symbolic::Pattern;

/// In messages.
const NAME: &str = "frontal";

/// A pivot below this part of the diagonal entry is round-off of the matrix
/// itself.
const PIVOT_LIMIT: f64 = 1e-14;

/// Entries of a vector that one thread takes at a time.
const CHUNK_ENTRIES: usize = 8192;

/// Most corrections of a solve, and what they may leave at the end, relative to
/// the solution.
const MAX_CORRECTIONS: usize = 8;
const REFINEMENT_TOLERANCE: f64 = 1e-17;

/// Largest residual of one correction. A sound factor was seen to leave 10⁻⁸ to 2·10⁻⁷.
const CORRECTION_LIMIT: f64 = 1e-5;

/// The multifrontal backend, for diagonally dominant matrices without positive
/// entries off the diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frontal;

impl Backend for Frontal {
    fn name(&self) -> &'static str {
        NAME
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        Ok(Box::new(FrontalSymbolic::new(a, coordinates)?))
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Some(cost::FRONTAL.cost(size))
    }
}

/// The symbolic factorization, and the schedule that follows from it.
pub(super) struct FrontalSymbolic {
    pattern: Pattern,
    schedule: Schedule,
    layout: FactorLayout,
    analysis: Analysis,
    hash: u64,
}

impl FrontalSymbolic {
    /// See [`Backend::analyze`].
    pub(super) fn new(
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<FrontalSymbolic, SolverError> {
        a.validate()?;
        let too_large = SolverError::TooLarge { solver: NAME, n: a.n };
        if !a.counts_in_32_bits() {
            return Err(too_large);
        }
        if let Some(points) = coordinates {
            require_size("the list of coordinates", a.n, points.len())?;
        }
        calls::count(&calls::ANALYSES);
        let (ordering, order) = match coordinates {
            Some(points) => {
                let order = ordering::minimum_cuts(a, points);
                ("minimum cuts", order.into_iter().map(|k| k as u32).collect())
            }
            None => ("metis", cholmod::metis_order(a)?),
        };
        let Some(pattern) = Pattern::new(a, order) else { return Err(too_large) };
        let schedule = Schedule::new(&pattern);
        // Places of unknowns have 32 bits.
        if u32::try_from(schedule.vectors).is_err() {
            return Err(too_large);
        }
        let layout = FactorLayout::new(&pattern);
        let analysis = Analysis { ordering, nnz_l: pattern.nnz_l, flops: pattern.flops };
        let hash = a.pattern_hash();
        Ok(FrontalSymbolic { pattern, schedule, layout, analysis, hash })
    }

    /// A factor of no matrix yet.
    pub(super) fn into_factor(self) -> FrontalFactor {
        let n = self.pattern.n;
        FrontalFactor {
            vectors: vec![0.0; self.schedule.vectors],
            residual: vec![0.0; n],
            correction: vec![0.0; n],
            m_matrix: MMatrix::default(),
            packed: PackedFactor::default(),
            symbolic: self,
        }
    }

    /// Memory for the packed factor: zeros as the system hands them out, whose pages come where
    /// they are written first, on all threads.
    fn allocate(&self) -> Result<PackedFactor, SolverError> {
        let n = self.pattern.n;
        let out_of_memory = |_| SolverError::OutOfMemory { solver: NAME, phase: "factor", n };
        let words = self.layout.end().words + packed::OVERREAD_WORDS;
        let triangles = self.layout.end().triangles + packed::OVERREAD_WORDS;
        let packed = PackedFactor {
            words: bytemuck::allocation::try_zeroed_vec(words).map_err(out_of_memory)?,
            triangles: bytemuck::allocation::try_zeroed_vec(triangles).map_err(out_of_memory)?,
            factors: vec![0.0; n],
            inverse: vec![0.0; n],
        };
        advise_huge_pages(&packed.words);
        advise_huge_pages(&packed.triangles);
        Ok(packed)
    }
}

impl Symbolic for FrontalSymbolic {
    fn analysis(&self) -> Analysis {
        self.analysis
    }

    fn factor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        let mut factor = self.into_factor();
        factor.factorize(a)?;
        Ok(Box::new(factor))
    }
}

/// A factor, or memory for one.
pub(super) struct FrontalFactor {
    symbolic: FrontalSymbolic,
    m_matrix: MMatrix,
    packed: PackedFactor,
    /// The vectors of the tasks.
    vectors: Vec<f32>,
    residual: Vec<f64>,
    correction: Vec<f64>,
}

impl FrontalFactor {
    /// Factors a matrix, in the memory of this factor if it has any.
    ///
    /// # Errors
    /// As [`Symbolic::factor`]; and the matrix is no diagonally dominant M-matrix, which is
    /// found before anything is computed.
    pub(super) fn factorize(&mut self, a: &SymmetricCsc) -> Result<(), SolverError> {
        let FrontalSymbolic { pattern, schedule, layout, hash, .. } = &self.symbolic;
        if a.n != pattern.n || a.pattern_hash() != *hash {
            return Err(SolverError::PatternChanged);
        }
        self.m_matrix.update(a)?;
        calls::count(&calls::FACTORIZATIONS);
        if self.packed.words.is_empty() {
            self.packed = self.symbolic.allocate()?;
        }
        let (values, row_excess) = self.m_matrix.scaled(a, &pattern.order);
        let work =
            Factorization { pattern, schedule, layout, values: &values, row_excess: &row_excess };
        let unknown = |column: usize| pattern.order[column] as usize;
        work.run(&mut self.packed).map_err(|Stopped(column)| {
            // Every term of a pivot is positive or zero.
            SolverError::NearlySingular { column: unknown(column), ratio: 0.0 }
        })?;
        self.check_pivots(a)
    }

    /// Refuses a factor one of whose pivots is round-off of the matrix.
    fn check_pivots(&self, a: &SymmetricCsc) -> Result<(), SolverError> {
        let order = &self.symbolic.pattern.order;
        let mut worst = (0, f64::INFINITY);
        for (&inverse, &unknown) in self.packed.inverse.iter().zip(order) {
            let unknown = unknown as usize;
            let pivot = 1.0 / (f64::from(inverse) * f64::from(inverse)) / self.m_matrix.scale;
            let ratio = pivot / a.values[a.col_ptr[unknown] as usize];
            if ratio < worst.1 {
                worst = (unknown, ratio);
            }
        }
        let (column, ratio) = worst;
        if ratio < PIVOT_LIMIT {
            Err(SolverError::NearlySingular { column, ratio })
        } else {
            Ok(())
        }
    }

    /// x = A⁻¹ b to single precision, for a right-hand side of this size.
    fn solve_once(&mut self, b: &[f64], size: f64, x: &mut [f64]) {
        let FrontalSymbolic { pattern, schedule, layout, .. } = &self.symbolic;
        if size == 0.0 {
            x.fill(0.0);
            return;
        }
        // Of the smallest sizes there is no inverse.
        let to_one = size.recip().min(f64::MAX);
        let entries = &self.packed;
        let solve =
            Solve { pattern, schedule, layout, entries, right_hand_side: b, factor: to_one };
        solve.run(&mut self.vectors);
        let scale = self.m_matrix.scale / to_one;
        let vectors = &*self.vectors;
        let part = |(x, places): (&mut [f64], &[u32])| {
            for (x, &place) in x.iter_mut().zip(places) {
                *x = f64::from(vectors[place as usize]) * scale;
            }
        };
        if schedule.is_parallel {
            x.par_chunks_mut(CHUNK_ENTRIES)
                .zip(schedule.place.par_chunks(CHUNK_ENTRIES))
                .for_each(part);
        } else {
            part((x, &schedule.place));
        }
    }

    /// Gives the memory of the packed factor back; the next factorization asks for it again.
    pub(super) fn release(&mut self) {
        self.packed = PackedFactor::default();
    }

    /// The order of elimination.
    pub(super) fn order(&self) -> &[u32] {
        &self.symbolic.pattern.order
    }

    /// Size of a right-hand side.
    fn size_of(&self, b: &[f64]) -> Result<f64, SolverError> {
        let size = match self.symbolic.schedule.is_parallel {
            true => {
                b.par_chunks(CHUNK_ENTRIES).map(max_norm).reduce(|| 0.0, |a, b| max_norm(&[a, b]))
            }
            false => max_norm(b),
        };
        if size.is_finite() {
            return Ok(size);
        }
        let row = b.iter().position(|v| !v.is_finite()).unwrap_or(0);
        Err(SolverError::RightHandSideNotFinite { row, value: b[row] })
    }
}

/// A solution by the factor, corrected until corrections no longer shrink, with residuals in
/// double precision (iterative refinement: Wilkinson 1963; Higham 2002).
struct Refined<'a> {
    factor: &'a mut FrontalFactor,
    b: &'a [f64],
    x: &'a mut [f64],
    residual: Vec<f64>,
    correction: Vec<f64>,
    /// Size of the last correction; at first that of the solution.
    last: f64,
    /// Corrections in a row that did not shrink.
    stalled: u32,
}

impl Refinement for Refined<'_> {
    fn evaluate_residual(&mut self) {
        self.factor.m_matrix.residual(self.b, self.x, &mut self.residual);
    }

    fn evaluate_correction(&mut self) -> Result<(), SolverError> {
        let size = max_norm(&self.residual);
        self.factor.solve_once(&self.residual, size, &mut self.correction);
        Ok(())
    }

    fn correct(&mut self, _round: usize) -> ControlFlow<()> {
        let size = max_norm(&self.correction);
        // One that does not shrink may have been behind the noise of the
        // one before; two are round-off.
        self.stalled = if size > 0.5 * self.last { self.stalled + 1 } else { 0 };
        if size == 0.0 || size.is_nan() || self.stalled == 2 {
            return ControlFlow::Break(());
        }
        self.x.iter_mut().zip(&self.correction).for_each(|(x, c)| *x += c);
        // The next one would shrink as this one has.
        if size * (size / self.last) <= REFINEMENT_TOLERANCE * max_norm(self.x) {
            return ControlFlow::Break(());
        }
        self.last = size;
        ControlFlow::Continue(())
    }
}

impl Factor for FrontalFactor {
    fn solver(&self) -> &'static str {
        NAME
    }

    fn analysis(&self) -> Analysis {
        self.symbolic.analysis
    }

    fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        let n = self.symbolic.pattern.n;
        require_size("the right-hand side", n, b.len())?;
        require_size("the solution", n, x.len())?;
        let size = self.size_of(b)?;
        self.solve_once(b, size, x);
        let residual = std::mem::take(&mut self.residual);
        let correction = std::mem::take(&mut self.correction);
        let last = max_norm(x);
        let mut refined = Refined { factor: self, b, x, residual, correction, last, stalled: 0 };
        refine(&mut refined, MAX_CORRECTIONS)?;
        let Refined { residual, correction, .. } = refined;
        self.residual = residual;
        self.correction = correction;
        Ok(())
    }

    fn correct(&mut self, r: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        let n = self.symbolic.pattern.n;
        require_size("the residual", n, r.len())?;
        require_size("the correction", n, x.len())?;
        let size = self.size_of(r)?;
        self.solve_once(r, size, x);
        Ok(())
    }

    fn correct_checked(
        &mut self,
        a: &SymmetricCsc,
        r: &[f64],
        x: &mut [f64],
    ) -> Result<f64, SolverError> {
        let residual = self.solve_checked(a, r, x)?;
        self.correct(r, x)?;
        let rough = a.residual(r, x)?;
        if rough <= CORRECTION_LIMIT {
            Ok(residual)
        } else {
            Err(SolverError::ResidualTooLarge { residual: rough, limit: CORRECTION_LIMIT })
        }
    }

    fn refactor(mut self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factorize(a)?;
        Ok(self)
    }

    fn memory_bytes(&self) -> usize {
        let FrontalSymbolic { pattern, schedule, layout, .. } = &self.symbolic;
        self.packed.memory_bytes()
            + 4 * self.vectors.len()
            + 16 * pattern.n
            + pattern.memory_bytes()
            + schedule.memory_bytes()
            + layout.memory_bytes()
            + self.m_matrix.memory_bytes()
    }

    fn placement(&self) -> &Placement {
        &Placement::Cpu
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of pores whose throats' conductances span so many decades, with a leak in each
    /// of the first layer.
    fn network(m: usize, decades: f64) -> SymmetricCsc {
        let n = m * m * m;
        let conductance = |k: usize| 10f64.powf(-decades * ((k * 7919 + 13) % 101) as f64 / 101.0);
        let mut a = SymmetricCsc { n, col_ptr: vec![0], ..Default::default() };
        let mut diagonal: Vec<f64> =
            (0..n).map(|k| if k < m * m { conductance(k) } else { 0.0 }).collect();
        for k in 0..n {
            a.row_idx.push(k as i64);
            a.values.push(0.0);
            for (axis, step) in [1, m, m * m].into_iter().enumerate() {
                if k / step % m + 1 < m {
                    let g = conductance(3 * k + axis);
                    a.row_idx.push((k + step) as i64);
                    a.values.push(-g);
                    diagonal[k] += g;
                    diagonal[k + step] += g;
                }
            }
            a.col_ptr.push(a.row_idx.len() as i64);
        }
        for (k, d) in diagonal.into_iter().enumerate() {
            a.values[a.col_ptr[k] as usize] = d;
        }
        a
    }

    /// With blocks kept as low-rank sums a correction leaves about what it does without, of an error
    /// in which neighbours differ at random: where conductances span three decades 3e-5
    /// was seen with and without, where nine 8e-3 and 3e-3. Any number of threads gives the
    /// same bits.
    #[test]
    fn low_rank_blocks_keep_the_digits_of_a_correction() {
        for (decades, bound) in [(3.0, 1e-4), (9.0, 2e-2)] {
            low_rank_keeps_digits(&network(30, decades), bound);
        }
    }

    fn low_rank_keeps_digits(a: &SymmetricCsc, bound: f64) {
        let truth: Vec<f64> = (0..a.n).map(|k| 1.0 + (k * 31 % 1_009) as f64 / 1_009.0).collect();
        let mut b = vec![0.0; a.n];
        a.multiply(&truth, &mut b).unwrap();
        let run = |threads: usize, low_rank: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let pattern = Pattern::new(a, cholmod::metis_order(a).unwrap()).unwrap();
                let schedule = Schedule { low_rank, ..Schedule::new(&pattern) };
                let layout = FactorLayout::new(&pattern);
                let analysis = Analysis { ordering: "metis", nnz_l: 0, flops: 0.0 };
                let hash = a.pattern_hash();
                let symbolic = FrontalSymbolic { pattern, schedule, layout, analysis, hash };
                let symbolic: Box<dyn Symbolic> = Box::new(symbolic);
                let mut x = vec![0.0; a.n];
                symbolic.factor(a).unwrap().correct(&b, &mut x).unwrap();
                x
            })
        };
        let error = |x: &[f64]| x.iter().zip(&truth).fold(0.0f64, |m, (x, t)| m.max((x - t).abs()));
        let (without, with) = (run(2, false), run(2, true));
        assert!(error(&without) < bound && error(&with) < bound);
        assert!(with != without);
        assert!(with == run(1, true) && with == run(5, true));
    }
}
