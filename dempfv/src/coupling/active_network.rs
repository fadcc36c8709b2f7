//! A network in use.

use super::phases::{Phase, Phases};
use super::remesh::{FluidState, RemeshRule, Snapshot};
use crate::pfv::{Flow, Iterations, NONE};
use crate::{Aabb, Result, Vec3, WallId};

/// What the fluid feels of spheres and walls in a step.
pub(super) struct Motion<'a> {
    /// Velocity of each sphere (m/s).
    pub velocity: &'a [Vec3],
    /// Velocity of each wall along its axis (m/s).
    pub walls: [f64; 6],
    /// Which walls a servo moves.
    pub servo: [bool; 6],
    /// The time step (s).
    pub dt: f64,
    /// Where they are, if the network follows them.
    pub place: Option<Place<'a>>,
}

/// Where spheres and walls are, and what flows between them.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    /// Sphere centres (m).
    pub position: &'a [Vec3],
    /// The box (m).
    pub bounds: Aabb,
}

/// Least error that is asked of iterated pressures (1), whatever the
/// tolerance; see [`Flow::iterate`].
pub const PRESSURE_ERROR: f64 = 1e-6;
/// A network that takes so many applications of its factor is worn out.
const MANY: u32 = 24;

/// A network, and what a checkpoint must know of it.
pub(super) struct ActiveNetwork {
    pub flow: Flow,
    pub state: FluidState,
    /// How the last solve went, if it was iterated.
    pub iterations: Option<Iterations>,
    /// The pore of each probe, once it was looked for; [`NONE`] outside the box.
    probed: Vec<u32>,
}

impl ActiveNetwork {
    pub fn new(flow: Flow, state: FluidState) -> ActiveNetwork {
        ActiveNetwork { flow, state, iterations: None, probed: vec![] }
    }

    /// Volume rates, pressures and forces of a step (eqs. 5 to 10 of Caulk
    /// 2020).
    pub fn advance(&mut self, motion: &Motion, phases: &mut Phases) -> Result<()> {
        let ActiveNetwork { flow, state, iterations, .. } = self;
        if let Some(Place { position, bounds }) = motion.place {
            let wear = phases.time(Phase::Update, || flow.update_geometry(position, &bounds))?;
            state.worn = wear.inverted + wear.lost > 0;
        }
        phases
            .time(Phase::VolumeRates, || flow.update_volume_rate(motion.velocity, &motion.walls))?;
        if motion.place.is_some() {
            let tolerance = flow.tolerance().max(PRESSURE_ERROR);
            let went = phases.time(Phase::Solve, || flow.iterate(tolerance))?;
            state.worn |= went.applications >= MANY;
            *iterations = Some(went);
        } else {
            phases.time(Phase::Solve, || flow.update_pressure())?;
        }
        for wall in WallId::ALL {
            let known = &mut state.resistance[wall.index()];
            if motion.servo[wall.index()] && known.is_none() {
                *known = Some(phases.time(Phase::Solve, || flow.wall_resistance(wall))?);
            }
        }
        phases.time(Phase::FluidForces, || flow.update_force());
        for (change, rate) in state.volume_change.iter_mut().zip(flow.volume_rate()) {
            *change += rate * motion.dt;
        }
        state.since += 1;
        Ok(())
    }

    /// Looks for the pores that hold the points (m), once for each network.
    pub fn watch(&mut self, points: &[Vec3]) {
        if self.probed.len() == points.len() {
            return;
        }
        let Snapshot { position, bounds, .. } = &self.state.snapshot;
        let cells = &self.flow.network().tessellation;
        let place = |x: &Vec3| match bounds.contains(x) {
            true => cells.locate(position, x),
            false => NONE,
        };
        self.probed = points.iter().map(place).collect();
    }

    /// Pressure in the pore of a watched point (Pa); NaN where there is none.
    pub fn probe_pressure(&self, point: usize) -> f64 {
        let pore = self.probed.get(point).and_then(|&i| self.flow.pressure().get(i as usize));
        pore.copied().unwrap_or(f64::NAN)
    }

    /// The fluid's resistance to each wall (N·s/m); 0 where nobody asked.
    pub fn resistance(&self) -> [f64; 6] {
        self.state.resistance.map(|r| r.unwrap_or(0.0))
    }

    /// What a checkpoint needs after so many steps, but for what is on its way.
    pub fn saved(&self, step: u64) -> FluidState {
        FluidState { step, extrapolation: self.flow.extrapolation().clone(), ..self.state.clone() }
    }

    /// How far the pores have come towards the limit of their strain: 1 where
    /// the first has reached it; 0 without the rule.
    pub fn strain(&self, rule: &RemeshRule) -> f64 {
        let Some(limit) = rule.strain else { return 0.0 };
        let volume = self.flow.built_volume().iter();
        let strains = volume.zip(&self.state.volume_change).map(|(v, change)| (change / v).abs());
        strains.fold(0.0, f64::max) / limit
    }
}
