//! The flow through one network: the pressures of its pores and the forces on its spheres.

use std::fmt;

use super::extrapolation::Extrapolation;
use super::geometry_update::{GeometryDegradation, GeometryUpdate};
use super::gradient_load::GradientLoad;
use super::packing_check::{check_tolerance, require_finite, require_length};
use super::pore_pressures::PorePressures;
use super::pressure_solver::{PressureProblem, PressureSolver};
use super::terms::{StepTerms, Terms};
use super::{
    BuildTimes, Fluid, ImposedPressure, Network, NetworkConditions, Operators, PfvError,
    ReusableAnalysis, TransferSource,
};
use crate::parallel::{SERIAL, for_each};
use crate::solver::{Factor, Iterations, Solver};
use crate::{Aabb, Vec3};

/// Pore pressures of a packing, and the fluid's forces on it.
///
/// # What the pressure is
/// The equations have no gravity: pressures are those in excess of the hydrostatic one (or
/// total ones where nothing has weight). Forces follow from them, so that they hold no buoyancy
/// unless the fluid is given a weight ([`Flow::set_weight`]).
///
/// # Order of spheres
/// Spheres are numbered as in the arrays that the flow was built of.
///
/// ```
/// use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
/// use dempfv::solver::SolverKind;
/// use dempfv::{Aabb, Vec3, WallId};
///
/// // One sphere in a box, 1 Pa at the bottom and 0 at the top.
/// let mut boundary = Boundary::default();
/// boundary.pressure[WallId::YMin] = Some(1.0);
/// boundary.pressure[WallId::YMax] = Some(0.0);
/// let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
/// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
/// let mut flow = Flow::new(&[Vec3::repeat(0.5)], &[0.4], bounds, &fluid, SolverKind::default())?;
/// flow.solve_static()?;
/// assert!(flow.force()[0].y > 0.0);
/// assert!(flow.permeability(WallId::YMin).is_some_and(|k| k.value > 0.0));
/// # Ok::<(), dempfv::Error>(())
/// ```
pub struct Flow {
    pub(super) network: Network,
    pub(super) operators: Operators,
    pub(super) fluid: Fluid,
    pub(super) radius: Vec<f64>,
    pub(super) conditions: NetworkConditions,
    pub(super) backend: Solver,
    pub(super) build_times: BuildTimes,
    pub(super) analysis_reused: bool,
    /// State: what a checkpoint holds.
    pub(super) extrapolation: Extrapolation,
    pub(super) solver: PressureSolver,
    /// Once the geometry has been updated.
    pub(super) geometry: Option<Box<GeometryUpdate>>,
    pub(super) pressures: PorePressures,
    pub(super) volume_rate: Vec<f64>,
    pub(super) terms: Terms,
    pub(super) force: Vec<Vec3>,
    pub(super) wall_force: [Vec3; 6],
    /// Imposed pressures have changed since the last solve.
    pub(super) stale_imposed: bool,
    /// Of the fluid per volume (N/m³).
    pub(super) weight: Vec3,
    /// What it lifts each sphere by (N); empty without weight.
    pub(super) buoyancy: Vec<Vec3>,
    /// The mean pressure gradient in a periodic cell.
    pub(super) gradient: GradientLoad,
}

/// What a flow is made of.
pub(super) struct FlowParts {
    pub network: Network,
    pub operators: Operators,
    /// `None` when every pore has an imposed pressure.
    pub factor: Option<Box<dyn Factor>>,
    pub backend: Solver,
    pub radius: Vec<f64>,
    pub fluid: Fluid,
    pub conditions: NetworkConditions,
    pub terms: Terms,
    pub times: BuildTimes,
    pub analysis_reused: bool,
}

/// Where the unknowns of the matrix lie (m).
pub(super) fn unknown_points(network: &Network, operators: &Operators) -> Vec<[f64; 3]> {
    operators.pore_of.iter().map(|&i| network.center[i as usize].into()).collect()
}

