//! One step of spheres and fluid together.

use std::sync::Arc;
use std::time::Instant;

use super::active_network::ActiveNetwork;
use super::counts::{IntervalTrail, RemeshCounts, UnmetTolerance, UpdateCounts};
use super::error::{Result, positive};
use super::fluid_effects::FluidEffects;
use super::fluid_state::FluidState;
use super::given_pressures::GivenPressures;
use super::gpu_use::GpuUse;
use super::network_builder::NetworkBuilder;
use super::network_source::RemeshContext;
use super::options::{Acceleration, RemeshMode, Update};
use super::phases::{Phase, Phases};
use super::remesher::Remesher;
use super::saturation::Saturation;
use super::time_step::{AutoTimeStep, TimeStepBounds};
use super::viscous_bound;
use crate::dem::{Dem, DemError, FluidLoads};
use crate::parallel::spinning;
use crate::pfv::{BuildTimes, Flow, RetiredNetwork, ViscousMode};
use crate::{PerWall, Vec3};

/// Spheres from which on the threads that wait keep their processors busy: with
/// fewer, most of a step is done by one thread.
const SPINNING_SPHERES: usize = 2_000;

/// Spheres, and the fluid between them where there is one.
///
/// A step follows eqs. 1 to 13 of Caulk 2020: contacts, `V̇ = E v`,
/// `G p = -V̇ + Q`, `f = F p`, integration.
///
/// Spheres have the numbers that the user gave them. In memory they lie in an order in space:
/// what has `storage` in its name, as [`Coupled::storage_flow`] and
/// [`Dem::storage`](crate::dem::Dem::storage), is in that order, and
/// [`Dem::by_number`](crate::dem::Dem::by_number) brings it into the user's.
pub struct Coupled {
    pub(super) dem: Dem,
    pub(super) saturation: Option<Saturation>,
    pub(super) effects: FluidEffects,
    pub(super) given: GivenPressures,
    pub(super) remesher: Remesher,
    /// Points whose pore pressure is of interest (m).
    pub(super) probes: Vec<Vec3>,
    /// Steps done.
    pub(super) steps: u64,
    /// Length of the last one (s); 0 before the first.
    pub(super) last_time_step: f64,
    /// Model time (s).
    pub(super) time: f64,
    pub(super) largest_residual: f64,
    pub(super) largest_imbalance: f64,
    pub(super) update_counts: UpdateCounts,
    pub(super) unmet_tolerance: UnmetTolerance,
    pub(super) phases: Phases,
    pub(super) auto_time_step: AutoTimeStep,
    pub(super) overlap: OverlapBuffers,
}

/// Scratch: what the fluid reads while the contacts are computed.
#[derive(Default)]
pub(super) struct OverlapBuffers {
    pub velocity: Vec<Vec3>,
    pub position: Vec<Vec3>,
}

impl Coupled {
    /// Dry spheres.
    pub fn new(dem: Dem) -> Coupled {
        Coupled {
            dem,
            saturation: None,
            effects: FluidEffects::default(),
            given: GivenPressures::default(),
            remesher: Remesher::new(),
            probes: vec![],
            steps: 0,
            last_time_step: 0.0,
            time: 0.0,
            largest_residual: 0.0,
            largest_imbalance: 0.0,
            update_counts: UpdateCounts::default(),
            unmet_tolerance: UnmetTolerance::default(),
            phases: Phases::default(),
            auto_time_step: AutoTimeStep::default(),
            overlap: OverlapBuffers::default(),
        }
    }

    /// The mechanics, to be looked at; [`Coupled::controls`] changes them.
    pub fn dem(&self) -> &Dem {
        &self.dem
    }

    /// Fills the pores; the network is built at the next step, which refuses a fluid or a remesh
    /// rule that makes no sense.
    pub fn saturate(&mut self, saturation: Saturation) {
        if self.saturation != Some(saturation) {
            self.remesher.outdate();
        }
        self.saturation = Some(saturation);
    }

    /// Says what the fluid does beside flowing, incompressible and without weight, between walls.
    /// The network is built anew at the next step where that is something else than before.
    pub fn set_fluid_effects(&mut self, effects: FluidEffects) {
        if self.effects != effects {
            self.remesher.outdate();
        }
        self.effects = effects;
    }

