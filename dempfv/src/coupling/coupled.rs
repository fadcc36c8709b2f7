//! One step of spheres and fluid together.

use std::sync::Arc;
use std::time::Instant;

use super::TimeStepBounds;
use super::active_network::{ActiveNetwork, Motion, Place};
use super::background::NetworkBuilder;
use super::gpu_use::GpuUse;
use super::options::{Acceleration, RemeshMode, Update};
use super::phases::{Phase, Phases};
use super::remesh::{FluidState, IntervalTrail, RemeshCounts, RemeshRule, UpdateCounts};
use super::remesher::{Remesher, Site};
use super::viscous_bound;
use crate::dem::{Dem, DemError, WallControl};
use crate::parallel::spinning;
use crate::pfv::{BuildTimes, Flow, Fluid, ViscousMode};
use crate::solver::SolverKind;
use crate::{PerWall, Result, Vec3};

/// With fewer spheres than this most of a step is done by one thread.
const AWAKE: usize = 2_000;

/// A fluid in the pores: what it is, and how its flow is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saturation {
    /// The fluid and its boundary conditions.
    pub fluid: Fluid,
    /// The linear solver.
    pub solver: SolverKind,
    /// When to remesh.
    pub remesh: RemeshRule,
}

/// Spheres, and the fluid between them where there is one.
///
/// A step follows eqs. 1 to 13 of Caulk 2020: contacts, `V̇ = E v`,
/// `G p = -V̇ + Q`, `f = F p`, integration.
pub struct Coupled {
    /// The mechanics.
    pub dem: Dem,
    saturation: Option<Saturation>,
    networks: Remesher,
    /// Points whose pore pressure is of interest (m).
    probes: Vec<Vec3>,
    /// Steps done.
    steps: u64,
    largest_residual: f64,
    largest_imbalance: f64,
    update_counts: UpdateCounts,
    phases: Phases,
    beside: Beside,
}

/// Scratch: what the fluid reads beside the contacts.
#[derive(Default)]
struct Beside {
    velocity: Vec<Vec3>,
    position: Vec<Vec3>,
    radius: Vec<f64>,
}

impl Coupled {
    /// Dry spheres.
    pub fn new(dem: Dem) -> Coupled {
        Coupled {
            dem,
            saturation: None,
            networks: Remesher::new(),
            probes: vec![],
            steps: 0,
            largest_residual: 0.0,
            largest_imbalance: 0.0,
            update_counts: UpdateCounts::default(),
            phases: Phases::default(),
            beside: Beside::default(),
        }
    }

    /// Fills the pores; the network is built at the next step.
    pub fn saturate(&mut self, saturation: Saturation) {
        if self.saturation != Some(saturation) {
            self.networks.outdate();
        }
        self.saturation = Some(saturation);
    }

    /// Empties the pores: no fluid from the next step on. A network that is
    /// being built in the background is cancelled.
    pub fn drain(&mut self) {
        self.saturation = None;
        self.networks.clear();
    }

    /// Changes how networks are renewed, and whether the fluid is computed
    /// beside the contacts.
    pub fn accelerate(&mut self, acceleration: Acceleration) {
        self.networks.accelerate(acceleration);
    }

    /// Mean pressure of the pores around each sphere, weighted by their volumes (Pa),
    /// by the user's numbers; 0 for a sphere that is a vertex of no pore.
    pub fn pressure_at_spheres(&self) -> Vec<f64> {
        let particles = self.dem.storage();
        let mut sums = vec![(0.0, 0.0); particles.len()];
        if let Some(flow) = self.flow() {
            let (cells, volume) = (&flow.network.tessellation.cells, &flow.network.volume);
            for ((cell, v), p) in cells.iter().zip(volume).zip(flow.pressure()) {
                for &vertex in cell {
                    if let Some(sum) = sums.get_mut(vertex as usize) {
                        *sum = (sum.0 + v * p, sum.1 + v);
                    }
                }
            }
        }
        let mut pressure = vec![0.0; particles.len()];
        for (&id, (weighted, volume)) in particles.id.iter().zip(sums) {
            pressure[id as usize] = if volume > 0.0 { weighted / volume } else { 0.0 };
        }
        pressure
    }