impl Flow {
    pub(super) fn of_parts(parts: FlowParts) -> Flow {
        let FlowParts {
            network, operators, factor, backend, radius, fluid, conditions, terms, ..
        } = parts;
        let (pores, unknowns) = (network.pores(), operators.unknowns());
        let mut pressures = PorePressures::at_rest(&operators);
        let mut extrapolation = Extrapolation::at_rest(unknowns, pressures.reference);
        if operators.storage().is_some() {
            // It is where the first step begins, not only where the first solve does.
            let mean = operators.conditions().mean_pressure();
            extrapolation.now.fill(mean - pressures.reference);
            pressures.spread(&operators, &extrapolation.now);
        }
        Flow {
            fluid,
            conditions,
            backend,
            build_times: parts.times,
            analysis_reused: parts.analysis_reused,
            extrapolation,
            solver: PressureSolver::new(factor, &operators),
            geometry: None,
            pressures,
            volume_rate: vec![0.0; pores],
            terms,
            force: vec![Vec3::zeros(); radius.len()],
            wall_force: [Vec3::zeros(); 6],
            stale_imposed: false,
            weight: Vec3::zeros(),
            buoyancy: vec![],
            gradient: GradientLoad::default(),
            radius,
            network,
            operators,
        }
    }

    /// What a network that takes this one's place may use: the pressures, and
    /// the factor. All else is freed.
    pub fn retire(self) -> (TransferSource, Option<ReusableAnalysis>) {
        let (pressures, reusable, _) = self.retire_with_terms();
        (pressures, reusable)
    }

    /// The same, and the terms that store fluid.
    pub(super) fn retire_with_terms(
        mut self,
    ) -> (TransferSource, Option<ReusableAnalysis>, StepTerms) {
        if let Some(geometry) = self.geometry.take() {
            // After a restart, these are all that is known.
            self.network.center = geometry.built_center();
        }
        let points = unknown_points(&self.network, &self.operators);
        let time_step = self.time_step().unwrap_or_default();
        let relative = &self.pressures.relative;
        let content = self.operators.storage().map(|s| (s.content(relative), s.whole_capacity()));
        let (around, matrix) = self.operators.retire();
        let pressures = TransferSource::new(self.network, around, self.pressures, content);
        let backend = self.backend;
        let reusable = |factor| ReusableAnalysis::new(factor, backend, matrix, points);
        let terms = StepTerms { terms: self.terms.into_storing(), time_step };
        (pressures, self.solver.into_factor().map(reusable), terms)
    }

    /// Takes the pressures of the network that this one replaces: as the
    /// starting point of the next solve. Those of other spheres are ignored.
    ///
    /// Where pores store fluid, these pressures are where the next step begins: all free ones are
    /// then raised or lowered by the same, so that the pores together store what they did.
    pub fn transfer_pressures(&mut self, from: &TransferSource) {
        self.extrapolation.restart();
        self.solver.statistics.solved = false;
        let Flow { network, operators, extrapolation, pressures, .. } = self;
        from.write(network, operators, pressures.reference, &mut extrapolation.now);
        self.spread_pressures();
        self.keep_content(from);
    }

    /// Gives the pores the pressures of the unknowns.
    pub(super) fn spread_pressures(&mut self) {
        self.pressures.spread(&self.operators, &self.extrapolation.now);
    }

    /// The network.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Its operators.
    pub fn operators(&self) -> &Operators {
        &self.operators
    }

    /// The fluid that the network was built for.
    pub fn fluid(&self) -> &Fluid {
        &self.fluid
    }

    /// The pressures that are imposed on pores of choice.
    pub fn imposed_pressures(&self) -> &[ImposedPressure] {
        &self.conditions.imposed
    }

    /// The solver that the flow was built with.
    pub fn backend(&self) -> &Solver {
        &self.backend
    }

    /// The operators, and what solves.
    pub(super) fn operators_and_solver(&mut self) -> (&Operators, &mut PressureSolver) {
        (&self.operators, &mut self.solver)
    }

    /// True when both have a matrix of the same pattern.
    pub fn has_pattern_of(&self, other: &Flow) -> bool {
        let (a, b) = (&self.operators.matrix, &other.operators.matrix);
        a.col_ptr == b.col_ptr && a.row_idx == b.row_idx
    }

    /// True when the symbolic analysis was that of an earlier network.
    pub fn analysis_reused(&self) -> bool {
        self.analysis_reused
    }

    /// Pressures and forces for moving spheres and walls (eqs. 5 to 10 of
    /// Caulk 2020): one velocity per sphere (m/s), and one for each wall along its axis.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for velocities that are not one per sphere or not finite;
    /// [`PfvError::Solver`] when a solve fails or the first residual after a factorization is
    /// too large; [`PfvError::PressureNotFinite`].
    pub fn solve(&mut self, velocity: &[Vec3], wall_velocity: &[f64; 6]) -> Result<(), PfvError> {
        require_finite("velocity", velocity)?;
        if let Some(index) = wall_velocity.iter().position(|v| !v.is_finite()) {
            return Err(PfvError::invalid("wall_velocity", index, "is not finite"));
        }
        self.update_volume_rate(velocity, wall_velocity)?;
        self.update_pressure()?;
        self.update_force();
        Ok(())
    }

