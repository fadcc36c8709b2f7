//! From a packing to a [`Flow`], phase by phase: whoever builds one may look
//! up between two phases, and stop.

use std::fmt;
use std::time::Instant;

use super::flow::{FlowParts, unknown_points};
use super::{
    BuildTimes, Flow, Fluid, ImposedPressure, Network, Operators, PfvError, PoreConditions,
    ReusableAnalysis,
};
use crate::solver::{Backend, Factor, Solver, Symbolic};
use crate::{Aabb, Vec3};

/// First phase: a network and its operators. What only served to make them
/// is gone.
#[derive(Debug)]
pub struct Assembled {
    network: Network,
    operators: Operators,
    radius: Vec<f64>,
    fluid: Fluid,
    imposed: Vec<ImposedPressure>,
    times: BuildTimes,
}

/// Second phase: the order in which the unknowns are eliminated is known.
#[derive(Debug)]
pub struct Analyzed {
    assembled: Assembled,
    solver: Solver,
    analysis: Analysis,
}

enum Analysis {
    /// Every pressure is imposed.
    Nothing,
    Fresh(Box<dyn Symbolic>),
    Reused(Box<dyn Factor>),
}

impl fmt::Debug for Analysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Analysis::Nothing => f.write_str("Nothing"),
            Analysis::Fresh(symbolic) => {
                f.debug_tuple("Fresh").field(&symbolic.analysis()).finish()
            }
            Analysis::Reused(factor) => f.debug_tuple("Reused").field(&factor.analysis()).finish(),
        }
    }
}

impl Assembled {
    /// Triangulates a packing and builds the operators: sphere centres and radii, and the box
    /// (m).
    ///
    /// # Errors
    /// As [`Network::new`].
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<Assembled, PfvError> {
        Assembled::with_imposed(position, radius, bounds, fluid, &[])
    }

    /// As [`Assembled::new`], with pressures imposed on pores of choice beside those of the
    /// walls.
    ///
    /// # Errors
    /// As [`Assembled::new`] and [`PoreConditions::impose`].
    pub fn with_imposed(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        imposed: &[ImposedPressure],
    ) -> Result<Assembled, PfvError> {
        let start = Instant::now();
        let (network, derivatives) = Network::new(position, radius, bounds, fluid)?;
        let mut conditions = PoreConditions::of_walls(&network, &fluid.boundary);
        for imposed in imposed {
            conditions.impose(&network, position, imposed)?;
        }
        let operators = Operators::assemble(&network, derivatives, conditions);
        let times = BuildTimes { network: start.elapsed(), ..BuildTimes::default() };
        Ok(Assembled {
            network,
            operators,
            radius: radius.to_vec(),
            fluid: *fluid,
            imposed: imposed.to_vec(),
            times,
        })
    }

    /// Orders and analyzes the matrix, or takes the analysis of the
    /// factor of an earlier network if pattern and points are its own. One of others is dropped
    /// first: its memory is needed.
    ///
    /// # Errors
    /// [`PfvError::Solver`] as [`Backend::analyze`](crate::solver::Backend::analyze).
    pub fn analyze(
        mut self,
        solver: impl Into<Solver>,
        reusable: Option<ReusableAnalysis>,
    ) -> Result<Analyzed, PfvError> {
        let solver = solver.into();
        let matrix = &self.operators.matrix;
        let start = Instant::now();
        let points = unknown_points(&self.network, &self.operators);
        let reusable = reusable.filter(|reusable| reusable.serves(&solver, matrix, &points));
        let analysis = match reusable {
            _ if matrix.n == 0 => Analysis::Nothing,
            Some(reusable) => Analysis::Reused(reusable.into_factor()),
            None => Analysis::Fresh(solver.analyze(matrix, Some(&points))?),
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
    /// [`PfvError::Solver`] as [`Symbolic::factor`].
    pub fn factor(self) -> Result<Flow, PfvError> {
        let Assembled { network, operators, radius, fluid, imposed, mut times } = self.assembled;
        let analysis_reused = matches!(self.analysis, Analysis::Reused(_));
        let start = Instant::now();
        let factor = match self.analysis {
            Analysis::Nothing => None,
            Analysis::Fresh(symbolic) => Some(symbolic.factor(&operators.matrix)?),
            Analysis::Reused(factor) => Some(factor.refactor(&operators.matrix)?),
        };
        times.factor = start.elapsed();
        Ok(Flow::of_parts(FlowParts {
            network,
            operators,
            factor,
            backend: self.solver,
            radius,
            fluid,
            imposed,
            times,
            analysis_reused,
        }))
    }
}

impl Flow {
    /// Builds the network of a packing and factors its conductance matrix: sphere centres and
    /// radii, and the box (m). The solver is a [`SolverKind`](crate::solver::SolverKind) or any
    /// `Arc<dyn Backend>`.
    ///
    /// # Errors
    /// As [`Network::new`], and [`PfvError::Solver`] when the
    /// factorization fails.
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        solver: impl Into<Solver>,
    ) -> Result<Flow, PfvError> {
        Flow::with_imposed(position, radius, bounds, fluid, &[], solver)
    }

    /// As [`Flow::new`], with pressures imposed on pores of choice beside those of the walls.
    ///
    /// ```
    /// use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, ImposedPressure, PoreSelection};
    /// use dempfv::solver::SolverKind;
    /// use dempfv::{Aabb, Vec3, WallId};
    ///
    /// // Two spheres in a box that is open at the top; 1 Pa in a corner of the bottom.
    /// let mut boundary = Boundary::default();
    /// boundary.pressure[WallId::YMax] = Some(0.0);
    /// let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    /// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// let x = [Vec3::new(0.3, 0.3, 0.4), Vec3::new(0.7, 0.6, 0.6)];
    /// let tube = PoreSelection::Around { center: Vec3::zeros(), radius: 0.3 };
    /// let imposed = [ImposedPressure { pores: tube, pressure: 1.0 }];
    /// let solver = SolverKind::default();
    /// let mut flow = Flow::with_imposed(&x, &[0.2, 0.2], bounds, &fluid, &imposed, solver)?;
    /// flow.solve_static()?;
    /// let injected = flow.imposed_flux()[0];
    /// assert!(injected > 0.0 && (injected + flow.flux()[WallId::YMax.index()]).abs() < 1e-10 * injected);
    /// # Ok::<(), dempfv::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Flow::new`] and [`PoreConditions::impose`].
    pub fn with_imposed(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        imposed: &[ImposedPressure],
        solver: impl Into<Solver>,
    ) -> Result<Flow, PfvError> {
        let assembled = Assembled::with_imposed(position, radius, bounds, fluid, imposed)?;
        assembled.analyze(solver, None)?.factor()
    }

    /// As [`Flow::new`], in place of a flow that is no longer needed: its
    /// analysis serves again if the matrix has the same pattern, as it has when
    /// only conductances changed, and its pressures are where the next solve
    /// starts from. Memory is needed for one network only. Pressures that were imposed beside
    /// those of the walls are imposed again.
    ///
    /// # Errors
    /// As [`Flow::with_imposed`].
    pub fn renew(
        self,
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<Flow, PfvError> {
        let (solver, imposed) = (self.backend().clone(), self.imposed_pressures().to_vec());
        let (pressures, reusable) = self.retire();
        let assembled = Assembled::with_imposed(position, radius, bounds, fluid, &imposed)?;
        let mut flow = assembled.analyze(solver, reusable)?.factor()?;
        flow.transfer_pressures(&pressures);
        Ok(flow)
    }
}
