//! Conjugate gradients with a preconditioner that is nearly the inverse (Hestenes and Stiefel
//! 1952), ended by an estimate of the error and not by the residual.

use rayon::prelude::*;

use super::{LinearOperator, Preconditioner, SolverError, require_size};
use crate::parallel::{SERIAL, TASK, for_each};

/// Largest number of applications of the preconditioner in a solve.
const MAX_APPLICATIONS: u32 = 48;
/// Largest ratio of two corrections that tells of convergence: beyond, the
/// error is taken for twenty times the correction.
const MAX_CONTRACTION: f64 = 0.95;
/// The error is taken for so many times the last correction at least: where
/// single unknowns are far from the preconditioner, corrections are smaller than what
/// they miss.
const MIN_ERROR_PER_CORRECTION: f64 = 4.0;

/// When a solution is good enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorGoal {
    /// Largest estimated error (1): root of the sum of squares, relative to the solution's
    /// distance from `datum`.
    pub relative_error: f64,
    /// The level that the solution is measured from, in its unit.
    pub datum: f64,
    /// Corrections of this length (root of the sum of squares, in the solution's unit) are
    /// round-off.
    pub round_off: f64,
}

/// How an iterated solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Iterations {
    /// Applications of the preconditioner.
    pub applications: u32,
    /// Estimated error of the solution (1): root of the sum of squares,
    /// relative to its distance from the datum.
    pub error: f64,
}

/// The method of preconditioned conjugate gradients, with its memory.
///
/// The residual tells little of the solution where coefficients span many decades; the
/// corrections do: they are residuals divided by nearly the right matrix. With ρ the ratio
/// of the last two, what is missing still is about ρ/(1 − ρ) times the last one. It is taken
/// for four times the last one at least, so that one small correction ends nothing by chance.
///
/// Results have the same bits for any number of threads.
///
/// ```
/// use dempfv::solver::{ConjugateGradients, ErrorGoal, SolverKind, SymmetricCsc};
/// // Three pores in a row between two imposed pressures; the factor is that of another matrix.
/// let a = SymmetricCsc {
///     n: 3,
///     col_ptr: vec![0, 2, 4, 5],
///     row_idx: vec![0, 1, 1, 2, 2],
///     values: vec![2.0, -1.0, 2.0, -1.0, 2.0],
/// };
/// let mut old = a.clone();
/// old.values[0] = 2.5;
/// let mut factor = SolverKind::Cholmod.backend().analyze(&old, None)?.factor(&old)?;
/// let (mut x, mut residual) = ([0.0; 3], [4.0, 0.0, 0.0]);
/// let goal = ErrorGoal { relative_error: 1e-12, ..ErrorGoal::default() };
/// let went = ConjugateGradients::default().solve(&mut &a, &mut *factor, &mut x, &mut residual, &goal)?;
/// assert!(went.error <= 1e-12 && (x[0] - 3.0).abs() < 1e-11);
/// # Ok::<(), dempfv::solver::SolverError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ConjugateGradients {
    correction: Vec<f64>,
    direction: Vec<f64>,
    /// The matrix times the direction.
    product: Vec<f64>,
    partial_sums: Vec<f64>,
}

