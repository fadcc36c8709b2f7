//! One step of spheres and fluid together, and the rule for remeshing.

use serde::{Deserialize, Serialize};

use super::phases::{Phase, Phases};
use super::setup::with_users_numbers;
use crate::dem::{Dem, WallControl};
use crate::pfv::{BuildTimes, Flow, Fluid, NONE};
use crate::solver::SolverKind;
use crate::{Aabb, Result, Vec3, WallId};

/// When the pore network is built anew: whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RemeshRule {
    /// After so many steps (λ_rm).
    pub interval: Option<u64>,
    /// When a pore's volume has changed by this share (eq. 14 of Caulk 2020).
    pub strain: Option<f64>,
}

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

/// What a checkpoint must hold to go on with the same network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluidState {
    /// Sphere centres when the network was built (m).
    position: Vec<Vec3>,
    /// Box when the network was built (m).
    bounds: Aabb,
    /// Steps done with this network.
    age: u64,
    /// Change of each pore's volume since then (m³); empty without the strain rule.
    volume_change: Vec<f64>,
    /// Unknown pressures that the next solve goes on from (Pa); empty before
    /// the first.
    solution: Vec<f64>,
}

/// A network in use.
struct Wet {
    flow: Flow,
    state: FluidState,
    /// The fluid's resistance to each servo-controlled wall (N·s/m), once it
    /// is known for this network.
    resistance: [Option<f64>; 6],
    /// The pore of each probe; [`NONE`] outside the box.
    probed: Vec<u32>,
}

/// Spheres, and the fluid between them where there is one.
///
/// A step follows eqs. 1 to 13 of Caulk 2020: contacts, `V̇ = E v`,
/// `G p = -V̇ + Q`, `f = F p`, integration.
pub struct Coupled {
    /// The mechanics.
    pub dem: Dem,
    saturation: Option<Saturation>,
    wet: Option<Wet>,
    /// Points whose pore pressure is of interest (m).
    probes: Vec<Vec3>,
    remeshes: u64,
    largest_residual: f64,
    largest_imbalance: f64,
    phases: Phases,
}

impl Coupled {
    /// Dry spheres.
    pub fn new(dem: Dem) -> Coupled {
        Coupled {
            dem,
            saturation: None,
            wet: None,
            probes: vec![],
            remeshes: 0,
            largest_residual: 0.0,
            largest_imbalance: 0.0,
            phases: Phases::default(),
        }
    }

    /// Fills the pores; the network is built at the next step.
    pub fn saturate(&mut self, saturation: Saturation) {
        if self.saturation != Some(saturation) {
            self.wet = None;
        }
        self.saturation = Some(saturation);
    }

    /// Empties the pores: no fluid from the next step on.
    pub fn drain(&mut self) {
        self.saturation = None;
        self.wet = None;
    }

