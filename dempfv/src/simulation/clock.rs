//! Model time and the time step.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::coupling::{Coupled, TimeStepBounds};
use crate::scene::TimeStep;

/// Model time and time step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Steps done since the start of the simulation.
    pub step: u64,
    /// Model time (s).
    pub time: f64,
    /// Current time step (s); 0 before the first.
    pub dt: f64,
    /// What the automatic time step follows from.
    pub bounds: Option<TimeStepBounds>,
}

impl Clock {
    pub fn new() -> Clock {
        Clock { step: 0, time: 0.0, dt: 0.0, bounds: None }
    }

    /// The time step of the next step (s).
    ///
    /// # Errors
    /// As a remesh, or when a solve fails.
    pub fn next_dt(&mut self, wanted: TimeStep, safety: f64, coupled: &mut Coupled) -> Result<f64> {
        if let TimeStep::Fixed(dt) = wanted {
            self.dt = dt;
            self.bounds = None;
            return Ok(dt);
        }
        self.dt = coupled.automatic_time_step(safety)?;
        self.bounds = coupled.automatic_bounds();
        Ok(self.dt)
    }

    /// Books a step that was done.
    pub fn advance(&mut self) {
        self.step += 1;
        self.time += self.dt;
    }
}