impl ConjugateGradients {
    /// Goes on from `x`, whose residual b − A x is `residual`, until the estimated error
    /// reaches the goal, nothing is left, or 48 applications are done; then
    /// [`Iterations::error`] is larger than the goal. `residual` is that of the
    /// new `x` afterwards. Allocates in the first call only.
    ///
    /// # Errors
    /// `x` or `residual` has not one entry per unknown or is not finite, the matrix cannot be
    /// applied, a number of the goal is none, or the preconditioner fails.
    pub fn solve(
        &mut self,
        a: &mut impl LinearOperator,
        preconditioner: &mut (impl Preconditioner + ?Sized),
        x: &mut [f64],
        residual: &mut [f64],
        goal: &ErrorGoal,
    ) -> Result<Iterations, SolverError> {
        require_size("the residual", a.unknowns(), residual.len())?;
        require_size("the solution", a.unknowns(), x.len())?;
        a.check()?;
        let ErrorGoal { relative_error, datum, round_off } = *goal;
        if !(datum.is_finite() && relative_error >= 0.0 && round_off >= 0.0) {
            let what = format!("{goal:?} is no goal: an error and a round-off are 0 or more");
            return Err(refused(what));
        }
        self.fit(x.len());
        let mut went = Iterations::default();
        let (mut last, mut alpha, mut fall) = (0.0, 0.0, 0.0);
        loop {
            preconditioner.precondition(residual, &mut self.correction)?;
            went.applications += 1;
            let beta = match went.applications {
                1 => 0.0,
                // The preconditioner need not be the same to the last bit.
                _ => -alpha * dot(&self.correction, &self.product, &mut self.partial_sums) / fall,
            };
            fall = dot(residual, &self.correction, &mut self.partial_sums);
            if !fall.is_finite() {
                return Err(not_finite(
                    residual,
                    "the residual times its correction is not finite",
                ));
            }
            let curvature = self.turn(a, beta);
            // Nothing is left, or nothing can be told apart from round-off.
            if curvature <= 0.0 {
                if fall == 0.0 {
                    went.error = 0.0;
                }
                break;
            }
            alpha = fall / curvature;
            self.advance(alpha, x, residual);
            let step = dot(&self.correction, &self.correction, &mut self.partial_sums).sqrt();
            let ratio = if went.applications == 1 {
                MAX_CONTRACTION
            } else {
                f64::min(step / last, MAX_CONTRACTION)
            };
            let away = distance(x, goal.datum, &mut self.partial_sums);
            if !away.is_finite() {
                return Err(not_finite(x, "the solution is not finite"));
            }
            let missing = step * f64::max(MIN_ERROR_PER_CORRECTION, ratio / (1.0 - ratio));
            went.error = missing / away;
            last = step;
            if went.error <= goal.relative_error
                || step <= goal.round_off
                || went.applications == MAX_APPLICATIONS
            {
                break;
            }
        }
        Ok(went)
    }

    /// Takes memory in the first solve.
    fn fit(&mut self, unknowns: usize) {
        self.correction.resize(unknowns, 0.0);
        self.direction.resize(unknowns, 0.0);
        self.product.resize(unknowns, 0.0);
        self.partial_sums.resize(unknowns.div_ceil(TASK), 0.0);
    }

    /// Turns the direction `d` by β and returns `d · A d`.
    fn turn(&mut self, a: &mut impl LinearOperator, beta: f64) -> f64 {
        let correction = &self.correction;
        for_each(&mut self.direction, &|u, d| *d = correction[u] + beta * *d);
        a.apply(&self.direction, &mut self.product);
        dot(&self.direction, &self.product, &mut self.partial_sums)
    }

    /// Goes α along the direction.
    fn advance(&self, alpha: f64, x: &mut [f64], residual: &mut [f64]) {
        for_each(x, &|u, x| *x += alpha * self.direction[u]);
        for_each(residual, &|u, r| *r -= alpha * self.product[u]);
    }
}

fn refused(what: String) -> SolverError {
    SolverError::Refused { solver: "conjugate gradients", phase: "solve", what }
}

/// What is not finite, by its first entry where there is one.
fn not_finite(vector: &[f64], what: &str) -> SolverError {
    match vector.iter().position(|v| !v.is_finite()) {
        Some(row) => refused(format!("{what}: entry {row} is {}", vector[row])),
        None => refused(what.to_owned()),
    }
}

/// Distance of a vector from a level.
fn distance(x: &[f64], level: f64, partial_sums: &mut [f64]) -> f64 {
    let part = |x: &[f64]| x.iter().map(|x| (x - level) * (x - level)).sum();
    sum_of_parts(partial_sums, &|k| part(chunk(x, k))).sqrt()
}

fn dot(a: &[f64], b: &[f64], partial_sums: &mut [f64]) -> f64 {
    let part = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    sum_of_parts(partial_sums, &|k| part(chunk(a, k), chunk(b, k)))
}

/// The numbers that a partial sum takes.
fn chunk(x: &[f64], k: usize) -> &[f64] {
    &x[k * TASK..x.len().min((k + 1) * TASK)]
}

