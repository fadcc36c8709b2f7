//! Sparse symmetric positive definite systems.
//!
//! A [`Backend`] turns a pattern into a [`Symbolic`], that and the values into
//! a [`Factor`], and only a factor solves:
//!
//! ```
//! use dempfv::solver::{SolverKind, SymmetricCsc};
//! # fn main() -> Result<(), dempfv::solver::SolverError> {
//! // Three pores in a row between two imposed pressures.
//! let mut a = SymmetricCsc {
//!     n: 3,
//!     col_ptr: vec![0, 2, 4, 5],
//!     row_idx: vec![0, 1, 1, 2, 2],
//!     values: vec![2.0, -1.0, 2.0, -1.0, 2.0],
//! };
//! let symbolic = SolverKind::Cholmod.backend().analyze(&a, None)?;
//! let mut factor = symbolic.factor(&a)?;
//! let mut x = [0.0; 3];
//! let residual = factor.solve_checked(&a, &[4.0, 0.0, 0.0], &mut x)?;
//! assert!(residual < 1e-15 && (x[0] - 3.0).abs() < 1e-14);
//!
//! // The network changed, its pattern did not.
//! a.values[0] = 3.0;
//! let mut factor = factor.refactor(&a)?;
//! factor.solve(&[4.0, 0.0, 0.0], &mut x)?;
//! # Ok(())
//! # }
//! ```
//!
//! Solving before factoring does not compile:
//!
//! ```compile_fail,E0599
//! # use dempfv::solver::{SolverKind, SymmetricCsc};
//! # fn main() -> Result<(), dempfv::solver::SolverError> {
//! # let a = SymmetricCsc { n: 1, col_ptr: vec![0, 1], row_idx: vec![0], values: vec![2.0] };
//! let mut symbolic = SolverKind::Cholmod.backend().analyze(&a, None)?;
//! symbolic.solve(&[4.0], &mut [0.0])?;
//! # Ok(())
//! # }
//! ```

mod address_space;
mod auto;
pub mod blas;
mod cholmod;
mod condition;
mod cost;
mod elimination_tree;
mod error;
mod frontal;
mod gpu_info;
mod kind;
mod matrix;
mod operator;
pub mod ordering;
mod pcg;
mod placement;
mod refine;

use std::fmt;

pub use address_space::address_space_limit;
pub use auto::Auto;
pub use cholmod::{Cholmod, CholmodGpu};
pub use condition::{condition_number, forward_error};
pub use cost::{Cost, CostModel, FRONTAL_FROM, Fill, SystemSize};
pub use error::SolverError;
pub use frontal::Frontal;
pub use gpu_info::{GpuInfo, gpus};
pub use kind::{Solver, SolverKind, UnknownSolver};
pub use matrix::SymmetricCsc;
pub use operator::{LinearOperator, Preconditioner};
pub use pcg::{ConjugateGradients, ErrorGoal, Iterations};
pub use placement::{GpuOptions, GpuWork, Placement};
pub(crate) use refine::{Refinement, refine};

/// Largest residual of a checked solve (see [`SymmetricCsc::residual`]). A
/// sound factorization leaves some 10⁻¹⁶.
pub const RESIDUAL_LIMIT: f64 = 1e-8;

/// A direct solver.
pub trait Backend: Send + Sync {
    /// The solver's name in scenes, reports and messages.
    fn name(&self) -> &'static str;

    /// Orders the unknowns and finds the pattern of the factor. `coordinates`
    /// (one point per unknown, any unit) may help the ordering; a solver that
    /// orders by the graph alone ignores them.
    ///
    /// # Errors
    /// The matrix is malformed ([`SymmetricCsc::validate`]), the coordinates
    /// are not one per unknown, or memory ran out.
    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError>;

    /// What a system of this size can be expected to take; `None` where the solver has no cost
    /// model.
    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        let _ = size;
        None
    }
}

/// What the pattern alone tells of a factorization.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Analysis {
    /// Name of the fill-reducing ordering.
    pub ordering: &'static str,
    /// Number of entries of the factor L.
    pub nnz_l: u64,
    /// Floating point operations of the factorization.
    pub flops: f64,
}

/// An ordering and the pattern of the factor.
pub trait Symbolic: Send {
    /// What the analysis found.
    fn analysis(&self) -> Analysis;

    /// Factors a matrix of the pattern that was analyzed.
    ///
    /// # Errors
    /// The pattern is another one, an entry is not finite, the matrix is not
    /// positive definite or singular to working precision, or memory ran out.
    fn factor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError>;
}

