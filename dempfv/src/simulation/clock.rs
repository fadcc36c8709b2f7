//! Model time and the time step.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::coupling::{Coupled, TimeStepBounds};
use crate::scene::TimeStep;

/// Steps between two looks at the automatic time step.
const REFRESH: u64 = 50;

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
    /// Steps left until the automatic time step is looked at again.
    left: u64,
}

impl Clock {
    pub fn new() -> Clock {
        Clock { step: 0, time: 0.0, dt: 0.0, bounds: None, left: 0 }
    }

    /// Makes the next step choose its time step anew.
    pub fn refresh(&mut self) {
        self.left = 0;
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
        let renewed = coupled.update_viscous_mode(false)?;
        if renewed || self.left == 0 {
            // Of the current positions, as after a restart; the step itself
            // finds this done.
            coupled.dem.compute_contacts()?;
            let bounds = coupled.time_step_bounds();
            self.dt = bounds.automatic(safety);
            self.bounds = Some(bounds);
            self.left = REFRESH;
        } else {
            self.left -= 1;
        }
        Ok(self.dt)
    }

    /// Books a step that was done.
    pub fn advance(&mut self) {
        self.step += 1;
        self.time += self.dt;
    }
}