    /// Advances everything by `dt` (s).
    ///
    /// # Errors
    /// What the mechanics, the network or the solver report; the state is then
    /// that of a failed step.
    pub fn step(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, phases, .. } = self;
        phases.time(Phase::Contacts, || dem.compute_contacts())?;
        if self.saturation.is_none() {
            let dem = &mut self.dem;
            dem.set_wall_resistance([0.0; 6]);
            return Ok(self.phases.time(Phase::Integration, || dem.integrate(dt, None, None))?);
        }
        self.remesh_if_due()?;
        self.update_fluid(dt)?;
        let Coupled { dem, wet, phases, .. } = self;
        let (force, wall_force) = match wet {
            Some(wet) => (Some(wet.flow.force()), Some(wet.flow.wall_force())),
            None => (None, None),
        };
        phases.time(Phase::Integration, || dem.integrate(dt, force, wall_force))?;
        Ok(())
    }

    fn remesh_if_due(&mut self) -> Result<()> {
        let Some(saturation) = self.saturation else { return Ok(()) };
        if self.wet.as_ref().is_none_or(|wet| wet.is_due(&saturation.remesh)) {
            // Two networks at once would take twice the memory.
            self.wet = None;
            let position = self.dem.particles().position.clone();
            let fresh = FluidState {
                position,
                bounds: self.dem.box_(),
                age: 0,
                volume_change: vec![],
                solution: vec![],
            };
            self.mesh(saturation, fresh)?;
            self.remeshes += 1;
        }
        Ok(())
    }

    /// Builds the network for the positions that a fluid state names.
    fn mesh(&mut self, saturation: Saturation, mut state: FluidState) -> Result<()> {
        let particles = self.dem.particles();
        let Saturation { fluid, solver, .. } = saturation;
        let mut flow = Flow::new(&state.position, &particles.radius, state.bounds, &fluid, solver)
            .map_err(|e| with_users_numbers(e, particles))?;
        flow.resume(&state.solution);
        self.book_flow(flow.build_times());
        if saturation.remesh.strain.is_some() && state.volume_change.is_empty() {
            state.volume_change = vec![0.0; flow.network.pores()];
        }
        let cells = &flow.network.tessellation;
        let place = |x: &Vec3| match state.bounds.contains(x) {
            true => cells.locate(&state.position, x),
            false => NONE,
        };
        let probed = self.probes.iter().map(place).collect();
        self.wet = Some(Wet { flow, state, resistance: [None; 6], probed });
        Ok(())
    }

    fn update_fluid(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, wet: Some(wet), phases, .. } = self else { return Ok(()) };
        let walls = dem.walls().each_ref().map(|w| w.velocity);
        let flow = &mut wet.flow;
        phases.time(Phase::VolumeRates, || {
            flow.update_volume_rate(&dem.particles().velocity, &walls)
        });
        phases.time(Phase::Solve, || flow.update_pressure())?;
        for wall in WallId::ALL {
            let servo = matches!(dem.walls()[wall.index()].control, WallControl::Servo { .. });
            if servo && wet.resistance[wall.index()].is_none() {
                let found = phases.time(Phase::Solve, || flow.wall_resistance(wall))?;
                wet.resistance[wall.index()] = Some(found);
            }
        }
        dem.set_wall_resistance(wet.resistance.map(|r| r.unwrap_or(0.0)));
        phases.time(Phase::FluidForces, || flow.update_force());
        for (change, rate) in wet.state.volume_change.iter_mut().zip(flow.volume_rate()) {
            *change += rate * dt;
        }
        wet.state.age += 1;
        self.largest_residual = self.largest_residual.max(flow.residual().unwrap_or(0.0));
        self.largest_imbalance = self.largest_imbalance.max(flow.imbalance());
        Ok(())
    }

    /// Books what building a network took.
    pub(super) fn book_flow(&mut self, times: BuildTimes) {
        self.phases.add(Phase::Network, times.network);
        self.phases.add(Phase::Analyze, times.analyze);
        self.phases.add(Phase::Factor, times.factor);
    }

    /// Runs dry mechanics and books their time.
    pub(super) fn time_dry<T>(&mut self, phase: Phase, run: impl FnOnce(&mut Dem) -> T) -> T {
        let dem = &mut self.dem;
        self.phases.time(phase, || run(dem))
    }

    /// The flow of the last step; `None` where the pores are empty.
    pub fn flow(&self) -> Option<&Flow> {
        self.wet.as_ref().map(|wet| &wet.flow)
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
        (0..self.probes.len()).map(|k| {
            let wet = self.wet.as_ref();
            let pore = wet.and_then(|wet| Some((wet, *wet.probed.get(k)?)));
            let pressure = pore.and_then(|(wet, pore)| wet.flow.pressure().get(pore as usize));
            pressure.copied().unwrap_or(f64::NAN)
        })
    }

    /// Steps done with the current network.
    pub fn network_age(&self) -> u64 {
        self.wet.as_ref().map_or(0, |wet| wet.state.age)
    }

    /// Networks built so far.
    pub fn remeshes(&self) -> u64 {
        self.remeshes
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
    pub(super) fn remember_worst(&mut self, residual: f64, imbalance: f64) {
        self.largest_residual = residual;
        self.largest_imbalance = imbalance;
    }

    /// Where the time went.
    pub fn phases(&self) -> &Phases {
        &self.phases
    }

    /// What a checkpoint needs beside the state of the mechanics.
    pub fn fluid_state(&self) -> Option<FluidState> {
        let wet = self.wet.as_ref()?;
        Some(FluidState { solution: wet.flow.solution().to_vec(), ..wet.state.clone() })
    }

    /// Builds the network of a checkpoint again, bit for bit.
    ///
    /// # Errors
    /// As a remesh.
    pub fn restore_fluid(&mut self, saturation: Saturation, state: FluidState) -> Result<()> {
        self.saturation = Some(saturation);
        self.mesh(saturation, state)
    }
}

impl Wet {
    fn is_due(&self, rule: &RemeshRule) -> bool {
        if rule.interval.is_some_and(|interval| self.state.age >= interval) {
            return true;
        }
        let Some(limit) = rule.strain else { return false };
        let volume = &self.flow.network.volume;
        volume
            .iter()
            .zip(&self.state.volume_change)
            .any(|(v, change)| change.abs() > limit * v.abs())
    }
}
