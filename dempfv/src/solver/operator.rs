//! What an iterative solver needs of a system: its matrix as a map, and a rough inverse.

use super::{Factor, SolverError, SymmetricCsc};

/// A symmetric positive definite matrix that is known by what it does to a vector. It need not
/// be stored.
pub trait LinearOperator {
    /// Number of unknowns.
    fn unknowns(&self) -> usize;

    /// Refuses what cannot be applied: looked at once, before a solve.
    ///
    /// # Errors
    /// Why not.
    fn check(&self) -> Result<(), SolverError> {
        Ok(())
    }

    /// y = A x. Both have one entry per unknown. May use memory of its own, hence `&mut`.
    fn apply(&mut self, x: &[f64], y: &mut [f64]);
}

/// A rough inverse of a matrix: it turns a residual into a correction.
pub trait Preconditioner {
    /// Writes a correction M⁻¹ r. `r` and `correction` have one entry per unknown.
    ///
    /// # Errors
    /// An entry of `r` is not finite, or the application fails.
    fn precondition(&mut self, r: &[f64], correction: &mut [f64]) -> Result<(), SolverError>;
}

impl LinearOperator for &SymmetricCsc {
    fn unknowns(&self) -> usize {
        self.n
    }

    fn check(&self) -> Result<(), SolverError> {
        self.validate()
    }

    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        self.product(x, y);
    }
}

/// The factor of the matrix, or of one that is near it.
impl Preconditioner for dyn Factor + '_ {
    fn precondition(&mut self, r: &[f64], correction: &mut [f64]) -> Result<(), SolverError> {
        self.correct(r, correction)
    }
}
