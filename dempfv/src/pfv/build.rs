//! From a packing to a [`Flow`], phase by phase: whoever builds one may look
//! up between two phases, and stop.

use std::time::{Duration, Instant};

use super::{Flow, Fluid, Network, Operators};
use crate::solver::{Factor, SolverKind, Symbolic, SymmetricCsc};
use crate::{Aabb, Result, Vec3};

/// How long the parts of [`Flow::new`] took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildTimes {
    /// Triangulation, pores, throats and operators.
    pub network: Duration,
    /// Ordering and symbolic analysis; next to nothing where that of an
    /// earlier network served again.
    pub analyze: Duration,
    /// Numeric factorization.
    pub factor: Duration,
}

impl BuildTimes {
    /// All parts together.
    pub fn total(&self) -> Duration {
        self.network + self.analyze + self.factor
    }
}

impl std::ops::AddAssign for BuildTimes {
    fn add_assign(&mut self, other: BuildTimes) {
        self.network += other.network;
        self.analyze += other.analyze;
        self.factor += other.factor;
    }
}

/// A factor that is no longer needed, with the pattern and the places of the
/// unknowns that were analyzed for it: a matrix of the same needs no other
/// analysis, and takes its memory over. Places count because solvers may order by
/// them, and then the bits must not depend on which networks were there before.
pub struct Spare {
    factor: Box<dyn Factor>,
    solver: SolverKind,
    col_ptr: Vec<i64>,
    row_idx: Vec<i64>,
    places: Vec<[f64; 3]>,
}

impl Spare {
    pub(super) fn new(
        factor: Box<dyn Factor>,
        solver: SolverKind,
        matrix: SymmetricCsc,
        places: Vec<[f64; 3]>,
    ) -> Spare {
        Spare { factor, solver, col_ptr: matrix.col_ptr, row_idx: matrix.row_idx, places }
    }

    fn serves(&self, solver: SolverKind, matrix: &SymmetricCsc, places: &[[f64; 3]]) -> bool {
        self.solver == solver
            && self.places == places
            && self.col_ptr == matrix.col_ptr
            && self.row_idx == matrix.row_idx
    }
}

/// Where the unknowns of the matrix lie (m).
pub(super) fn places(network: &Network, operators: &Operators) -> Vec<[f64; 3]> {
    operators.pore_of.iter().map(|&i| network.center[i as usize].into()).collect()
}

/// First phase: a network and its operators. What only served to make them
/// is gone.
pub struct Assembled {
    network: Network,
    operators: Operators,
    times: BuildTimes,
}

/// Second phase: the order in which the unknowns are eliminated is known.
pub struct Analyzed {
    assembled: Assembled,
    solver: SolverKind,
    analysis: Analysis,
}

enum Analysis {
    /// Every pressure is imposed.
    Nothing,
    Fresh(Box<dyn Symbolic>),
    Reused(Box<dyn Factor>),
}

impl Assembled {
    /// Triangulates a packing and builds the operators.
    ///
    /// # Errors
    /// As [`Network::new`] and [`Operators::new`].
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<Assembled> {
        let start = Instant::now();
        let (network, derivatives) = Network::new(position, radius, bounds, fluid)?;
        let operators = Operators::new(&network, derivatives, fluid.boundary)?;
        let times = BuildTimes { network: start.elapsed(), ..BuildTimes::default() };
        Ok(Assembled { network, operators, times })
    }

    /// Orders and analyzes the matrix, or takes the analysis of the spare
    /// factor if pattern and places are its own. A spare of others is dropped
    /// first: its memory is needed.
    ///
    /// # Errors
    /// As [`Backend::analyze`](crate::solver::Backend::analyze).
    pub fn analyze(mut self, solver: SolverKind, spare: Option<Spare>) -> Result<Analyzed> {
        let matrix = &self.operators.matrix;
        let start = Instant::now();
        let places = places(&self.network, &self.operators);
        let spare = spare.filter(|spare| spare.serves(solver, matrix, &places));
        let analysis = match spare {
            _ if matrix.n == 0 => Analysis::Nothing,
            Some(spare) => Analysis::Reused(spare.factor),
            None => Analysis::Fresh(solver.backend().analyze(matrix, Some(&places))?),
        };
        self.times.analyze = start.elapsed();
        Ok(Analyzed { assembled: self, solver, analysis })
    }
}

impl Analyzed {
    /// Last phase: factors the matrix. The bits do not depend on whether the
    /// analysis is a new one.
    ///
    /// # Errors
    /// As [`Symbolic::factor`].
    pub fn factor(self) -> Result<Flow> {
        let Assembled { network, operators, mut times } = self.assembled;
        let reused = matches!(self.analysis, Analysis::Reused(_));
        let start = Instant::now();
        let factor = match self.analysis {
            Analysis::Nothing => None,
            Analysis::Fresh(symbolic) => Some(symbolic.factor(&operators.matrix)?),
            Analysis::Reused(factor) => Some(factor.refactor(&operators.matrix)?),
        };
        times.factor = start.elapsed();
        Ok(Flow::of_parts(network, operators, factor, self.solver, times, reused))
    }
}
