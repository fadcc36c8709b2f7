//! The flow through one network: operators, factor and the current pressures.

use super::build::{self, Assembled, BuildTimes, Spare};
use super::extrapolation::{Extrapolation, Sizes};
use super::geometry_update::Follower;
use super::iterate::Gradients;
use super::operators::NetVolumeRate;
use super::transfer::TransferSource;
use super::{Fluid, Network, Operators, PfvError};
use crate::parallel::{SERIAL, parts};
use crate::solver::{Factor, Placement, SolverKind};
use crate::{Aabb, Result, Vec3, WallId};

/// What a solve may leave, unless told otherwise.
const TOLERANCE: f64 = 1e-11;
/// How often a solution is corrected at most, after the first time.
const REFINEMENTS: usize = 3;

/// Pore pressures of a packing, and the fluid's forces on it.
///
/// ```
/// use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
/// use dempfv::solver::SolverKind;
/// use dempfv::{Aabb, Vec3, WallId};
///
/// // One sphere in a box, 1 Pa at the bottom and 0 at the top.
/// let mut boundary = Boundary::default();
/// boundary.pressure[WallId::YMin.index()] = Some(1.0);
/// boundary.pressure[WallId::YMax.index()] = Some(0.0);
/// let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
/// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
/// let mut flow = Flow::new(&[Vec3::repeat(0.5)], &[0.4], bounds, &fluid, SolverKind::default())?;
/// flow.solve_static()?;
/// assert!(flow.force()[0].y > 0.0);
/// # Ok::<(), dempfv::Error>(())
/// ```
pub struct Flow {
    /// The pore network.
    pub network: Network,
    /// Its operators.
    pub operators: Operators,
    /// `None` when every pore has an imposed pressure.
    pub(super) factor: Option<Box<dyn Factor>>,
    solver: SolverKind,
    analysis_reused: bool,
    residual: Option<f64>,
    pub(super) imbalance: f64,
    tolerance: f64,
    build_times: BuildTimes,
    /// Once the network has followed its spheres.
    pub(super) follower: Option<Box<Follower>>,
    pub(super) gradients: Box<Gradients>,
    pub(super) rhs: Vec<f64>,
    pub(super) extrapolation: Extrapolation,
    pub(super) correction: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) volume_rate: Vec<f64>,
    force: Vec<Vec3>,
    wall_force: [Vec3; 6],
}

/// Volume rates and pressures of a motion that is only tried out.
pub(super) struct DragScratch {
    volume_rate: Vec<f64>,
    /// Zero where the pressure is imposed.
    pressure: Vec<f64>,
}

impl DragScratch {
    pub fn new(network: &Network) -> DragScratch {
        let zeros = vec![0.0; network.pores()];
        DragScratch { volume_rate: zeros.clone(), pressure: zeros }
    }
}

/// A measured permeability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Permeability {
    /// Intrinsic permeability `k = Q μ L / (A Δp)` (m²).
    pub value: f64,
    /// Flux along the axis (m³/s).
    pub flux: f64,
    /// What enters less what leaves, relative to the flux (1).
    pub imbalance: f64,
}

