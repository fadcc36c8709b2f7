//! The matrix type that every backend borrows.

/// A sparse symmetric matrix: its lower triangle by columns.
///
/// Row indices ascend within a column and the diagonal comes first. Indices
/// are 64 bits wide so that CHOLMOD can borrow the arrays without a copy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SymmetricCsc {
    /// Number of rows and columns.
    pub n: usize,
    /// Where each column starts in `row_idx` and `values`; `n + 1` entries.
    pub col_ptr: Vec<i64>,
    /// Row of each entry, on or below the diagonal.
    pub row_idx: Vec<i64>,
    /// Value of each entry.
    pub values: Vec<f64>,
}
