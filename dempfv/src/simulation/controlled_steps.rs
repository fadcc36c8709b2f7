//! Steps whose error is kept near a target: looks ahead of the run, and what is booked after each step.

use super::error_control::{Difference, ErrorControl, LOOKS, Most};
use super::error_estimate::ErrorEstimate;
use super::look_ahead::difference;
use super::run::Simulation;
use crate::Result;
use crate::scene::TimeStep;

/// An estimate so many times the target is warned of.
const MISSED: f64 = 2.0;

impl Simulation {
    /// What the run has chosen to keep to an error; `None` without `[accuracy]`.
    pub fn error_control(&self) -> Option<&ErrorControl> {
        self.error_control.as_ref()
    }

    /// The estimated error of the pore pressures so far; `None` without `[accuracy]`, and before the first of
    /// them. Forces and pressures of a caller's own ([`Simulation::controls`]) are not in what looks ahead.
    pub fn error_estimate(&self) -> Option<ErrorEstimate> {
        self.error_control.as_ref()?.estimate(self.coupled.network_strain())
    }

    /// A warning where the estimate is well above the target.
    pub(super) fn missed_target(&self) -> Option<String> {
        let target = self.error_control.as_ref()?.target();
        let ErrorEstimate { total, network, time_step, .. } = self.error_estimate()?;
        (total > MISSED * target).then(|| {
            format!(
                "[accuracy] asks for an error of {target}, and {total:.1e} is estimated, {network:.1e} by the age of \
                 networks and {time_step:.1e} by the time step: ask for less, or look at what changes so fast"
            )
        })
    }

    /// Chooses what keeps the error of the next steps near its target.
    pub(super) fn control_error(&mut self) -> Result<()> {
        let Some(mut control) = self.error_control.take() else { return Ok(()) };
        let chosen = match self.is_coupled(self.stage) {
            true => self.choose(&mut control),
            false => Ok(()),
        };
        self.error_control = Some(control);
        chosen
    }

    fn choose(&mut self, control: &mut ErrorControl) -> Result<()> {
        let stage = &self.plan.stages[self.stage];
        let most = Most::of(&self.plan, stage);
        let step = self.clock.step;
        control.begin(self.stage, most, (step, self.clock.time));
        control.apply(&mut self.coupled)?;
        if !control.look_is_due(step) {
            return Ok(());
        }
        let before = control.share();
        let longest = self.plan.mechanics(stage).unwrap_or_default().dt;
        for look in 1..=LOOKS {
            let mut dt = self.coupled.automatic_time_step(control.share())?;
            if let TimeStep::Fixed(longest) = longest {
                dt = dt.min(longest);
            }
            let difference = difference(&self.plan, &self.state(), dt);
            let difference = match difference {
                Err(error) if look == LOOKS => return Err(error),
                found => found.unwrap_or(Difference::UNKNOWN),
            };
            if control.looked_ahead(difference, most) {
                break;
            }
        }
        control.pause_looks(step, control.share() < before);
        Ok(())
    }

    /// Books the errors of a step that was done.
    pub(super) fn book_error(&mut self, stage: usize) {
        if !self.is_coupled(stage) {
            return;
        }
        let Simulation { error_control, coupled, plan, clock, .. } = self;
        if let Some(control) = error_control {
            let most = Most::of(plan, &plan.stages[stage]);
            control.stepped(coupled, most, (clock.step, clock.time));
        }
    }
}