    /// Sets what each solve may leave of the imbalance of fluid mass and of the
    /// pressures' error (1); see [`Flow::set_tolerance`](crate::pfv::Flow::set_tolerance).
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.networks.set_tolerance(tolerance);
    }

    /// Changes who builds networks.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.networks.build_with(builder);
    }

    /// Advances everything by `dt` (s). With 2,000 spheres or more the other threads of the
    /// pool keep their processors busy meanwhile, unless remeshes run in the background.
    ///
    /// # Errors
    /// What the mechanics, the network or the solver report; the state is then
    /// that of a failed step. [`Error::Snapshot`](crate::Error::Snapshot) for a
    /// network that was built from the positions of an earlier step.
    pub fn step(&mut self, dt: f64) -> Result<()> {
        let beside = self.networks.acceleration().remesh == RemeshMode::Background;
        if self.dem.storage().len() < AWAKE || beside {
            self.step_now(dt)
        } else {
            spinning(|| self.step_now(dt))
        }
    }

    fn step_now(&mut self, dt: f64) -> Result<()> {
        let Some(saturation) = self.saturation else { return self.dry_step(dt) };
        let mut start = Instant::now();
        let beside = self.networks.acceleration().parallel_tasks
            && self.networks.is_idle(&saturation.remesh);
        if beside {
            self.networks.begin_step();
            self.contacts_beside_fluid(dt, &saturation.fluid)?;
        } else {
            let Coupled { dem, phases, .. } = self;
            phases.time(Phase::Contacts, || dem.compute_contacts())?;
            let before = Instant::now();
            self.prepare_network(&saturation)?;
            self.networks.begin_step();
            // A step's own time is without its remesh.
            start += before.elapsed();
            let Coupled { dem, phases, networks, .. } = self;
            let follow = networks.acceleration().update == Update::EveryStep;
            if let Some(wet) = &mut networks.current {
                let particles = dem.storage();
                let mut motion = motion(dem, &particles.velocity, dt);
                if follow {
                    motion.place = Some(Place {
                        position: &particles.position,
                        radius: &particles.radius,
                        bounds: dem.box_(),
                        fluid: &saturation.fluid,
                    });
                }
                wet.advance(&motion, phases)?;
            }
        }
        self.integrate(dt)?;
        self.networks.stepped(start.elapsed());
        self.steps += 1;
        Ok(())
    }

    /// Sees to it that the next step has its network, once.
    fn prepare_network(&mut self, saturation: &Saturation) -> Result<()> {
        let Coupled { dem, phases, networks, probes, .. } = self;
        networks.prepare(Site { dem, saturation, step: self.steps }, phases)?;
        if let Some(wet) = &mut networks.current {
            wet.watch(probes);
        }
        Ok(())
    }

    fn dry_step(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, phases, .. } = self;
        phases.time(Phase::Contacts, || dem.compute_contacts())?;
        dem.set_wall_resistance([0.0; 6].into());
        phases.time(Phase::Integration, || dem.integrate(dt, None, None))?;
        self.steps += 1;
        Ok(())
    }

    /// Contact forces, and beside them the fluid's: both follow from positions
    /// and velocities of before the step, so the bits are those of one after
    /// the other.
    fn contacts_beside_fluid(&mut self, dt: f64, fluid: &Fluid) -> Result<()> {
        let Coupled { dem, networks, phases, beside, .. } = self;
        beside.velocity.clone_from(&dem.storage().velocity);
        let mut motion = motion(dem, &beside.velocity, dt);
        if networks.acceleration().update == Update::EveryStep {
            beside.position.clone_from(&dem.storage().position);
            beside.radius.clone_from(&dem.storage().radius);
            motion.place = Some(Place {
                position: &beside.position,
                radius: &beside.radius,
                bounds: dem.box_(),
                fluid,
            });
        }
        let mut fluid_phases = Phases::default();
        let mut contact_phases = Phases::default();
        let (contacts, fluid): (Result<(), DemError>, Result<()>) = rayon::join(
            || contact_phases.time(Phase::Contacts, || dem.compute_contacts()),
            || match &mut networks.current {
                Some(wet) => wet.advance(&motion, &mut fluid_phases),
                None => Ok(()),
            },
        );
        phases.merge(&contact_phases);
        phases.merge(&fluid_phases);
        contacts?;
        fluid
    }

    /// Moves walls and spheres under both forces.
    fn integrate(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, networks, phases, .. } = self;
        let wet = networks.current.as_ref();
        dem.set_wall_resistance(wet.map_or([0.0; 6], |wet| wet.resistance()).into());
        if let Some(ActiveNetwork { flow, iterations, state, .. }) = wet {
            if let Some(went) = iterations {
                self.update_counts.add(*went, state.worn);
            }
            self.largest_residual = self.largest_residual.max(flow.residual().unwrap_or(0.0));
            self.largest_imbalance = self.largest_imbalance.max(flow.imbalance());
        }
        let (force, wall_force) = wet.map(|wet| (wet.flow.force(), wet.flow.wall_force())).unzip();
        let wall_force = wall_force.copied().map(PerWall::from);
        phases.time(Phase::Integration, || dem.integrate(dt, force, wall_force.as_ref()))?;
        Ok(())
    }

    /// Finds the fastest viscous mode of the network that the next step uses,
    /// which comes into use here if it is due: the step finds that done, and
    /// uses no other. Returns whether the mode is new; never
    /// where the pores are empty. Unless `exact`, a mode too slow to matter
    /// beside the contacts remains rough.
    ///
    /// # Errors
    /// As a remesh, or when a solve fails.
    pub fn update_viscous_mode(&mut self, exact: bool) -> Result<bool> {
        let Some(saturation) = self.saturation else { return Ok(false) };
        self.prepare_network(&saturation)?;
        let Coupled { dem, phases, networks, .. } = self;
        let Some(wet) = networks.current.as_mut().filter(|wet| !wet.state.fastest.is_current(dem))
        else {
            return Ok(false);
        };
        phases.time(Phase::Contacts, || dem.compute_contacts())?;
        let ActiveNetwork { flow, state, .. } = wet;
        phases.time(Phase::TimeStep, || state.fastest.update(flow, dem, exact))?;
        Ok(true)
    }

    /// The mode that [`Coupled::update_viscous_mode`] found for the network in
    /// use.
    pub fn viscous_mode(&self) -> Option<&ViscousMode> {
        self.networks.current.as_ref()?.state.fastest.current()
    }

    /// What bounds the time step, as far as it is known, with the contacts of
    /// the last step.
    pub fn time_step_bounds(&mut self) -> TimeStepBounds {
        let viscosity = self.saturation.map(|s| s.fluid.viscosity);
        let fastest = self.networks.current.as_ref().map(|wet| &wet.state.fastest);
        viscous_bound::bounds(&mut self.dem, viscosity, fastest)
    }

    /// Books what building a network took.
    pub(crate) fn book_flow(&mut self, times: BuildTimes) {
        self.phases.book_build(times);
    }

    /// Runs dry mechanics and books their time.
    pub(crate) fn time_dry<T>(&mut self, phase: Phase, run: impl FnOnce(&mut Dem) -> T) -> T {
        let dem = &mut self.dem;
        self.phases.time(phase, || run(dem))
    }

    /// The flow of the last step; `None` where the pores are empty.
    pub fn flow(&self) -> Option<&Flow> {
        self.networks.current.as_ref().map(|wet| &wet.flow)
    }

    /// The fluid and how its flow is computed; `None` where the pores are empty.
    pub fn saturation(&self) -> Option<&Saturation> {
        self.saturation.as_ref()
    }

    /// Watches the pore pressure at these points (m), from the next network on.
    pub fn watch(&mut self, probes: Vec<Vec3>) {
        self.probes = probes;
    }

    /// Pressure of the pore that contained each watched point when the network was built
    /// (Pa). NaN where there is no network, and for a point that was outside its box.
    pub fn probe_pressures(&self) -> impl Iterator<Item = f64> + '_ {
        let wet = self.networks.current.as_ref();
        (0..self.probes.len()).map(move |k| wet.map_or(f64::NAN, |wet| wet.probe_pressure(k)))
    }

    /// How networks are renewed.
    pub fn acceleration(&self) -> &Acceleration {
        self.networks.acceleration()
    }

    /// Steps since the positions that the current network was built from.
    pub fn network_age(&self) -> u64 {
        let built_at = self.networks.current.as_ref().map(|wet| wet.state.snapshot.step);
        built_at.map_or(0, |step| self.steps - step)
    }

    /// Networks that came into use so far.
    pub fn remeshes(&self) -> u64 {
        self.networks.counts.networks
    }

    /// What happened at remeshes.
    pub fn remesh_counts(&self) -> &RemeshCounts {
        &self.networks.counts
    }

    /// What following the spheres between remeshes took.
    pub fn update_counts(&self) -> &UpdateCounts {
        &self.update_counts
    }

    /// What a GPU did, where the solver asks for one.
    pub fn gpu_use(&self) -> &GpuUse {
        &self.networks.gpu
    }

    /// The remesh interval and what it follows from.
    pub fn interval_trail(&self) -> IntervalTrail {
        let rule = self.saturation.map(|s| s.remesh);
        rule.map_or_else(IntervalTrail::default, |rule| self.networks.trail(&rule))
    }

    /// Largest residual of the first solves after factorizations.
    pub fn largest_residual(&self) -> f64 {
        self.largest_residual
    }

    /// Largest imbalance of fluid mass of any step ([`Flow::imbalance`]).
    pub fn largest_imbalance(&self) -> f64 {
        self.largest_imbalance
    }

    /// Goes on from the largest residual and imbalance of an earlier session.
    pub(crate) fn remember_worst(&mut self, residual: f64, imbalance: f64) {
        self.largest_residual = residual;
        self.largest_imbalance = imbalance;
    }

    /// Steps done, those of an earlier session included where it told so.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Says how many steps were done before, this object's or others'. Remesher
    /// in use have counted along.
    pub(crate) fn count_from(&mut self, steps: u64) {
        self.steps = steps;
    }

    /// Where the time went.
    pub fn phases(&self) -> &Phases {
        &self.phases
    }

    /// What a checkpoint needs beside the state of the mechanics.
    pub fn fluid_state(&self) -> Option<FluidState> {
        self.networks.state(self.steps)
    }

    /// Builds the network of a checkpoint again, bit for bit; in the
    /// background, also the one that was on its way.
    ///
    /// # Errors
    /// As a remesh.
    pub fn restore_fluid(&mut self, saturation: Saturation, state: FluidState) -> Result<()> {
        self.saturation = Some(saturation);
        self.steps = state.step();
        let site = Site { dem: &self.dem, saturation: &saturation, step: self.steps };
        self.networks.restore(state, site, &mut self.phases)?;
        if let Some(wet) = &mut self.networks.current {
            wet.watch(&self.probes);
        }
        Ok(())
    }
}

/// What the fluid feels in a step from `dt` on (s).
fn motion<'a>(dem: &Dem, velocity: &'a [Vec3], dt: f64) -> Motion<'a> {
    let walls = dem.walls();
    Motion {
        velocity,
        walls: walls.map(|w| w.velocity).0,
        servo: walls.map(|w| matches!(w.control, WallControl::Servo { .. })).0,
        dt,
        place: None,
    }
}
