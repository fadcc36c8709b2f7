//! What can go wrong between a matrix and its solution.

/// The linear solver failed. Rows and columns are counted from 0 in the
/// caller's numbering, whatever the solver's own ordering.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The matrix is not positive definite.
    #[error("the matrix is not positive definite at unknown {column}")]
    NotPositiveDefinite {
        /// Column (unknown) whose pivot is not positive.
        column: usize,
    },
    /// The matrix is singular to working precision: no digit of this unknown
    /// would be right.
    #[error(
        "the matrix is singular to working precision (a pivot is {ratio:.1e} of its diagonal entry) \
         at unknown {column}"
    )]
    NearlySingular {
        /// Column (unknown) with the vanishing pivot.
        column: usize,
        /// Pivot divided by the diagonal entry of the matrix.
        ratio: f64,
    },
    /// The system is so badly conditioned that round-off decides its solution.
    #[error(
        "the matrix is singular to working precision: its condition number is about {condition:.1e}, \
         and round-off alone may change the solution by {error:.1e} of its size, so that no digit \
         can be trusted"
    )]
    IllConditioned {
        /// Estimate of the condition number, see [`condition_number`](super::condition_number).
        condition: f64,
        /// Estimate of the relative error, see [`forward_error`](super::forward_error).
        error: f64,
    },
    /// The solver is for matrices without positive entries off the diagonal.
    #[error(
        "the entry in row {row}, column {column} is {value:e}; this solver is for matrices whose \
         entries off the diagonal are not positive (use cholmod)"
    )]
    PositiveOffDiagonal {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// The solver is for matrices whose rows have no negative sum.
    #[error(
        "row {row} sums up to {sum:e} (its diagonal entry is {diagonal:e}); this solver is for \
         matrices whose rows do not have a negative sum (use cholmod)"
    )]
    NotDominant {
        /// The row.
        row: usize,
        /// Its sum.
        sum: f64,
        /// Its diagonal entry.
        diagonal: f64,
    },
    /// The arrays of a matrix do not describe a symmetric matrix by its lower
    /// triangle.
    #[error("column {column} of the matrix: {what}")]
    InvalidMatrix {
        /// Column where the fault was found.
        column: usize,
        /// What is wrong, and what would be right.
        what: &'static str,
    },
    /// An entry of the matrix is infinite or not a number.
    #[error("the matrix entry in row {row}, column {column} is {value}")]
    MatrixNotFinite {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// An entry of the right-hand side is infinite or not a number.
    #[error("entry {row} of the right-hand side is {value}")]
    RightHandSideNotFinite {
        /// Row of the entry.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// An order of elimination names an unknown twice, or one that there is not.
    #[error(
        "entry {place} of the order of elimination is {unknown}: each unknown must come once, \
         counted from 0"
    )]
    NoPermutation {
        /// The entry at fault.
        place: usize,
        /// The unknown that it names.
        unknown: i64,
    },
    /// An entry lies outside the matrix.
    #[error("the entry in row {row}, column {column} lies outside a matrix of {n} unknowns")]
    EntryOutside {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Number of rows and columns.
        n: usize,
    },
    /// A vector or a matrix does not have the size of the system.
    #[error("{what} has {found} entries for a system of {expected} unknowns")]
    WrongSize {
        /// Which one.
        what: &'static str,
        /// Entries that it should have.
        expected: usize,
        /// Entries that it has.
        found: usize,
    },
    /// The matrix to factor has another pattern than the one analyzed.
    #[error("the matrix has another pattern than the one that was analyzed; analyze it anew")]
    PatternChanged,
    /// Memory ran out.
    #[error("{solver} ran out of memory in {phase} of {n} unknowns")]
    OutOfMemory {
        /// Name of the solver.
        solver: &'static str,
        /// What it was doing: `analyze`, `factor` or `solve`.
        phase: &'static str,
        /// Number of unknowns.
        n: usize,
    },
    /// The limit of the address space leaves no room for the BLAS.
    #[error(
        "{solver} needs {needed} bytes of address space for a buffer of OpenBLAS, and the limit \
         (ulimit -v) leaves {left}; raise it, or use the solver frontal"
    )]
    AddressSpace {
        /// Name of the solver.
        solver: &'static str,
        /// Bytes that it needs.
        needed: u64,
        /// Bytes that are left.
        left: u64,
    },
    /// The factor has more entries than the solver can count.
    #[error("{solver} cannot count the entries of the factor of {n} unknowns")]
    TooLarge {
        /// Name of the solver.
        solver: &'static str,
        /// Number of unknowns.
        n: usize,
    },
    /// The solver's library lacks a part that is needed, or refused its input.
    #[error("{solver} refused to {phase}: {what}")]
    Refused {
        /// Name of the solver.
        solver: &'static str,
        /// What it was asked to do: `analyze`, `factor` or `solve`.
        phase: &'static str,
        /// What the library said.
        what: String,
    },
    /// The solution does not satisfy the system.
    #[error("the solution leaves a relative residual of {residual:.1e}, more than {limit:.1e}")]
    ResidualTooLarge {
        /// The residual, see [`SymmetricCsc::residual`](super::SymmetricCsc::residual).
        residual: f64,
        /// The largest one that is accepted.
        limit: f64,
    },
}

impl SolverError {
    /// The unknown where a factorization failed, if that is what the error is
    /// about.
    pub fn column(&self) -> Option<usize> {
        match self {
            SolverError::NotPositiveDefinite { column }
            | SolverError::NearlySingular { column, .. } => Some(*column),
            _ => None,
        }
    }
}
