//! An analysis that outlives its network.

use std::fmt;

use crate::solver::{Factor, Solver, SymmetricCsc};

/// A factor that is no longer needed, with the pattern and the points of the
/// unknowns that were analyzed for it: a matrix of the same needs no other
/// analysis, and takes its memory over. Points count because solvers may order by
/// them, and then the bits must not depend on which networks were there before.
pub struct ReusableAnalysis {
    factor: Box<dyn Factor>,
    solver: Solver,
    col_ptr: Vec<i64>,
    row_idx: Vec<i64>,
    points: Vec<[f64; 3]>,
}

impl ReusableAnalysis {
    pub(super) fn new(
        factor: Box<dyn Factor>,
        solver: Solver,
        matrix: SymmetricCsc,
        points: Vec<[f64; 3]>,
    ) -> ReusableAnalysis {
        let SymmetricCsc { col_ptr, row_idx, .. } = matrix;
        ReusableAnalysis { factor, solver, col_ptr, row_idx, points }
    }

    pub(super) fn serves(
        &self,
        solver: &Solver,
        matrix: &SymmetricCsc,
        points: &[[f64; 3]],
    ) -> bool {
        self.solver == *solver
            && self.points == points
            && self.col_ptr == matrix.col_ptr
            && self.row_idx == matrix.row_idx
    }

    pub(super) fn into_factor(self) -> Box<dyn Factor> {
        self.factor
    }
}

impl fmt::Debug for ReusableAnalysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ReusableAnalysis")
            .field("solver", &self.solver)
            .field("unknowns", &self.points.len())
            .field("analysis", &self.factor.analysis())
            .finish()
    }
}
