//! Iterative refinement (Wilkinson 1963): a solution is corrected by what a factor makes of its
//! residual, again and again. The factor may be rough and the residual better than the matrix.

use std::ops::ControlFlow;

use super::SolverError;

/// A solution that is being refined: how its residual is evaluated, how it is corrected, and
/// when that is enough.
pub(crate) trait Refinement {
    /// Evaluates the residual of the current solution.
    fn evaluate_residual(&mut self);

    /// Makes a correction of the residual.
    ///
    /// # Errors
    /// When the factor cannot be applied.
    fn evaluate_correction(&mut self) -> Result<(), SolverError>;

    /// Adds the correction to the solution, where it is of use. `round` counts from 0. Breaks
    /// when no other correction is needed or would help.
    fn correct(&mut self, round: usize) -> ControlFlow<()>;
}

/// Corrects a solution until its own rule says stop, `rounds` times at most. Returns whether the
/// rule said so.
///
/// # Errors
/// As [`Refinement::evaluate_correction`].
#[inline]
pub(crate) fn refine(solution: &mut impl Refinement, rounds: usize) -> Result<bool, SolverError> {
    for round in 0..rounds {
        solution.evaluate_residual();
        solution.evaluate_correction()?;
        if solution.correct(round).is_break() {
            return Ok(true);
        }
    }
    Ok(false)
}
