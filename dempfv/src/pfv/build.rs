//! From a packing to a [`Flow`], phase by phase: whoever builds one may look
//! up between two phases, and stop.

use std::fmt;
use std::time::Instant;

use super::flow::{FlowParts, unknown_points};
use super::frame::Frame;
use super::packing_check::check_time_step;
use super::storage::Storage;
use super::terms::{StepTerms, Terms};
use super::{
    BuildTimes, Flow, Fluid, ImposedPressure, Network, NetworkConditions, Operators, PfvError,
    PoreConditions, ReusableAnalysis,
};
use crate::solver::{Backend, Factor, Solver, Symbolic};
use crate::{Aabb, Cell, Vec3};
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const PORE_FLOW: Effect = Effect {
    name: "pore flow",
    family: Family::Fluid,
    equation: "Σ_j g_ij (p_j − p_i) = dV_i/dt, g = A_f (2 R_h)² / (8 μ l)",
    source: "B. Chareyre et al.: Transp. Porous Media 92 (2012); R. Caulk et al.: Comput. Phys. Commun. 248 (2020)",
    keys: &[
        EffectKey { key: "viscosity in [fluid]", unit: "Pa·s", default: "required" },
        EffectKey { key: "pressure in [fluid]", unit: "Pa", default: "no flow through walls" },
    ],
    needs: "the regular triangulation, and a solver",
    test: "dempfv/tests/pfv_network.rs, dempfv/tests/pfv_flow.rs, make yade-test",
};

