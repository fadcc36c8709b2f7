//! What a stage works on.

use crate::coupling::Coupled;
use crate::scene::{Dem, Plan, Stage};
use crate::simulation::clock::Clock;
use crate::simulation::outcome::{Outcome, StageOutcome};
use crate::{InputError, Result};

/// What a stage works on.
pub(in crate::simulation) struct Context<'a> {
    pub plan: &'a Plan,
    /// The stage that is carried out.
    pub stage: &'a Stage,
    pub coupled: &'a mut Coupled,
    pub clock: &'a mut Clock,
    pub outcomes: &'a [StageOutcome],
}

/// Whether a stage goes on.
pub(in crate::simulation) enum Progress {
    Running,
    Finished(Outcome),
}

impl Context<'_> {
    /// The mechanics of the stage: those of the scene, with what the stage says
    /// otherwise; the defaults where nothing moves.
    pub fn mechanics(&self) -> Dem {
        self.plan.mechanics(self.stage).unwrap_or_default()
    }

    /// One step with the time step of the stage, and with the scene's fluid if
    /// the pores are filled.
    pub fn step(&mut self) -> Result<()> {
        let Dem { dt, safety, .. } = self.mechanics();
        let dt = self.clock.next_dt(dt, safety, self.coupled)?;
        self.coupled.step(dt)?;
        self.clock.advance();
        Ok(())
    }

    /// Fills the pores with the scene's fluid.
    pub fn saturate(&mut self) -> Result<()> {
        let fluid = self.plan.fluid.as_ref().ok_or_else(|| {
            InputError::new(
                "a coupled stage in a scene without fluid",
                "add a table [fluid] with its viscosity",
            )
        })?;
        self.coupled.saturate(fluid.saturation());
        Ok(())
    }
}
