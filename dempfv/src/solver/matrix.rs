//! The matrix type that every backend borrows.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::{SolverError, require_size};

/// A sparse symmetric matrix: its lower triangle by columns.
///
/// Row indices ascend within a column and the diagonal comes first. Indices
/// are 64 bits wide so that CHOLMOD can borrow the arrays without a copy.
///
/// ```
/// use dempfv::solver::SymmetricCsc;
/// // |  2 -1 |
/// // | -1  2 |
/// let a = SymmetricCsc {
///     n: 2,
///     col_ptr: vec![0, 2, 3],
///     row_idx: vec![0, 1, 1],
///     values: vec![2.0, -1.0, 2.0],
/// };
/// a.validate()?;
/// let mut y = [0.0; 2];
/// a.multiply(&[1.0, 3.0], &mut y)?;
/// assert_eq!(y, [-1.0, 5.0]);
/// # Ok::<(), dempfv::solver::SolverError>(())
/// ```
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

impl SymmetricCsc {
    /// A matrix from entries (row, column, value) of either triangle, in any order. Entries of the
    /// same place are added up, in their order; (i, j) and (j, i) are one place. A diagonal entry
    /// that is not given is zero.
    ///
    /// ```
    /// use dempfv::solver::SymmetricCsc;
    /// // Two pores with a throat of conductance 3 between them, one drained by another of 1.
    /// let throats = [(0, 0, 3.0), (1, 1, 3.0), (0, 1, -3.0), (1, 1, 1.0)];
    /// let a = SymmetricCsc::from_triplets(2, throats)?;
    /// assert_eq!((a.col_ptr, a.row_idx), (vec![0, 2, 3], vec![0, 1, 1]));
    /// assert_eq!(a.values, [3.0, -3.0, 4.0]);
    /// # Ok::<(), dempfv::solver::SolverError>(())
    /// ```
    ///
    /// # Errors
    /// [`SolverError::EntryOutside`] and [`SolverError::MatrixNotFinite`] with the first entry
    /// at fault, or the sum at fault; [`SolverError::OutOfMemory`] where so many unknowns have no
    /// room.
    pub fn from_triplets(
        n: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<SymmetricCsc, SolverError> {
        let (mut sorted, mut col_ptr) = (vec![], vec![]);
        let reserved = sorted.try_reserve(n).and_then(|()| col_ptr.try_reserve_exact(n + 1));
        if reserved.is_err() {
            return Err(SolverError::OutOfMemory { solver: "the matrix", phase: "assembly", n });
        }
        sorted.extend((0..n).map(|k| (k, k, 0.0)));
        col_ptr.resize(n + 1, 0);
        for (row, column, value) in entries {
            if row >= n || column >= n {
                return Err(SolverError::EntryOutside { row, column, n });
            }
            if !value.is_finite() {
                return Err(SolverError::MatrixNotFinite { row, column, value });
            }
            sorted.push((row.min(column), row.max(column), value));
        }
        // Stable: sums are in the order in which their terms came.
        sorted.sort_by_key(|&(column, row, _)| (column, row));
        let mut a = SymmetricCsc { n, col_ptr, ..SymmetricCsc::default() };
        let mut last = None;
        for (column, row, value) in sorted {
            if last == Some((column, row)) {
                if let Some(sum) = a.values.last_mut() {
                    *sum += value;
                }
                continue;
            }
            last = Some((column, row));
            a.row_idx.push(row as i64);
            a.values.push(value);
            a.col_ptr[column + 1] = a.row_idx.len() as i64;
        }
        a.check_finite()?;
        Ok(a)
    }

    /// Number of entries of the lower triangle.
    pub fn nnz(&self) -> usize {
        self.row_idx.len()
    }

    /// Whether 32 bits count the entries of both triangles, as our orderings and elimination trees
    /// do.
    pub(super) fn counts_in_32_bits(&self) -> bool {
        u32::try_from(2 * self.nnz()).is_ok()
    }

    /// The entries of a column: rows and values.
    fn column(&self, j: usize) -> (&[i64], &[f64]) {
        let range = self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize;
        (&self.row_idx[range.clone()], &self.values[range])
    }

    /// Checks that the arrays describe a symmetric matrix as the type says,
    /// and that every value is finite.
    ///
    /// # Errors
    /// [`SolverError::InvalidMatrix`] or [`SolverError::MatrixNotFinite`] with
    /// the first column at fault.
    pub fn validate(&self) -> Result<(), SolverError> {
        self.validate_pattern()?;
        self.check_finite()
    }

    /// The same, whatever the values.
    pub(super) fn validate_pattern(&self) -> Result<(), SolverError> {
        let fail = |column, what| Err(SolverError::InvalidMatrix { column, what });
        if self.col_ptr.len().checked_sub(1) != Some(self.n) || self.col_ptr[0] != 0 {
            return fail(0, "the column pointers must be n + 1 and start with 0");
        }
        if self.col_ptr[self.n] != self.row_idx.len() as i64
            || self.values.len() != self.row_idx.len()
        {
            return fail(
                self.n,
                "the last column pointer must be the number of rows and of values",
            );
        }
        // Before any column is looked at: one descent could hide an overrun.
        if let Some(column) = self.col_ptr.windows(2).position(|p| p[1] < p[0]) {
            return fail(column, "the column pointers must not descend");
        }
        for j in 0..self.n {
            let (rows, _) = self.column(j);
            if rows.first() != Some(&(j as i64)) {
                return fail(j, "the diagonal entry must come first");
            }
            if rows.windows(2).any(|r| r[1] <= r[0]) {
                return fail(j, "the rows must ascend");
            }
            if rows[rows.len() - 1] >= self.n as i64 {
                return fail(j, "a row lies outside the matrix");
            }
        }
        Ok(())
    }

    /// Checks that every value is finite.
    ///
    /// # Errors
    /// [`SolverError::MatrixNotFinite`] with the first entry that is not.
    pub fn check_finite(&self) -> Result<(), SolverError> {
        let Some(k) = self.values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
        let column = self.col_ptr.partition_point(|&start| start <= k as i64).saturating_sub(1);
        let row = self.row_idx.get(k).map_or(column, |&row| row as usize);
        Err(SolverError::MatrixNotFinite { row, column, value: self.values[k] })
    }

    /// A number that differs between patterns (up to chance, 2⁻⁶⁴), whatever
    /// the values.
    pub fn pattern_hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.n.hash(&mut hasher);
        self.col_ptr.hash(&mut hasher);
        self.row_idx.hash(&mut hasher);
        hasher.finish()
    }

