//! Sums of energy by cause, as a checkpoint holds them.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::law::Losses;
use super::material::finite;

/// What the forces on a sphere, or on all, did in a step, or in all (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MotionWork {
    /// Taken by local damping.
    pub damping: f64,
    /// Done by the fluid.
    pub fluid: f64,
    /// Done by forces and torques that were added.
    pub external: f64,
    /// Done by what gives spheres their motion.
    pub motion: f64,
    /// Lost where the step is shorter than the one before, made where it is longer.
    pub step_change: f64,
}

impl MotionWork {
    /// Adds the work of others.
    pub fn join(&mut self, other: &MotionWork) {
        self.damping += other.damping;
        self.fluid += other.fluid;
        self.external += other.external;
        self.motion += other.motion;
        self.step_change += other.step_change;
    }
}

/// What the films of fluid between neighbours took from the energy of motion (J), by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FilmLosses {
    pub viscous_shear: f64,
    pub normal_lubrication: f64,
    pub shear_lubrication: f64,
    pub pump_torque: f64,
    pub twist_torque: f64,
    /// Held by the springs in series with the films.
    pub elastic: f64,
}

impl FilmLosses {
    /// Adds those of others.
    pub fn join(&mut self, other: &FilmLosses) {
        self.viscous_shear += other.viscous_shear;
        self.normal_lubrication += other.normal_lubrication;
        self.shear_lubrication += other.shear_lubrication;
        self.pump_torque += other.pump_torque;
        self.twist_torque += other.twist_torque;
        self.elastic += other.elastic;
    }

    /// What was dissipated.
    pub fn dissipated(&self) -> f64 {
        let FilmLosses { viscous_shear, normal_lubrication, shear_lubrication, .. } = self;
        viscous_shear
            + normal_lubrication
            + shear_lubrication
            + self.pump_torque
            + self.twist_torque
    }
}

/// The sums since tracking began. What a checkpoint holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Ledger {
    /// Kinetic and potential energy when it began (J).
    pub began_with: f64,
    pub losses: Losses,
    pub work: MotionWork,
    pub films: FilmLosses,
    /// Done by the walls.
    pub walls: f64,
    /// Done by the periodic cell.
    pub cell: f64,
    /// Length of the last step (s); 0 before the first.
    pub last_dt: f64,
}

impl Ledger {
    pub fn check(&self) -> Result<(), DemError> {
        let Ledger { began_with, losses, work, films, walls, cell, last_dt } = self;
        let MotionWork { damping, fluid, external, motion, step_change } = work;
        let films = films.dissipated() + films.elastic;
        let works = [*damping, *fluid, *external, *motion, *walls, *cell, films];
        let rest = [*began_with, losses.total(), *step_change, *last_dt];
        works.into_iter().chain(rest).try_for_each(|energy| finite("energy ledger", energy))
    }
}