/// A factored matrix, ready to solve. It may move to another thread.
pub trait Factor: Send {
    /// Name of the solver that made it: that which [`Auto`] has chosen.
    fn solver(&self) -> &'static str;

    /// What the analysis of the pattern found.
    fn analysis(&self) -> Analysis;

    /// Solves A x = b. Allocates nothing after the first call.
    ///
    /// # Errors
    /// `b` or `x` has not one entry per unknown, an entry of `b` is not
    /// finite, or (in the first call) memory ran out.
    fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), SolverError>;

    /// Solves A X = B for many right-hand sides, which follow each other in `b` as their
    /// solutions do in `x`: column k is `b[k n..(k + 1) n]`. Each solution has the bits that
    /// [`Factor::solve`] gives for its right-hand side alone.
    ///
    /// # Errors
    /// As [`Factor::solve`]; `b` or `x` has not `columns` times as many entries as there are
    /// unknowns.
    fn solve_many(&mut self, b: &[f64], x: &mut [f64], columns: usize) -> Result<(), SolverError> {
        // No columns: then neither may have any entry.
        let n = b.len().checked_div(columns).unwrap_or(0);
        require_size("the block of right-hand sides", n * columns, b.len())?;
        require_size("the block of solutions", b.len(), x.len())?;
        if n == 0 {
            return Ok(());
        }
        b.chunks_exact(n).zip(x.chunks_exact_mut(n)).try_for_each(|(b, x)| self.solve(b, x))
    }

    /// x ≈ A⁻¹ r for a residual r: all digits that the factor has without any
    /// refinement, which the caller does himself. The same as [`Factor::solve`]
    /// for a factor in double precision. Allocates nothing after the first call.
    ///
    /// # Errors
    /// As [`Factor::solve`].
    fn correct(&mut self, r: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        self.solve(r, x)
    }

    /// [`Factor::correct`] for the first time after a factorization: checks the
    /// correction too. Returns the residual that [`Factor::solve`] leaves, as
    /// [`Factor::solve_checked`].
    ///
    /// # Errors
    /// As [`Factor::solve_checked`].
    fn correct_checked(
        &mut self,
        a: &SymmetricCsc,
        r: &[f64],
        x: &mut [f64],
    ) -> Result<f64, SolverError> {
        self.solve_checked(a, r, x)
    }

    /// Factors another matrix of the same pattern, in the memory of this
    /// factor; the result is that of a fresh factorization, bit for bit. A
    /// failure consumes the factor, so none is left that solves nothing.
    ///
    /// # Errors
    /// As [`Symbolic::factor`].
    fn refactor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError>;

    /// Memory that the factor holds, in bytes.
    fn memory_bytes(&self) -> usize;

    /// Where the factorization was computed.
    fn placement(&self) -> &Placement;

    /// Solves A x = b and returns the residual ([`SymmetricCsc::residual`]),
    /// for the first solve after a factorization. `a` is the factored matrix.
    ///
    /// # Errors
    /// As [`Factor::solve`], and [`SolverError::ResidualTooLarge`] above
    /// [`RESIDUAL_LIMIT`].
    fn solve_checked(
        &mut self,
        a: &SymmetricCsc,
        b: &[f64],
        x: &mut [f64],
    ) -> Result<f64, SolverError> {
        self.solve(b, x)?;
        let residual = a.residual(b, x)?;
        // Not `>`: a residual that is no number must not pass.
        if residual <= RESIDUAL_LIMIT {
            Ok(residual)
        } else {
            Err(SolverError::ResidualTooLarge { residual, limit: RESIDUAL_LIMIT })
        }
    }
}

impl fmt::Debug for dyn Backend + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Backend({})", self.name())
    }
}

impl fmt::Debug for dyn Symbolic + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Symbolic").field(&self.analysis()).finish()
    }
}

impl fmt::Debug for dyn Factor + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Factor")
            .field("solver", &self.solver())
            .field("analysis", &self.analysis())
            .field("placement", self.placement())
            .field("memory_bytes", &self.memory_bytes())
            .finish()
    }
}

/// Refuses a vector that has not one entry per unknown.
fn require_size(what: &'static str, expected: usize, found: usize) -> Result<(), SolverError> {
    if found == expected { Ok(()) } else { Err(SolverError::WrongSize { what, expected, found }) }
}