impl Flow {
    /// Builds the network of a packing and factors its conductance matrix.
    ///
    /// # Errors
    /// As [`Network::new`] and [`Operators::new`], and when the factorization
    /// fails.
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        solver: SolverKind,
    ) -> Result<Flow> {
        Assembled::new(position, radius, bounds, fluid)?.analyze(solver, None)?.factor()
    }

    /// As [`Flow::new`], in place of a flow that is no longer needed: its
    /// analysis serves again if the matrix has the same pattern, as it has when
    /// only conductances changed, and its pressures are where the next solve
    /// starts from. Memory is needed for one network only.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn renew(
        self,
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
    ) -> Result<Flow> {
        let solver = self.solver;
        let (carried, spare) = self.retire();
        let assembled = Assembled::new(position, radius, bounds, fluid)?;
        let mut flow = assembled.analyze(solver, spare)?.factor()?;
        flow.carry_over(&carried);
        Ok(flow)
    }

    pub(super) fn of_parts(
        network: Network,
        operators: Operators,
        factor: Option<Box<dyn Factor>>,
        solver: SolverKind,
        build_times: BuildTimes,
        analysis_reused: bool,
    ) -> Flow {
        let (pores, unknowns) = (network.pores(), operators.unknowns());
        let mut pressure = vec![0.0; pores];
        operators.pressures(&vec![0.0; unknowns], &mut pressure);
        Flow {
            factor,
            solver,
            analysis_reused,
            residual: None,
            imbalance: 0.0,
            tolerance: TOLERANCE,
            build_times,
            follower: None,
            gradients: Box::default(),
            rhs: vec![0.0; unknowns],
            extrapolation: Extrapolation::at_rest(unknowns),
            correction: vec![0.0; unknowns],
            pressure,
            volume_rate: vec![0.0; pores],
            force: vec![Vec3::zeros(); network.tessellation.spheres],
            wall_force: [Vec3::zeros(); 6],
            network,
            operators,
        }
    }

    /// What a network that takes this one's place may use: the pressures, and
    /// the factor. All else is freed.
    pub fn retire(mut self) -> (TransferSource, Option<Spare>) {
        if let Some(follower) = self.follower.take() {
            // After a restart, these are all that is known.
            self.network.center = follower.built_center();
        }
        let places = build::places(&self.network, &self.operators);
        let (around, matrix) = self.operators.retire();
        let carried = TransferSource::new(self.network, around, self.pressure);
        (carried, self.factor.map(|factor| Spare::new(factor, self.solver, matrix, places)))
    }

    /// Takes the pressures of the network that this one replaces: as the
    /// starting point of the next solve.
    pub fn carry_over(&mut self, from: &TransferSource) {
        self.extrapolation.begin();
        from.write(&self.network, &self.operators, &mut self.extrapolation.now);
        self.operators.pressures(&self.extrapolation.now, &mut self.pressure);
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
    /// Caulk 2020): velocities in m/s, a wall's along its axis.
    ///
    /// # Errors
    /// When a solve fails, the first residual after a factorization is too
    /// large, or a pressure is not finite.
    pub fn solve(&mut self, velocity: &[Vec3], wall_velocity: &[f64; 6]) -> Result<()> {
        self.update_volume_rate(velocity, wall_velocity);
        self.update_pressure()?;
        self.update_force();
        Ok(())
    }

    /// Pressures and forces for spheres and walls at rest.
    ///
    /// # Errors
    /// As [`Flow::solve`].
    pub fn solve_static(&mut self) -> Result<()> {
        self.volume_rate.fill(0.0);
        self.update_pressure()?;
        self.update_force();
        Ok(())
    }

    /// First third of [`Flow::solve`]: `V̇ = E v`.
    pub fn update_volume_rate(&mut self, velocity: &[Vec3], wall_velocity: &[f64; 6]) {
        self.operators.volume_rate(velocity, wall_velocity, &mut self.volume_rate);
    }

    /// Second third of [`Flow::solve`]: `G p = -V̇ + Q`, solved for the change
    /// from what the last pressures predict: `G δ = -V̇ + Q - G p`, with the right-hand
    /// side evaluated throat by throat.
    ///
    /// Where conductances span many decades the diagonal of the matrix has no
    /// digits left for the small ones, and a solution loses that share of the
    /// fluid: 7e-10 of it with 20,000 spheres. Of a change, that is little. It
    /// is repeated until what flows through the walls is what the pores swallow
    /// and the estimated error of the pressures is small, both to
    /// [`Flow::set_tolerance`].
    ///
    /// # Errors
    /// As [`Flow::solve`].
    pub fn update_pressure(&mut self) -> Result<()> {
        if self.operators.unknowns() < SERIAL {
            self.solve_pressure()
        } else {
            // A thread from outside waits for the pool once, not for each loop.
            rayon::scope(|_| self.solve_pressure())
        }
    }

    fn solve_pressure(&mut self) -> Result<()> {
        self.extrapolation.predict(&self.operators.pore_of, &mut self.pressure);
        let growth = NetVolumeRate::of(&self.volume_rate);
        let check = self.extrapolation.gain_is_due();
        let (mut last, mut largest) = (0.0, 0.0);
        for k in 0..=REFINEMENTS {
            let Sizes { change, pressure } = self.correct_pressure()?;
            largest = pressure;
            self.imbalance = growth.imbalance(&self.flux());
            if k == 1 {
                self.extrapolation.gained(change, last);
            }
            last = change;
            let error = self.extrapolation.gain() * change;
            let small = error <= self.tolerance * largest;
            if self.imbalance <= self.tolerance && small && (k > 0 || !check) {
                break;
            }
        }
        self.extrapolation.solved();
        // With nothing unknown, nothing has been looked at.
        if self.factor.is_some() && largest.is_finite() { Ok(()) } else { self.check_pressure() }
    }

    pub(super) fn check_pressure(&self) -> Result<()> {
        let finite = |part: &[f64]| part.iter().all(|p| p.is_finite());
        if parts(&self.pressure, finite, true, |a, b| a && b) {
            return Ok(());
        }
        let pore = self.pressure.iter().position(|p| !p.is_finite()).unwrap_or(0);
        Err(PfvError::PressureNotFinite { pore: pore as u32 }.into())
    }

    /// Sets what a solve may leave: of the imbalance of fluid mass (relative to
    /// what flows), and of the estimated error of the pressures (relative to the
    /// largest). At first 1e-11. A larger one may spare a second solve per step.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }

    /// What a solve may leave ([`Flow::set_tolerance`]).
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// One solve for the change of the pressures.
    fn correct_pressure(&mut self) -> Result<Sizes> {
        let Flow { operators, extrapolation, correction, pressure, volume_rate, rhs, .. } = self;
        let Some(factor) = &mut self.factor else { return Ok(Sizes::default()) };
        operators.residual(pressure, volume_rate, rhs);
        if self.residual.is_none() {
            self.residual = Some(factor.correct_checked(&operators.matrix, rhs, correction)?);
        } else {
            factor.correct(rhs, correction)?;
        }
        Ok(extrapolation.correct(correction, &operators.pore_of, pressure))
    }

    /// The pressures that the next solve goes on from.
    pub fn extrapolation(&self) -> &Extrapolation {
        &self.extrapolation
    }

    /// Goes on from the pressures of an earlier flow through the same network,
    /// so that the next solve has the same bits; fluxes are those of pores that
    /// grow at the rates given (m³/s). Values of another number of pores are
    /// ignored.
    pub fn resume(&mut self, extrapolation: &Extrapolation, volume_rate: &[f64]) {
        if volume_rate.len() == self.volume_rate.len() {
            self.volume_rate.copy_from_slice(volume_rate);
        }
        if extrapolation.unknowns() == self.extrapolation.unknowns() {
            self.extrapolation.clone_from(extrapolation);
            self.operators.pressures(&self.extrapolation.now, &mut self.pressure);
            self.update_force();
        }
    }

    /// Last third of [`Flow::solve`]: `f = F p`.
    pub fn update_force(&mut self) {
        self.operators.forces(&self.pressure, &mut self.force, &mut self.wall_force);
    }

    /// How the fluid resists a wall's motion while the spheres stand still: the
    /// force on the wall against its velocity, per velocity (N·s/m). Zero where
    /// the pressure of all pores at the wall is imposed. Takes a solve.
    ///
    /// # Errors
    /// As [`Flow::solve`].
    pub fn wall_resistance(&mut self, wall: WallId) -> Result<f64> {
        let mut force = vec![Vec3::zeros(); self.network.tessellation.spheres];
        self.wall_drag(wall, &mut DragScratch::new(&self.network), &mut force)
    }

    /// [`Flow::wall_resistance`], and the force on each sphere (N) when the
    /// wall moves at 1 m/s.
    pub(super) fn wall_drag(
        &mut self,
        wall: WallId,
        scratch: &mut DragScratch,
        force: &mut [Vec3],
    ) -> Result<f64> {
        let mut speed = [0.0; 6];
        speed[wall.index()] = 1.0;
        let at_rest = vec![Vec3::zeros(); force.len()];
        let wall_force = self.drag(&at_rest, &speed, scratch, force)?;
        Ok((-wall_force[wall.index()][wall.axis()]).max(0.0))
    }

    /// The fluid's force on spheres (N) and walls (returned) that move, the
    /// imposed pressures being zero: `f = -F G⁻¹ E v`. Leaves the pressures of
    /// the flow as they are. Takes a solve.
    pub(super) fn drag(
        &mut self,
        velocity: &[Vec3],
        wall_velocity: &[f64; 6],
        scratch: &mut DragScratch,
        force: &mut [Vec3],
    ) -> Result<[Vec3; 6]> {
        let Flow { operators, correction, rhs, factor, .. } = self;
        let mut wall_force = [Vec3::zeros(); 6];
        let Some(factor) = factor else {
            force.fill(Vec3::zeros());
            return Ok(wall_force);
        };
        let DragScratch { volume_rate, pressure } = scratch;
        operators.volume_rate(velocity, wall_velocity, volume_rate);
        for (b, &pore) in rhs.iter_mut().zip(&operators.pore_of) {
            *b = -volume_rate[pore as usize];
        }
        factor.solve(rhs, correction)?;
        for (p, &pore) in correction.iter().zip(&operators.pore_of) {
            pressure[pore as usize] = *p;
        }
        operators.forces(pressure, force, &mut wall_force);
        Ok(wall_force)
    }

    /// Pressure of each pore (Pa).
    pub fn pressure(&self) -> &[f64] {
        &self.pressure
    }

    /// Rate at which each pore grows (m³/s).
    pub fn volume_rate(&self) -> &[f64] {
        &self.volume_rate
    }

    /// The fluid's force on each sphere (N).
    pub fn force(&self) -> &[Vec3] {
        &self.force
    }

    /// The fluid's force on each wall (N).
    pub fn wall_force(&self) -> &[Vec3; 6] {
        &self.wall_force
    }

    /// Flux through each wall, positive into the box (m³/s).
    pub fn flux(&self) -> [f64; 6] {
        self.operators.flux(&self.pressure, &self.volume_rate)
    }

    /// Residual of the first solve after the factorization; `None` before it.
    pub fn residual(&self) -> Option<f64> {
        self.residual
    }

    /// What entered through the walls less what the pores swallowed in the last
    /// solve, over the larger of both ([`Operators::imbalance`]).
    pub fn imbalance(&self) -> f64 {
        self.imbalance
    }

    /// How long the network and its factorization took.
    pub fn build_times(&self) -> BuildTimes {
        self.build_times
    }

    /// Where the factorization was computed.
    pub fn placement(&self) -> &Placement {
        static NOTHING: Placement = Placement::Cpu;
        self.factor.as_ref().map_or(&NOTHING, |f| f.placement())
    }

    /// Number of entries of the factor; 0 when nothing is unknown.
    pub fn nnz_l(&self) -> u64 {
        self.factor.as_ref().map_or(0, |f| f.analysis().nnz_l)
    }

    /// Permeability between two walls with imposed pressures, from the current
    /// pressures. `None` unless `wall` and the opposite wall, and no other,
    /// have imposed pressures and these differ.
    pub fn permeability(&self, wall: WallId, fluid: &Fluid) -> Option<Permeability> {
        let imposed = &fluid.boundary.pressure;
        let drop = imposed[wall.index()]? - imposed[wall.opposite().index()]?;
        if drop == 0.0 || imposed.iter().flatten().count() != 2 {
            return None;
        }
        let flux = self.flux();
        let (entering, leaving) = (flux[wall.index()], -flux[wall.opposite().index()]);
        let bounds = &self.network.bounds;
        let length = bounds.size()[wall.axis()];
        Some(Permeability {
            value: entering * fluid.viscosity * length / (bounds.wall_area(wall) * drop),
            flux: entering,
            imbalance: (entering - leaving).abs() / entering.abs(),
        })
    }
}