    /// What the fluid does beside flowing.
    pub fn fluid_effects(&self) -> &FluidEffects {
        &self.effects
    }

    /// Empties the pores: no fluid from the next step on. A network that is
    /// being built in the background is cancelled.
    pub fn drain(&mut self) {
        self.saturation = None;
        self.remesher.clear();
    }

    /// Changes how networks are renewed, and whether the fluid is computed
    /// beside the contacts.
    pub fn accelerate(&mut self, acceleration: Acceleration) {
        self.remesher.accelerate(acceleration);
    }

    /// Sets what each solve may leave of the imbalance of fluid mass and of the
    /// pressures' error (1); see [`Flow::set_tolerance`](crate::pfv::Flow::set_tolerance).
    ///
    /// # Errors
    /// For one that is not between 0 and 1.
    pub fn set_tolerance(&mut self, tolerance: f64) -> Result<()> {
        self.remesher.set_tolerance(tolerance)
    }

    /// Changes who builds networks.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.remesher.build_with(builder);
    }

    /// Advances everything by `dt` (s). With 2,000 spheres or more the other threads of the
    /// pool keep their processors busy meanwhile, unless remeshes run in the background.
    ///
    /// # Errors
    /// What the mechanics, the network or the solver report; the state is then
    /// that of a failed step. [`CouplingError::Snapshot`](super::CouplingError::Snapshot)
    /// for a network that was built from the positions of an earlier step;
    /// [`CouplingError::Parameter`](super::CouplingError::Parameter) for a time step or a
    /// remesh rule that makes no sense.
    pub fn step(&mut self, dt: f64) -> Result<()> {
        positive("time step", dt)?;
        let background = self.remesher.acceleration().remesh == RemeshMode::Background;
        if self.dem.storage().len() < SPINNING_SPHERES || background {
            self.step_now(dt)
        } else {
            spinning(|| self.step_now(dt))
        }
    }

    fn step_now(&mut self, dt: f64) -> Result<()> {
        let Some(saturation) = self.saturation else { return self.dry_step(dt) };
        let mut start = Instant::now();
        let overlaps = self.remesher.acceleration().parallel_tasks
            && self.remesher.is_idle(&saturation.remesh);
        if overlaps {
            self.remesher.begin_step();
            self.contacts_beside_fluid(dt)?;
        } else {
            let Coupled { dem, phases, .. } = self;
            phases.time(Phase::Contacts, || dem.compute_contacts())?;
            let before = Instant::now();
            self.prepare_network(&saturation, dt)?;
            self.remesher.begin_step();
            // A step's own time is without its remesh.
            start += before.elapsed();
            self.advance_fluid(dt, true)?;
        }
        self.integrate(dt)?;
        self.remesher.stepped(start.elapsed());
        self.steps += 1;
        self.last_time_step = dt;
        self.time += dt;
        Ok(())
    }

    /// Sees to it that the next step, of this length (s) as far as it is known, has its network,
    /// once.
    pub(super) fn prepare_network(
        &mut self,
        saturation: &Saturation,
        time_step: f64,
    ) -> Result<()> {
        if self.dem.cell().is_some() {
            self.effects.check_in_cell()?;
            if self.remesher.acceleration().update == Update::EveryStep {
                let what = "a network that follows the spheres in each step";
                let remedy = "its spheres are put back into the cell; renew it more often";
                return Err(DemError::InCell { what, remedy }.into());
            }
        }
        if let Some(strain) = saturation.remesh.strain {
            positive("remesh.strain", strain)?;
        }
        let time = self.time;
        let Coupled { dem, phases, remesher, probes, effects, given, .. } = self;
        let context =
            RemeshContext { dem, saturation, effects, given, step: self.steps, time_step, time };
        remesher.prepare(context, phases)?;
        if let Some(network) = &mut remesher.current {
            network.watch(probes);
        }
        Ok(())
    }

    fn dry_step(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, phases, .. } = self;
        phases.time(Phase::Contacts, || dem.compute_contacts())?;
        dem.set_wall_resistance(PerWall::default())?;
        dem.set_time(self.time)?;
        phases.time(Phase::Integration, || dem.integrate(dt, None, None))?;
        self.steps += 1;
        self.time += dt;
        Ok(())
    }

    /// Moves walls and spheres under both forces.
    fn integrate(&mut self, dt: f64) -> Result<()> {
        self.act_on_edges(dt);
        self.book_solve();
        let Coupled { dem, remesher, phases, .. } = self;
        let network = remesher.current.as_ref();
        dem.set_wall_resistance(network.map(ActiveNetwork::resistance).unwrap_or_default())?;
        let on_walls = network.map(|network| PerWall::from(network.expected_wall_force()));
        let loads = FluidLoads {
            force: network.map(ActiveNetwork::force),
            torque: network.and_then(|network| network.edges.as_ref()?.torque()),
            on_walls: on_walls.as_ref(),
        };
        dem.set_time(self.time)?;
        phases.time(Phase::Integration, || dem.integrate_under(dt, loads))?;
        self.book_edges(dt);
        Ok(())
    }

    /// Finds the fastest viscous mode of the network that the next step uses,
    /// which comes into use here if it is due: the step finds that done, and
    /// uses no other. Returns whether the mode is new; never
    /// where the pores are empty, or motion squeezes no fluid. Unless `exact`, a mode too slow to
    /// matter beside the contacts remains rough.
    ///
    /// # Errors
    /// As a remesh, or when a solve fails.
    pub fn update_viscous_mode(&mut self, exact: bool) -> Result<bool> {
        let Some(saturation) = self.saturation else { return Ok(false) };
        let time_step = self.expected_time_step();
        self.prepare_network(&saturation, time_step)?;
        if self.effects.one_way {
            return Ok(false);
        }
        let Coupled { dem, phases, remesher, .. } = self;
        let Some(network) =
            remesher.current.as_mut().filter(|network| !network.state.fastest.is_current(dem))
        else {
            return Ok(false);
        };
        phases.time(Phase::Contacts, || dem.compute_contacts())?;
        let ActiveNetwork { flow, state, .. } = network;
        phases.time(Phase::TimeStep, || state.fastest.update(flow, dem, exact))?;
        Ok(true)
    }

    /// The mode that [`Coupled::update_viscous_mode`] found for the network in
    /// use; its shape is in storage order.
    pub fn viscous_mode(&self) -> Option<&ViscousMode> {
        self.remesher.current.as_ref()?.state.fastest.current()
    }

    /// What bounds the time step, as far as it is known, with the contacts of
    /// the last step.
    pub fn time_step_bounds(&mut self) -> TimeStepBounds {
        // What the flow does to the spheres does not follow from their motion where this squeezes
        // none of it; what is between neighbours does.
        let drags = self.saturation.filter(|_| !self.effects.one_way);
        let viscosity = drags.map(|s| s.fluid.viscosity);
        let network = self.remesher.current.as_mut();
        let (fastest, edges) =
            network.map(|network| (&network.state.fastest, network.edges.as_mut())).unzip();
        let fastest = fastest.filter(|_| drags.is_some());
        viscous_bound::bounds(&mut self.dem, viscosity, fastest, edges.flatten())
    }

    /// Brings the contact forces up to the current positions; the next step
    /// finds this done.
    ///
    /// # Errors
    /// As [`Dem::compute_contacts`].
    pub fn compute_contacts(&mut self) -> Result<()> {
        Ok(self.dem.compute_contacts()?)
    }

    /// Puts the spheres in spatial order again, after they have moved far from
    /// where they were: neighbours in space become neighbours in memory, and
    /// steps faster. Changes the storage order. A network in use knows the
    /// spheres by their old order, so the next step builds another.
    ///
    /// # Errors
    /// As [`Dem::sort_spatially`].
    pub fn sort_spatially(&mut self) -> Result<()> {
        self.remesher.outdate();
        self.dem.sort_spatially()?;
        self.compute_contacts()
    }

    /// Lets the mechanics be changed in any way, such as growth, and books the
    /// time. A network in use is outdated: the next step builds another.
    pub(crate) fn change_mechanics<T>(
        &mut self,
        phase: Phase,
        change: impl FnOnce(&mut Dem) -> T,
    ) -> T {
        self.remesher.outdate();
        let dem = &mut self.dem;
        self.phases.time(phase, || change(dem))
    }

    /// Books work beside the time loop, such as a static flow.
    pub(crate) fn time<T>(&mut self, phase: Phase, run: impl FnOnce() -> T) -> T {
        self.phases.time(phase, run)
    }

    /// Books what building a network took.
    pub(crate) fn book_build(&mut self, times: BuildTimes) {
        self.phases.book_build(times);
    }

    /// The flow of the last step, whose spheres are in storage order; `None` where the pores are
    /// empty. [`Coupled::fluid_force`] and [`Coupled::pressure_at_spheres`] go by the user's
    /// numbers.
    pub fn storage_flow(&self) -> Option<&Flow> {
        self.remesher.current.as_ref().map(|network| &network.flow)
    }

    /// Whether the arrays of the network in use shall stay where they are in memory: when it goes out of
    /// use, [`Coupled::take_retired_network`] hands them over. For whoever looks at them by their
    /// addresses; networks after this one are freed as ever.
    pub fn keep_network_arrays(&mut self, keep: bool) {
        if let Some(network) = &mut self.remesher.current {
            network.kept = keep;
        }
    }

    /// The network that was to be kept ([`Coupled::keep_network_arrays`]), once it has gone out of use.
    pub fn take_retired_network(&mut self) -> Option<RetiredNetwork> {
        self.remesher.take_kept()
    }

    /// The fluid and how its flow is computed; `None` where the pores are empty.
    pub fn saturation(&self) -> Option<&Saturation> {
        self.saturation.as_ref()
    }

    /// Watches the pore pressure at these points (m), from the next network on. A point that is
    /// outside the box or no number has no pressure ([`Coupled::probe_pressures`]).
    pub fn watch(&mut self, probes: Vec<Vec3>) {
        self.probes = probes;
    }

    /// How networks are renewed.
    pub fn acceleration(&self) -> &Acceleration {
        self.remesher.acceleration()
    }

    /// Steps since the positions that the current network was built from.
    pub fn network_age(&self) -> u64 {
        let built_at = self.remesher.current.as_ref().map(|network| network.state.snapshot.step);
        built_at.map_or(0, |step| self.steps.saturating_sub(step))
    }

    /// Networks that came into use so far.
    pub fn remeshes(&self) -> u64 {
        self.remesher.counts.networks
    }

    /// What happened at remeshes.
    pub fn remesh_counts(&self) -> &RemeshCounts {
        &self.remesher.counts
    }

    /// What following the spheres between remeshes took.
    pub fn update_counts(&self) -> &UpdateCounts {
        &self.update_counts
    }

    /// Solves that left more than the tolerance.
    pub fn unmet_tolerance(&self) -> UnmetTolerance {
        self.unmet_tolerance
    }

    /// What a GPU did, where the solver asks for one.
    pub fn gpu_use(&self) -> &GpuUse {
        &self.remesher.gpu
    }

    /// The remesh interval and what it follows from.
    pub fn interval_trail(&self) -> IntervalTrail {
        let rule = self.saturation.map(|s| s.remesh);
        rule.map_or_else(IntervalTrail::default, |rule| self.remesher.trail(&rule))
    }

    /// Largest residual of the first solves after factorizations.
    pub fn largest_residual(&self) -> f64 {
        self.largest_residual
    }

    /// Largest imbalance of fluid mass of any step ([`Flow::imbalance`]).
    pub fn largest_imbalance(&self) -> f64 {
        self.largest_imbalance
    }

    /// Steps done, those of an earlier session included where it told so.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Model time (s): the length of all steps, those of an earlier session included where it told so.
    pub fn model_time(&self) -> f64 {
        self.time
    }

    /// Says what the model time is (s), where steps were done otherwise too.
    pub(crate) fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// Says how many steps were done before, this object's or others'. Networks
    /// in use have counted along.
    pub(crate) fn count_from(&mut self, steps: u64) {
        self.steps = steps;
    }

    /// Builds the network of a state again, bit for bit; in the background, also
    /// the one that was on its way.
    pub(super) fn restore_network(
        &mut self,
        saturation: &Saturation,
        state: FluidState,
    ) -> Result<()> {
        let time = self.time;
        let Coupled { dem, phases, remesher, probes, effects, given, .. } = self;
        let time_step = self.last_time_step;
        let context =
            RemeshContext { dem, saturation, effects, given, step: self.steps, time_step, time };
        remesher.restore(state, context, phases)?;
        if let Some(network) = &mut remesher.current {
            network.watch(probes);
        }
        Ok(())
    }

    /// Where the time went.
    pub fn phases(&self) -> &Phases {
        &self.phases
    }
}
