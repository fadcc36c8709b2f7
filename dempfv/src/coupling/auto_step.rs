//! Steps with the automatic time step.

use super::coupled::Coupled;
use super::error::{Result, positive};
use super::options::Update;
use super::time_step::TimeStepBounds;

/// Where pores store fluid the bound goes with the time step: it is looked for in so many rounds.
const STEP_ROUNDS: usize = 6;
/// Time steps up to so many times that of the factor in use keep it.
const SPARED_STEP_RATIO: f64 = 1.1;

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
        let mut dt = self.bounded_time_step(safety)?;
        for _ in 0..STEP_ROUNDS {
            match self.factored_time_step() {
                // A little less than what is stable spares another factorization.
                Some(factored) if factored <= dt && dt <= SPARED_STEP_RATIO * factored => {
                    return Ok(factored);
                }
                // In the middle of what is kept: of a factor for the very bound the next bound may be
                // a hair less, and so on round after round and step after step.
                Some(_) => self.change_time_step(dt / SPARED_STEP_RATIO.sqrt())?,
                None => return Ok(dt),
            }
            dt = self.bounded_time_step(safety)?;
        }
        Ok(dt)
    }

    /// The share `safety` of what is stable with the network in use, and no more than collisions
    /// allow (s).
    fn bounded_time_step(&mut self, safety: f64) -> Result<f64> {
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

    /// Length of the step to come before it is chosen (s): that of the last one, or the contacts'
    /// bound.
    pub(super) fn expected_time_step(&mut self) -> f64 {
        if self.last_time_step > 0.0 { self.last_time_step } else { self.dem.safe_time_step(1.0) }
    }

    /// Lets the network in use serve steps of another length (s) where its pores store fluid. What
    /// bounds the time step is then to be looked at anew.
    fn change_time_step(&mut self, dt: f64) -> Result<()> {
        let Coupled { phases, remesher, .. } = self;
        if let Some(network) = &mut remesher.current {
            network.set_time_step(dt, phases)?;
            let fastest = std::mem::take(&mut network.state.fastest);
            network.state.fastest = fastest.outdated();
        }
        Ok(())
    }

    /// Length of the steps that the factor in use is for (s), where it goes with them.
    fn factored_time_step(&self) -> Option<f64> {
        let network = self.remesher.current.as_ref()?;
        network.flow.time_step().filter(|_| self.acceleration().update != Update::EveryStep)
    }
}