/// Adds partial sums up in one order, so that the bits do not depend on the
/// number of threads.
fn sum_of_parts(partial_sums: &mut [f64], part: &(impl Fn(usize) -> f64 + Sync)) -> f64 {
    if partial_sums.len() * TASK < SERIAL {
        partial_sums.iter_mut().enumerate().for_each(|(k, sum)| *sum = part(k));
    } else {
        partial_sums.par_iter_mut().enumerate().for_each(|(k, sum)| *sum = part(k));
    }
    partial_sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::SymmetricCsc;

    /// Divides by the diagonal.
    struct Jacobi(Vec<f64>);

    impl Preconditioner for Jacobi {
        fn precondition(&mut self, r: &[f64], correction: &mut [f64]) -> Result<(), SolverError> {
            correction.iter_mut().zip(r).zip(&self.0).for_each(|((c, r), d)| *c = r / d);
            Ok(())
        }
    }

    /// A row of unknowns, each joined to the next by a conductance of one and grounded by
    /// `leak`.
    fn row(n: usize, leak: f64) -> SymmetricCsc {
        let mut a = SymmetricCsc { n, col_ptr: vec![0], ..Default::default() };
        for k in 0..n {
            a.row_idx.push(k as i64);
            a.values.push(2.0 + leak);
            if k + 1 < n {
                a.row_idx.push(k as i64 + 1);
                a.values.push(-1.0);
            }
            a.col_ptr.push(a.row_idx.len() as i64);
        }
        a
    }

    fn solve(
        a: &SymmetricCsc,
        truth: &[f64],
        goal: &ErrorGoal,
    ) -> (Iterations, Vec<f64>, Vec<f64>) {
        let mut residual = vec![0.0; a.n];
        a.multiply(truth, &mut residual).unwrap();
        let mut x = vec![0.0; a.n];
        let mut jacobi = Jacobi((0..a.n).map(|k| a.values[a.col_ptr[k] as usize]).collect());
        let mut gradients = ConjugateGradients::default();
        let went = gradients.solve(&mut &*a, &mut jacobi, &mut x, &mut residual, goal).unwrap();
        (went, x, residual)
    }

    /// The estimate is no less than the error, and what is called the residual is one.
    #[test]
    fn the_error_is_estimated_from_above() {
        for (n, leak) in [(1, 1.0), (50, 0.5), (20_000, 1.0)] {
            let a = row(n, leak);
            let truth: Vec<f64> = (0..n).map(|k| 3.0 + (k * 31 % 17) as f64).collect();
            for relative_error in [1e-3, 1e-10] {
                let goal = ErrorGoal { relative_error, datum: 1.0, round_off: 0.0 };
                let (went, x, residual) = solve(&a, &truth, &goal);
                let off = |a: &[f64], b: f64| a.iter().map(|a| (a - b).powi(2)).sum::<f64>().sqrt();
                let missing: Vec<f64> = x.iter().zip(&truth).map(|(x, t)| x - t).collect();
                let error = off(&missing, 0.0) / off(&x, 1.0);
                assert!(went.error <= relative_error && error <= went.error + 1e-15, "{went:?}");
                let mut b = vec![0.0; n];
                a.multiply(&missing, &mut b).unwrap();
                assert!(b.iter().zip(&residual).all(|(b, r)| (b + r).abs() < 1e-11));
            }
        }
    }

    /// A solve that comes to no end says so.
    #[test]
    fn what_does_not_converge_is_told() {
        let a = row(5_000, 0.0);
        let truth: Vec<f64> = (0..a.n).map(|k| (k % 1_000) as f64).collect();
        let goal = ErrorGoal { relative_error: 1e-12, ..ErrorGoal::default() };
        let (went, ..) = solve(&a, &truth, &goal);
        assert!(went.applications == MAX_APPLICATIONS && went.error > 1e-6, "{went:?}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let a = row(50_000, 0.3);
        let truth: Vec<f64> = (0..a.n).map(|k| (k * 7919 % 1009) as f64).collect();
        let goal = ErrorGoal { relative_error: 1e-9, ..ErrorGoal::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve(&a, &truth, &goal).1)
        };
        assert!(on(1) == on(3));
    }

    #[test]
    fn vectors_of_another_length_are_refused() {
        let a = row(3, 1.0);
        let (mut x, mut residual) = (vec![0.0; 2], vec![1.0; 3]);
        let mut gradients = ConjugateGradients::default();
        let goal = ErrorGoal::default();
        let found =
            gradients.solve(&mut &a, &mut Jacobi(vec![3.0; 3]), &mut x, &mut residual, &goal);
        assert!(matches!(found, Err(SolverError::WrongSize { expected: 3, found: 2, .. })));
    }
}
