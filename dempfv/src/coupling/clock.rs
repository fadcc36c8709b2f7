//! The time step and what bounds it.

use serde::{Deserialize, Serialize};

use crate::dem::Dem;
use crate::scene::TimeStep;

/// Steps between two looks at the automatic time step.
const REFRESH: u64 = 50;

/// Model time and time step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Steps done since the start of the simulation.
    pub step: u64,
    /// Model time (s).
    pub time: f64,
    /// Current time step (s); 0 before the first.
    pub dt: f64,
    /// Steps left until the automatic time step is looked at again.
    left: u64,
}

impl Clock {
    pub fn new() -> Clock {
        Clock { step: 0, time: 0.0, dt: 0.0, left: 0 }
    }

    /// Makes the next step choose its time step anew.
    pub fn refresh(&mut self) {
        self.left = 0;
    }

    /// The time step of the next step.
    pub fn next_dt(
        &mut self,
        wanted: TimeStep,
        safety: f64,
        dem: &Dem,
        viscosity: Option<f64>,
    ) -> f64 {
        if let TimeStep::Fixed(dt) = wanted {
            self.dt = dt;
        } else if self.left == 0 {
            self.dt = TimeStepBounds::of(dem, viscosity).automatic(safety);
            self.left = REFRESH;
        } else {
            self.left -= 1;
        }
        self.dt
    }

    /// Books a step that was done.
    pub fn advance(&mut self) {
        self.step += 1;
        self.time += self.dt;
    }
}

/// What bounds the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStepBounds {
    /// Stability of the contacts, eq. A.2 of Caulk 2020, from the stiffness of
    /// each sphere's live contacts, and of a first one of the lightest (s).
    pub contact: f64,
    /// Viscous bound, eq. A.11 of Caulk 2020 (s); `None` without fluid.
    pub viscous: Option<f64>,
}

impl TimeStepBounds {
    /// The bounds for the current state; `viscosity` in Pa·s.
    pub fn of(dem: &Dem, viscosity: Option<f64>) -> TimeStepBounds {
        TimeStepBounds {
            contact: dem.safe_time_step(1.0),
            viscous: viscosity
                .map(|mu| viscous_time_step(&dem.particles().radius, dem.material().density, mu)),
        }
    }

    /// The smaller bound times the safety factor (s).
    pub fn automatic(&self, safety: f64) -> f64 {
        safety * self.viscous.map_or(self.contact, |v| v.min(self.contact))
    }
}

/// `2 min(π ρ d² / (8000 μ))`, eq. A.11 of Caulk 2020 (s).
pub fn viscous_time_step(radius: &[f64], density: f64, viscosity: f64) -> f64 {
    let smallest = radius.iter().copied().fold(f64::INFINITY, f64::min);
    2.0 * std::f64::consts::PI * density * (2.0 * smallest).powi(2) / (8000.0 * viscosity)
}