    /// Pressures and forces for spheres and walls at rest.
    ///
    /// # Errors
    /// As [`Flow::solve`].
    pub fn solve_static(&mut self) -> Result<(), PfvError> {
        self.volume_rate.fill(0.0);
        self.update_pressure()?;
        self.update_force();
        Ok(())
    }

    /// First third of [`Flow::solve`]: `V̇ = E v`. What is not finite is refused by the second.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when there is not one velocity per sphere.
    pub fn update_volume_rate(
        &mut self,
        velocity: &[Vec3],
        wall_velocity: &[f64; 6],
    ) -> Result<(), PfvError> {
        self.require_one_per_sphere("velocity", velocity.len())?;
        self.operators.evaluate_volume_rate(velocity, wall_velocity, &mut self.volume_rate);
        Ok(())
    }

    /// The same in a periodic cell whose volume grows by so much of itself in a second (1/s), with the
    /// spheres' velocities relative to its mean field.
    ///
    /// # Errors
    /// As [`Flow::update_volume_rate`].
    pub fn update_volume_rate_in_cell(
        &mut self,
        velocity: &[Vec3],
        dilation: f64,
    ) -> Result<(), PfvError> {
        self.update_volume_rate(velocity, &[0.0; 6])?;
        if dilation != 0.0 {
            let volume = &self.network.volume;
            for_each(&mut self.volume_rate, &|i, rate| *rate += dilation * volume[i]);
        }
        Ok(())
    }

    /// Second third of [`Flow::solve`]: `G p = -V̇ + Q`, solved for the change
    /// from what the last pressures predict: `G δ = -V̇ + Q - G p`, with the right-hand
    /// side evaluated throat by throat.
    ///
    /// Where conductances span many decades the diagonal of the matrix has no
    /// digits left for the small ones, and a solution loses that share of the
    /// fluid: 7e-10 of it with 20,000 spheres. Of a change, that is little. It
    /// is repeated until what enters from the pores with an imposed pressure is what the
    /// pores swallow and the estimated error of the pressures is small, both to
    /// [`Flow::set_tolerance`]; four times at most.
    ///
    /// # Errors
    /// As [`Flow::solve`].
    pub fn update_pressure(&mut self) -> Result<(), PfvError> {
        let Flow {
            network,
            operators,
            volume_rate,
            terms,
            extrapolation,
            pressures,
            solver,
            stale_imposed,
            gradient,
            ..
        } = self;
        operators.begin_storing(pressures.reference, &pressures.relative);
        if std::mem::take(stale_imposed) {
            operators.write_imposed(pressures.reference, &mut pressures.relative);
        }
        let demand = terms.demand(volume_rate);
        operators.sealed_pores().check(network, demand, gradient.through)?;
        let PorePressures { reference, relative: pressure, .. } = pressures;
        let reference = *reference;
        let least = gradient.through;
        let problem =
            PressureProblem { operators, demand, least, extrapolation, pressure, reference };
        let solved = if operators.unknowns() < SERIAL {
            solver.solve(problem)
        } else {
            // A thread from outside waits for the pool once, not for each loop.
            rayon::scope(|_| solver.solve(problem))
        };
        terms.settle(operators.storage(), &pressures.relative);
        pressures.update_absolute();
        solved
    }

    /// As [`Flow::update_pressure`] where the network has moved on from its
    /// factor ([`Flow::update_geometry`]): conjugate gradients preconditioned by the
    /// factor ([`ConjugateGradients`](crate::solver::ConjugateGradients)), from what the last
    /// pressures predict, until the estimated error
    /// is at most `tolerance`. [`Iterations::error`] is larger where they come
    /// to no end.
    ///
    /// # Errors
    /// When an application fails, or a pressure is not finite; [`PfvError::InvalidInput`] for a
    /// tolerance that is not between 0 and 1.
    pub fn iterate(&mut self, tolerance: f64) -> Result<Iterations, PfvError> {
        check_tolerance(tolerance)?;
        let Flow {
            network,
            operators,
            volume_rate,
            terms,
            extrapolation,
            pressures,
            solver,
            geometry,
            stale_imposed,
            gradient,
            ..
        } = self;
        operators.begin_storing(pressures.reference, &pressures.relative);
        if std::mem::take(stale_imposed) {
            operators.write_imposed(pressures.reference, &mut pressures.relative);
        }
        let demand = terms.demand(volume_rate);
        operators.sealed_pores().check(network, demand, gradient.through)?;
        let PorePressures { reference, relative: pressure, .. } = pressures;
        let reference = *reference;
        let least = gradient.through;
        let problem =
            PressureProblem { operators, demand, least, extrapolation, pressure, reference };
        let weakened = geometry.as_ref().map_or(&[][..], |g| g.weakened());
        let iterations = solver.iterate(problem, weakened, tolerance);
        terms.settle(operators.storage(), &pressures.relative);
        pressures.update_absolute();
        iterations
    }