/// First phase: a network and its operators. What only served to make them
/// is gone.
#[derive(Debug)]
pub struct Assembled {
    network: Network,
    operators: Operators,
    radius: Vec<f64>,
    fluid: Fluid,
    conditions: NetworkConditions,
    terms: Terms,
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
        Assembled::with_terms(position, radius, bounds, fluid, imposed, StepTerms::default())
    }

    /// As [`Assembled::with_imposed`], with terms in the balance of the pores. Where one of them
    /// stores fluid, pores without a path to an imposed pressure need none, and the pressures
    /// begin at the mean of the imposed ones.
    ///
    /// # Errors
    /// As [`Assembled::with_imposed`]; where a term stores fluid, [`PfvError::InvalidInput`] for
    /// a time step that is not positive and finite, and for a capacity that is not finite or below 0.
    pub fn with_terms(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        imposed: &[ImposedPressure],
        terms: StepTerms,
    ) -> Result<Assembled, PfvError> {
        let conditions =
            NetworkConditions { imposed: imposed.to_vec(), ..NetworkConditions::default() };
        Assembled::with_conditions(position, radius, bounds, fluid, conditions, terms)
    }

    /// As [`Assembled::with_terms`], with conditions of any kind.
    ///
    /// # Errors
    /// As [`Assembled::with_terms`]; [`PfvError::InvalidInput`] for rules of conductances with a
    /// number that is not positive and finite, for a selection that holds no pore, for profiles that
    /// are no function of the coordinate, and for a profile at a wall that imposes no pressure.
    pub fn with_conditions(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        conditions: NetworkConditions,
        StepTerms { terms, time_step }: StepTerms,
    ) -> Result<Assembled, PfvError> {
        let terms = Terms::new(terms);
        if terms.store() {
            check_time_step(time_step)?;
        }
        let start = Instant::now();
        let (mut network, derivatives) = Network::new(position, radius, bounds, fluid)?;
        let of_pores = conditions.apply(&mut network, position, radius, fluid)?;
        let storage = match terms.store() {
            true => {
                let mut void = vec![0.0; network.pores()];
                network.write_void_volumes(&Frame::new(position, radius, &bounds), &mut void);
                Some(storage(void, &terms, time_step)?)
            }
            false => None,
        };
        let operators = Operators::assemble(&network, derivatives, of_pores, storage);
        let times = BuildTimes { network: start.elapsed(), ..BuildTimes::default() };
        Ok(Assembled {
            network,
            operators,
            radius: radius.to_vec(),
            fluid: *fluid,
            conditions,
            terms,
            times,
        })
    }

    /// Triangulates spheres in a periodic cell and builds the operators; see [`Network::in_cell`],
    /// and [`Assembled::with_terms`] for the terms.
    ///
    /// # Errors
    /// As [`Network::in_cell`] and [`Assembled::with_terms`].
    pub fn in_cell(
        position: &[Vec3],
        radius: &[f64],
        cell: &Cell,
        fluid: &Fluid,
        StepTerms { terms, time_step }: StepTerms,
    ) -> Result<Assembled, PfvError> {
        let terms = Terms::new(terms);
        if terms.store() {
            check_time_step(time_step)?;
        }
        let start = Instant::now();
        let (network, derivatives) = Network::in_cell(position, radius, cell, fluid)?;
        let conditions = PoreConditions::of_walls(&network, &fluid.boundary);
        let void = network.periodic().filter(|_| terms.store()).map(|p| p.void.clone());
        let storage = void.map(|void| storage(void, &terms, time_step)).transpose()?;
        let operators = Operators::assemble(&network, derivatives, conditions, storage);
        let times = BuildTimes { network: start.elapsed(), ..BuildTimes::default() };
        Ok(Assembled {
            network,
            operators,
            radius: radius.to_vec(),
            fluid: *fluid,
            conditions: NetworkConditions::default(),
            terms,
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

/// What the pores of a network store.
fn storage(void: Vec<f64>, terms: &Terms, time_step: f64) -> Result<Storage, PfvError> {
    let mut capacity = vec![0.0; void.len()];
    terms.write_capacity(&void, &mut capacity);
    match capacity.iter().position(|s| !(*s >= 0.0 && s.is_finite())) {
        None => Ok(Storage::new(void, capacity, time_step)),
        Some(pore) => {
            let problem = format!("{} m³/Pa; it must be finite, 0 or more", capacity[pore]);
            Err(PfvError::invalid("capacity", pore, problem))
        }
    }
}

impl Analyzed {
    /// Last phase: factors the matrix. The bits do not depend on whether the
    /// analysis is a new one.
    ///
    /// # Errors
    /// [`PfvError::Solver`] as [`Symbolic::factor`].
    pub fn factor(self) -> Result<Flow, PfvError> {
        let Assembled { network, operators, radius, fluid, conditions, terms, mut times } =
            self.assembled;
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
            conditions,
            terms,
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

    /// The flow between spheres in a periodic cell; see [`Network::in_cell`]. A mean pressure
    /// gradient drives it ([`Flow::set_pressure_gradient`]). Where nothing stores fluid, pressures
    /// are known but for a constant: one pore has zero.
    ///
    /// ```
    /// use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
    /// use dempfv::solver::SolverKind;
    /// use dempfv::{Cell, Vec3};
    ///
    /// // Four by four by four spheres that touch, on a simple cubic lattice.
    /// let place = |k: usize| Vec3::new((k % 4) as f64, (k / 4 % 4) as f64, (k / 16) as f64);
    /// let x: Vec<Vec3> = (0..64).map(place).collect();
    /// let fluid = Fluid {
    ///     viscosity: 1e-3,
    ///     slip_walls: true,
    ///     clamp: Clamp::None,
    ///     boundary: Boundary::default(),
    /// };
    /// let cell = Cell::of_size(Vec3::repeat(4.0))?;
    /// let mut flow = Flow::in_cell(&x, &[0.5; 64], &cell, &fluid, SolverKind::default())?;
    /// flow.set_pressure_gradient(Vec3::new(-1.0, 0.0, 0.0))?;
    /// flow.solve_static()?;
    /// // What the gradient puts on the whole cell the spheres carry.
    /// let drag: Vec3 = flow.force().iter().sum();
    /// assert!((drag - Vec3::new(64.0, 0.0, 0.0)).norm() < 1e-10);
    /// assert!(flow.mean_velocity().is_some_and(|velocity| velocity.x > 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Network::in_cell`], and [`PfvError::Solver`] when the factorization fails.
    pub fn in_cell(
        position: &[Vec3],
        radius: &[f64],
        cell: &Cell,
        fluid: &Fluid,
        solver: impl Into<Solver>,
    ) -> Result<Flow, PfvError> {
        let terms = StepTerms::default();
        Assembled::in_cell(position, radius, cell, fluid, terms)?.analyze(solver, None)?.factor()
    }

    /// As [`Flow::new`], in place of a flow that is no longer needed: its
    /// analysis serves again if the matrix has the same pattern, as it has when
    /// only conductances changed, and its pressures are where the next solve
    /// starts from. Memory is needed for one network only. Conditions beside the pressures of the
    /// walls hold again, and terms that store fluid remain.
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
        let (solver, conditions) = (self.backend().clone(), self.conditions().clone());
        let (pressures, reusable, terms) = self.retire_with_terms();
        let assembled =
            Assembled::with_conditions(position, radius, bounds, fluid, conditions, terms)?;
        let mut flow = assembled.analyze(solver, reusable)?.factor()?;
        flow.transfer_pressures(&pressures);
        Ok(flow)
    }
}