    /// y = A x, in one fixed order of additions.
    ///
    /// # Errors
    /// [`SolverError::InvalidMatrix`] for a matrix that is none ([`SymmetricCsc::validate`]; its
    /// values do not matter), [`SolverError::WrongSize`] when `x` or `y` has not one entry per
    /// unknown.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) -> Result<(), SolverError> {
        self.validate_pattern()?;
        require_size("the vector to multiply", self.n, x.len())?;
        require_size("the vector for the product", self.n, y.len())?;
        self.product(x, y);
        Ok(())
    }

    /// [`SymmetricCsc::multiply`] for a valid matrix and vectors that have its size.
    pub(super) fn product(&self, x: &[f64], y: &mut [f64]) {
        self.scatter(x, y, |a| a);
    }

    /// y = |A| |x|, as [`SymmetricCsc::product`].
    pub(super) fn absolute_product(&self, x: &[f64], y: &mut [f64]) {
        let x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        self.scatter(&x, y, f64::abs);
    }

    /// y = f(A) x for a function of each entry.
    fn scatter(&self, x: &[f64], y: &mut [f64], f: impl Fn(f64) -> f64) {
        y.fill(0.0);
        for j in 0..self.n {
            let (rows, values) = self.column(j);
            let mut sum = f(values[0]) * x[j];
            for (&i, &a) in rows[1..].iter().zip(&values[1..]) {
                let (i, a) = (i as usize, f(a));
                y[i] += a * x[j];
                sum += a * x[i];
            }
            y[j] += sum;
        }
    }

    /// Largest row sum of absolute values, ‖A‖∞.
    ///
    /// # Panics
    /// May panic on a matrix that [`SymmetricCsc::validate`] refuses.
    pub fn norm_inf(&self) -> f64 {
        let mut sums = vec![0.0; self.n];
        self.scatter(&vec![1.0; self.n], &mut sums, f64::abs);
        norm_inf(&sums)
    }

    /// How far `x` is from solving A x = b:
    /// ‖b − A x‖∞ / (‖A‖∞ ‖x‖∞ + ‖b‖∞), the smallest relative change of A and
    /// b for which `x` is exact (Rigal and Gaches 1967). About 10⁻¹⁶ after a
    /// good direct solve; not a number if `x` or `b` has an entry that is none.
    ///
    /// # Errors
    /// As [`SymmetricCsc::multiply`].
    pub fn residual(&self, b: &[f64], x: &[f64]) -> Result<f64, SolverError> {
        require_size("the right-hand side", self.n, b.len())?;
        let mut r = vec![0.0; b.len()];
        self.multiply(x, &mut r)?;
        for (r, b) in r.iter_mut().zip(b) {
            *r = b - *r;
        }
        let numerator = norm_inf(&r);
        if numerator == 0.0 {
            return Ok(0.0);
        }
        Ok(numerator / (self.norm_inf() * norm_inf(x) + norm_inf(b)))
    }
}

/// Largest absolute value; not a number if any entry is none.
pub(super) fn norm_inf(x: &[f64]) -> f64 {
    // f64::max would drop a NaN.
    x.iter().fold(0.0, |norm, &v| if v.abs() > norm || v.is_nan() { v.abs() } else { norm })
}
