//! The fluid's part of a step: what it feels of the spheres, beside their contacts or without any.

use super::active_network::{ActiveNetwork, SolidGeometry, SolidMotion};
use super::coupled::Coupled;
use super::error::{Result, positive};
use super::given_pressures::Conditions;
use super::options::Update;
use super::phases::{Phase, Phases};
use crate::Vec3;
use crate::dem::{Dem, DemError, PeriodicCell, WallControl};

impl Coupled {
    /// Advances the fluid alone by `dt` (s): spheres and walls stand still, and no contact is
    /// computed. Where the pores are empty, only time goes by. 0 gives the flow of the moment, of a
    /// fluid that nothing stores.
    ///
    /// # Errors
    /// As [`Coupled::step`].
    pub fn step_fluid(&mut self, dt: f64) -> Result<()> {
        if dt != 0.0 || self.effects.store() {
            positive("time step", dt)?;
        }
        if let Some(saturation) = self.saturation {
            self.prepare_network(&saturation, dt)?;
            self.remesher.begin_step();
            self.advance_fluid(dt, false)?;
            self.book_solve();
        }
        self.steps += 1;
        self.last_time_step = dt;
        self.time += dt;
        Ok(())
    }

    /// Pressures and forces of a step whose network is there, in which spheres and walls move or
    /// stand still.
    pub(super) fn advance_fluid(&mut self, dt: f64, moves: bool) -> Result<()> {
        let Coupled { dem, phases, remesher, effects, given, time, .. } = self;
        let follow = remesher.acceleration().update == Update::EveryStep;
        let Some(network) = &mut remesher.current else { return Ok(()) };
        let position = &dem.storage().position;
        let conditions = Conditions { effects, given, time: *time + dt };
        let mut motion = motion(dem, &dem.storage().velocity, dt, conditions);
        motion.moves = moves;
        motion.squeezes &= moves;
        motion.follows = follow;
        if follow || effects.store() {
            let cell = dem.cell().map(PeriodicCell::cell);
            motion.geometry = Some(SolidGeometry { position, bounds: dem.box_(), cell });
        }
        network.advance(&motion, phases)
    }

    /// Contact forces, and beside them the fluid's: both follow from positions
    /// and velocities of before the step, so the bits are those of one after
    /// the other.
    pub(super) fn contacts_beside_fluid(&mut self, dt: f64) -> Result<()> {
        let Coupled { dem, remesher, phases, overlap, effects, given, time, .. } = self;
        overlap.velocity.clone_from(&dem.storage().velocity);
        let conditions = Conditions { effects, given, time: *time + dt };
        let mut motion = motion(dem, &overlap.velocity, dt, conditions);
        motion.follows = remesher.acceleration().update == Update::EveryStep;
        let cell = dem.cell().map(|cell| *cell.cell());
        if motion.follows || effects.store() {
            overlap.position.clone_from(&dem.storage().position);
            let (position, bounds) = (&overlap.position, dem.box_());
            motion.geometry = Some(SolidGeometry { position, bounds, cell: cell.as_ref() });
        }
        let mut fluid_phases = Phases::default();
        let mut contact_phases = Phases::default();
        let (contacts, fluid): (Result<(), DemError>, Result<()>) = rayon::join(
            || contact_phases.time(Phase::Contacts, || dem.compute_contacts()),
            || match &mut remesher.current {
                Some(network) => network.advance(&motion, &mut fluid_phases),
                None => Ok(()),
            },
        );
        phases.merge(&contact_phases);
        phases.merge(&fluid_phases);
        contacts?;
        fluid
    }

    /// Counts what the last solve left.
    pub(super) fn book_solve(&mut self) {
        self.compare_with_replaced();
        if let Some(ActiveNetwork { flow, iterations, state, .. }) = &self.remesher.current {
            if let Some(solve) = iterations {
                self.update_counts.add(*solve, state.exhausted);
            }
            let iterated = iterations.map(|solve| solve.error).filter(|&e| e > flow.tolerance());
            if let Some(left) = iterated.or(flow.unmet_tolerance()) {
                self.unmet_tolerance.add(self.steps, left);
            }
            self.largest_residual = self.largest_residual.max(flow.residual().unwrap_or(0.0));
            self.largest_imbalance = self.largest_imbalance.max(flow.imbalance());
        }
    }
}

/// What the fluid feels in a step from `dt` on (s).
pub(super) fn motion<'a>(
    dem: &Dem,
    velocity: &'a [Vec3],
    dt: f64,
    conditions: Conditions<'a>,
) -> SolidMotion<'a> {
    let walls = dem.walls();
    SolidMotion {
        velocity,
        walls: walls.map(|w| w.velocity).0,
        dilation: dem.cell().map_or(0.0, |cell| cell.velocity_gradient().trace()),
        servo: walls.map(|w| matches!(w.control, WallControl::Servo { .. })).0,
        dt,
        conditions: conditions.change().then_some(conditions),
        squeezes: !conditions.effects.one_way,
        moves: true,
        geometry: None,
        follows: false,
    }
}
