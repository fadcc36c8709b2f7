//! Steps with the automatic time step.

use super::coupled::Coupled;
use super::error::{Result, positive};
use super::time_step::TimeStepBounds;

impl Coupled {
    /// One step with the automatic time step; returns it (s). `safety` is the
    /// share of the largest stable time step that is taken, 0.8 for instance.
    ///
    /// The first step is safe already: the network that it uses is built before
    /// its time step is chosen. The bounds are looked at again every 51 steps,
    /// with each new network, and when friction or damping change.
    ///
    /// # Errors
    /// As [`Coupled::step`].
    pub fn step_auto(&mut self, safety: f64) -> Result<f64> {
        let dt = self.automatic_time_step(safety)?;
        self.step(dt)?;
        Ok(dt)
    }

    /// The time step that [`Coupled::step_auto`] would take (s), for the next
    /// step alone: each call counts as one.
    ///
    /// # Errors
    /// As a remesh, or when a solve fails;
    /// [`CouplingError::Parameter`](super::CouplingError::Parameter) for a safety that is not
    /// positive.
    pub fn automatic_time_step(&mut self, safety: f64) -> Result<f64> {
        positive("safety", safety)?;
        let renewed = self.update_viscous_mode(false)?;
        let known = self.auto_time_step.known().filter(|_| !renewed);
        let bounds = match known {
            Some(bounds) => {
                self.auto_time_step.pass();
                bounds
            }
            None => {
                // Of the current positions, as after a restart; the step itself
                // finds this done.
                self.compute_contacts()?;
                let bounds = self.time_step_bounds();
                let steps = self.dem.steps_between_looks(bounds.automatic(safety));
                self.auto_time_step.looked(bounds, steps);
                bounds
            }
        };
        Ok(bounds.automatic(safety))
    }

    /// The bounds that the automatic time step was last chosen by; `None`
    /// before the first.
    pub fn automatic_bounds(&self) -> Option<TimeStepBounds> {
        self.auto_time_step.last()
    }

    /// Makes the next automatic time step look at its bounds anew, after
    /// something has changed that bears on them.
    pub fn refresh_time_step(&mut self) {
        self.auto_time_step.refresh();
    }
}
