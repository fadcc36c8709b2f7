//! Sparse symmetric positive definite systems.

mod matrix;

pub use matrix::SymmetricCsc;

/// The linear solver failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The matrix is not positive definite.
    #[error("not positive definite at column {column}")]
    NotPositiveDefinite {
        /// Column (unknown), counted from 0 in the caller's numbering.
        column: usize,
    },
}