    /// Last third of [`Flow::solve`]: `f = F p`, and buoyancy where the fluid has weight
    /// ([`Flow::set_weight`]).
    pub fn update_force(&mut self) {
        let Flow { network, operators, pressures, force, wall_force, buoyancy, gradient, .. } =
            self;
        operators.evaluate_forces(&pressures.relative, force, wall_force);
        pressures.push_walls(&network.bounds, wall_force);
        for (force, buoyancy) in force.iter_mut().zip(&*buoyancy) {
            *force += buoyancy;
        }
        gradient.add_to(force);
    }

    /// Moves the spheres to `position` (m) and the walls to `bounds`: centres,
    /// volumes, conductances and the operators are those of the moment from
    /// now on. The triangulation and the factor remain those that the flow was
    /// built with, so [`Flow::iterate`] is what solves. Allocates in the first
    /// call only.
    ///
    /// # Errors
    /// As [`Network::volumes_at`].
    pub fn update_geometry(
        &mut self,
        position: &[Vec3],
        bounds: &Aabb,
    ) -> Result<GeometryDegradation, PfvError> {
        self.network.check_vertices(position, bounds)?;
        let Flow { network, operators, geometry, radius, fluid, terms, .. } = self;
        let geometry =
            geometry.get_or_insert_with(|| Box::new(GeometryUpdate::new(network, operators)));
        Ok(geometry.run(network, operators, (position, radius), bounds, (fluid, terms)))
    }

    pub(super) fn require_one_per_sphere(
        &self,
        argument: &'static str,
        found: usize,
    ) -> Result<(), PfvError> {
        require_length(argument, found, self.radius.len(), "spheres")
    }

    /// Sets what a solve may leave: of the imbalance of fluid mass (relative to
    /// what flows), and of the estimated error of the pressures (relative to the
    /// largest). At first 1e-11. A larger one may spare a second solve per step.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for one that is not between 0 and 1.
    pub fn set_tolerance(&mut self, tolerance: f64) -> Result<(), PfvError> {
        check_tolerance(tolerance)?;
        self.solver.tolerance = tolerance;
        Ok(())
    }

    /// What a solve may leave ([`Flow::set_tolerance`]).
    pub fn tolerance(&self) -> f64 {
        self.solver.tolerance
    }

    /// The pressures that the next solve goes on from: all that a checkpoint needs of a flow
    /// that can be built again.
    pub fn extrapolation(&self) -> &Extrapolation {
        &self.extrapolation
    }

    /// Goes on from the pressures of an earlier flow through the same network,
    /// so that the next solve has the same bits; fluxes are those of pores that
    /// grow at the rates given (m³/s). Values of another number of pores are
    /// ignored: where another condition was imposed in between, there are none.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a rate that is not finite.
    pub fn restore_pressures(
        &mut self,
        extrapolation: &Extrapolation,
        volume_rate: &[f64],
    ) -> Result<(), PfvError> {
        if let Some(index) = volume_rate.iter().position(|v| !v.is_finite()) {
            return Err(PfvError::invalid("volume_rate", index, "is not finite"));
        }
        if volume_rate.len() == self.volume_rate.len() {
            self.volume_rate.copy_from_slice(volume_rate);
        }
        if extrapolation.unknowns() == self.extrapolation.unknowns() {
            self.extrapolation.clone_from(extrapolation);
            self.extrapolation.measure_from(self.pressures.reference);
            self.solver.statistics.solved = self.extrapolation.is_solution();
            self.spread_pressures();
            self.update_force();
        }
        Ok(())
    }

    /// Forgets what is known of the last solver's corrections: the restored pressures are those
    /// of another one.
    pub(crate) fn forget_gain(&mut self) {
        self.extrapolation.forget_gain();
    }
}

impl fmt::Debug for Flow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Flow")
            .field("spheres", &self.radius.len())
            .field("pores", &self.network.pores())
            .field("unknowns", &self.operators.unknowns())
            .field("fluid", &self.fluid)
            .field("backend", &self.backend)
            .field("statistics", &self.solver.statistics)
            .finish_non_exhaustive()
    }
}
