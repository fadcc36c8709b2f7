//! A network in use.

use super::edges::EdgeForces;
use super::error::Result;
use super::fluid_state::{FluidState, Followed, Snapshot};
use super::given_pressures::Conditions;
use super::phases::{Phase, Phases};
use super::saturation::RemeshRule;
use crate::pfv::{Flow, Iterations, NONE, Place};
use crate::{Aabb, Cell, PerWall, Vec3, WallId};

/// How spheres and walls move in a step, as the fluid feels it.
pub(super) struct SolidMotion<'a> {
    /// Velocity of each sphere (m/s).
    pub velocity: &'a [Vec3],
    /// Velocity of each wall along its axis (m/s).
    pub walls: [f64; 6],
    /// By how much of its volume a periodic cell grows in a second (1/s).
    pub dilation: f64,
    /// Which walls a servo moves.
    pub servo: [bool; 6],
    /// The time step (s).
    pub dt: f64,
    /// Conditions at the end of the step; `None` where they are those of every other one.
    pub conditions: Option<Conditions<'a>>,
    /// Whether the motion squeezes the fluid.
    pub squeezes: bool,
    /// Whether there is any: velocities are of no account where spheres and walls stand still.
    pub moves: bool,
    /// Where they are, if the network follows them or its pores store fluid.
    pub geometry: Option<SolidGeometry<'a>>,
    /// Whether the network follows them.
    pub follows: bool,
}

/// Where spheres and walls are.
#[derive(Clone, Copy)]
pub(super) struct SolidGeometry<'a> {
    /// Sphere centres (m).
    pub position: &'a [Vec3],
    /// The box (m).
    pub bounds: Aabb,
    /// The periodic cell.
    pub cell: Option<&'a Cell>,
}

/// Error that is asked of iterated pressures (1) where no tolerance was given; see
/// [`Flow::iterate`].
pub const PRESSURE_ERROR: f64 = 1e-6;
/// Applications of its factor in one solve by which a network is exhausted.
const EXHAUSTING_APPLICATIONS: u32 = 24;

/// A time step so many times as long or as short as the one that the factor is for, too.
const EXHAUSTING_STEP_RATIO: f64 = 2.0;

/// How pores grow that store fluid: what a step takes up is the change of their volumes.
fn take_growth(
    flow: &mut Flow,
    state: &mut FluidState,
    (motion, geometry): (&SolidMotion, &SolidGeometry),
) -> Result<()> {
    let SolidGeometry { position, bounds, cell } = geometry;
    let place = Place { position, bounds, cell: *cell };
    if !flow.grow_to(place, state.grown_to.as_ref().map(|before| before.view()))? {
        evaluate_rates(flow, motion)?;
    }
    if let Some(grown_to) = &mut state.grown_to {
        grown_to.set(&place);
    }
    Ok(())
}

/// How pores grow between walls, or in a periodic cell, in the first order of the motion.
fn evaluate_rates(flow: &mut Flow, motion: &SolidMotion) -> Result<()> {
    Ok(match flow.network().periodic() {
        None => flow.update_volume_rate(motion.velocity, &motion.walls),
        Some(_) => flow.update_volume_rate_in_cell(motion.velocity, motion.dilation),
    }?)
}

/// A network, and what a checkpoint must know of it.
pub(super) struct ActiveNetwork {
    pub flow: Flow,
    pub state: FluidState,
    /// The forces between neighbours, where there are any.
    pub edges: Option<EdgeForces>,
    /// How the last solve went, if it was iterated.
    pub iterations: Option<Iterations>,
    /// The pore of each probe, once it was looked for; [`NONE`] outside the box.
    probed: Vec<u32>,
    /// Its arrays stay where they are when it goes out of use.
    pub kept: bool,
}

impl ActiveNetwork {
    pub fn new(flow: Flow, edges: Option<EdgeForces>, state: FluidState) -> ActiveNetwork {
        ActiveNetwork { flow, edges, state, iterations: None, probed: vec![], kept: false }
    }

