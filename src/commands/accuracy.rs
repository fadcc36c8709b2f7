//! How far a solution can be trusted, in words.

use dempfv::solver::{Factor, SolverError, SymmetricCsc, condition_number, forward_error};
use serde::Serialize;

/// Solutions whose error may be larger are warned of: fewer than four digits are right.
const FEW_DIGITS: f64 = 1e-4;

/// How well the system determines its solution.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Accuracy {
    /// Estimate of ‖A‖₁ ‖A⁻¹‖₁.
    pub condition: f64,
    /// Estimate of the largest error relative to the largest unknown, from the residual and from
    /// entries that are rounded to double precision.
    pub error_estimate: f64,
}

impl Accuracy {
    /// Estimates it for a solution of the factored matrix.
    ///
    /// # Errors
    /// [`SolverError::IllConditioned`] where no digit can be trusted.
    pub fn of(
        factor: &mut dyn Factor,
        a: &SymmetricCsc,
        b: &[f64],
        x: &[f64],
    ) -> Result<Accuracy, SolverError> {
        let condition = condition_number(factor, a)?;
        let error = forward_error(factor, a, b, x)?;
        // Not `<`: an error that is no number must not pass.
        if error < 1.0 {
            Ok(Accuracy { condition, error_estimate: error })
        } else {
            Err(SolverError::IllConditioned { condition, error })
        }
    }

    /// What a user should know before he takes the solution for right.
    pub fn warning(self, solver: &str) -> Option<String> {
        let Accuracy { condition, error_estimate: error } = self;
        if error < FEW_DIGITS {
            return None;
        }
        let right = match (-error.log10()).floor() as u32 {
            0 => "hardly the first digit of the solution is right".to_owned(),
            1 => "about 1 digit of the solution is right".to_owned(),
            digits => format!("about {digits} digits of the solution are right"),
        };
        Some(format!(
            "{solver}: the condition number of the matrix is about {condition:.1e}, so that {right}"
        ))
    }
}