    /// Force of the fluid on each sphere in the last step (N), in storage order.
    pub fn force(&self) -> &[Vec3] {
        self.edges.as_ref().map_or(self.flow.force(), EdgeForces::total)
    }

    /// Force of the fluid on each wall in the last step (N).
    pub fn wall_force(&self) -> [Vec3; 6] {
        let mut force = *self.flow.wall_force();
        if let Some(edges) = &self.edges {
            force.iter_mut().zip(edges.wall_force()).for_each(|(sum, edges)| *sum += edges);
        }
        force
    }

    /// Volume rates, pressures and forces of a step (eqs. 5 to 10 of Caulk
    /// 2020).
    pub fn advance(&mut self, motion: &SolidMotion, phases: &mut Phases) -> Result<()> {
        if let Some(geometry) = motion.geometry.as_ref().filter(|_| motion.follows) {
            phases.time(Phase::Update, || self.update_geometry(geometry))?;
        }
        self.set_time_step(motion.dt, phases)?;
        if !motion.squeezes && self.is_steady(motion, phases)? {
            self.state.since += 1;
            return Ok(());
        }
        let ActiveNetwork { flow, state, iterations, .. } = self;
        if motion.squeezes {
            phases.time(Phase::VolumeRates, || match &motion.geometry {
                Some(geometry) if flow.time_step().is_some() => {
                    take_growth(flow, state, (motion, geometry))
                }
                _ => evaluate_rates(flow, motion),
            })?;
        }
        if let Some(conditions) = motion.conditions {
            conditions.impose(flow)?;
        }
        // Before the pressures: where this fails, the step has not begun to change them.
        for wall in WallId::ALL {
            let known = &mut state.resistance[wall];
            if motion.squeezes && motion.servo[wall.index()] && known.is_none() {
                *known = Some(phases.time(Phase::Solve, || flow.wall_resistance(wall))?);
                state.persistence[wall] =
                    phases.time(Phase::Solve, || flow.wall_persistence(wall))?;
            }
        }
        if motion.follows {
            let tolerance = flow.tolerance();
            let solve = phases.time(Phase::Solve, || flow.iterate(tolerance))?;
            state.exhausted |= solve.applications >= EXHAUSTING_APPLICATIONS;
            *iterations = Some(solve);
        } else {
            phases.time(Phase::Solve, || flow.update_pressure())?;
        }
        // In the first step it is that of the network before.
        if state.since > 0 {
            state.wall_force_before = Some(*flow.wall_force());
        }
        phases.time(Phase::FluidForces, || flow.update_force());
        if motion.squeezes {
            state.book_volumes(flow, motion.dt);
        }
        state.since += 1;
        Ok(())
    }

    /// Notes how pores grow whose motion squeezes no fluid, where the strain rule asks, and returns
    /// whether their pressures are those of the step before: there is nothing to solve then.
    fn is_steady(&mut self, motion: &SolidMotion, phases: &mut Phases) -> Result<bool> {
        let ActiveNetwork { flow, state, .. } = self;
        let rested = flow.rest();
        if motion.moves && !state.volume_change.is_empty() {
            phases.time(Phase::VolumeRates, || evaluate_rates(flow, motion))?;
            state.book_volumes(flow, motion.dt);
            flow.rest();
        }
        let same_network = !motion.follows && flow.time_step().is_none();
        Ok(rested && same_network && motion.conditions.is_none() && flow.is_solved())
    }

    /// Says how long the step is (s): pores that store fluid make the matrix go with it.
    pub fn set_time_step(&mut self, dt: f64, phases: &mut Phases) -> Result<()> {
        let ActiveNetwork { flow, state, .. } = self;
        let Some(before) = flow.time_step() else { return Ok(()) };
        if state.followed.is_some() {
            // The factor stays, so that a checkpoint can build it again.
            flow.set_time_step(dt)?;
            let ratio = dt / state.snapshot.time_step;
            state.exhausted |=
                !(1.0 / EXHAUSTING_STEP_RATIO..=EXHAUSTING_STEP_RATIO).contains(&ratio);
        } else if dt != before && phases.time(Phase::Factor, || flow.set_time_step(dt))? {
            state.snapshot.time_step = dt;
            state.resistance = PerWall::default();
        }
        Ok(())
    }

    /// Takes the network along with its spheres, and remembers where to.
    fn update_geometry(&mut self, geometry: &SolidGeometry) -> Result<()> {
        let SolidGeometry { position, bounds, .. } = *geometry;
        let degradation = self.flow.update_geometry(position, &bounds)?;
        self.state.exhausted = degradation.inverted + degradation.lost > 0;
        match &mut self.state.followed {
            Some(followed) => {
                followed.position.clear();
                followed.position.extend_from_slice(position);
                followed.bounds = bounds;
            }
            none => *none = Some(Followed { position: position.to_vec(), bounds }),
        }
        Ok(())
    }

    /// Brings a network that was built again to where its last step left it:
    /// pressures, forces and fluxes are those of that step.
    ///
    /// # Errors
    /// When the state has another number of spheres.
    pub fn resume(&mut self) -> Result<()> {
        let ActiveNetwork { flow, edges, state, .. } = self;
        if let Some(Followed { position, bounds }) = &state.followed {
            flow.update_geometry(position, bounds)?;
        }
        if let Some(time_step) = state.time_step {
            flow.set_time_step(time_step)?;
        }
        if let Some(place) = &state.grown_to {
            flow.set_grown_to(place.view())?;
        }
        flow.restore_pressures(&state.extrapolation, &state.volume_rate)?;
        flow.restore_taken(&state.taken);
        if flow.solved_by() != state.solved_by.as_deref() {
            flow.forget_gain();
        }
        match (edges, state.edges.take()) {
            (Some(edges), Some(state)) => edges.resume(&state, flow.force())?,
            (Some(edges), None) => edges.join(flow.force()),
            (None, _) => {}
        }
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
            true => cells.locate(position, x).unwrap_or(NONE),
            false => NONE,
        };
        self.probed = points.iter().map(place).collect();
    }

    /// Pressure in the pore of a watched point (Pa); NaN where there is none.
    pub fn probe_pressure(&self, point: usize) -> f64 {
        let pore = self.probed.get(point).and_then(|&i| self.flow.pressure().get(i as usize));
        pore.copied().unwrap_or(f64::NAN)
    }

    /// The fluid's force on each wall in the step to come, all else at rest (N). What pores store
    /// outlives a step, so that a force which grows goes on growing by its share; where nothing
    /// is stored, the force of the moment.
    pub fn expected_wall_force(&self) -> [Vec3; 6] {
        let (all, now) = (self.wall_force(), self.flow.wall_force());
        let Some(before) = self.state.wall_force_before else { return all };
        let share = &self.state.persistence.0;
        std::array::from_fn(|w| all[w] + share[w] * (now[w] - before[w]))
    }

    /// What the fluid takes off the outward force on a wall (first index) per outward velocity
    /// of another (N·s/m); 0 where nobody asked.
    pub fn resistance(&self) -> PerWall<PerWall<f64>> {
        let column = self.state.resistance.map(|column| column.unwrap_or_default());
        let mut all = PerWall::from_fn(|a| PerWall::from_fn(|b| column[b][a]));
        if let Some(edges) = &self.edges {
            for (wall, films) in edges.wall_resistance().iter() {
                all[wall][wall] += films;
            }
        }
        all
    }

    /// What a checkpoint needs, but for what is on its way.
    pub fn saved(&self) -> FluidState {
        FluidState {
            extrapolation: self.flow.extrapolation().clone(),
            volume_rate: self.flow.volume_rate().to_vec(),
            taken: self.flow.taken().to_vec(),
            time_step: self.flow.time_step(),
            solved_by: self.flow.solved_by().map(str::to_owned),
            edges: self.edges.as_ref().map(EdgeForces::state),
            ..self.state.clone()
        }
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
