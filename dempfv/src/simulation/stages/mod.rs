//! The stages of a scene, one file per kind. A stage holds what must survive a
//! checkpoint in the midst of it.

mod compact;
mod consolidate;
mod cycle;
mod permeability;
mod run;

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::outcome::{Consolidation, Outcome, StageOutcome};
use super::setup;
use crate::coupling::Coupled;
use crate::dem::WallControl;
use crate::scene::{Plan, StageKind, TimeStep};
use crate::{Aabb, InputError, Result, WallId};

/// What a stage works on.
pub(super) struct Context<'a> {
    pub plan: &'a Plan,
    pub coupled: &'a mut Coupled,
    pub clock: &'a mut Clock,
    pub outcomes: &'a [StageOutcome],
}

/// Whether a stage goes on.
pub(super) enum Progress {
    Running,
    Finished(Outcome),
}

/// The stage that is being carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Active {
    Compact(compact::State),
    Cycle(cycle::State),
    Permeability(permeability::State),
    Consolidate(consolidate::State),
    Run(run::State),
}

impl Active {
    pub fn start(kind: &StageKind, context: &mut Context) -> Result<Active> {
        // The last step of the stage before ends under its own friction, and
        // this one knows the stresses that it starts from; after a restart too.
        context.coupled.compute_contacts()?;
        for wall in WallId::ALL {
            context.coupled.controls().set_control(wall, WallControl::Fixed)?;
        }
        if !kind.is_coupled() {
            context.coupled.drain();
        }
        Ok(match kind {
            StageKind::Compact(plan) => Active::Compact(compact::State::start(plan, context)?),
            StageKind::Cycle(plan) => Active::Cycle(cycle::State::start(plan, context)?),
            StageKind::Permeability(plan) => Active::Permeability(permeability::State::start(plan)),
            StageKind::Consolidate(plan) => {
                Active::Consolidate(consolidate::State::start(plan, context)?)
            }
            StageKind::Run(plan) => Active::Run(run::State::start(plan, context)?),
        })
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        match self {
            Active::Compact(state) => state.advance(context),
            Active::Cycle(state) => state.advance(context),
            Active::Permeability(state) => state.advance(context),
            Active::Consolidate(state) => state.advance(context),
            Active::Run(state) => state.advance(context),
        }
    }

    /// The kind of the stage, as scenes name it.
    pub fn kind(&self) -> &'static str {
        match self {
            Active::Compact(_) => "compact",
            Active::Cycle(_) => "cycle",
            Active::Permeability(_) => "permeability",
            Active::Consolidate(_) => "consolidate",
            Active::Run(_) => "run",
        }
    }

    /// Share of the stage that is done.
    pub fn progress(&self, clock: &Clock) -> Option<f64> {
        match self {
            Active::Consolidate(state) => Some(state.progress(clock)),
            Active::Run(state) => Some(state.progress(clock)),
            Active::Compact(_) | Active::Cycle(_) | Active::Permeability(_) => None,
        }
    }

    /// The consolidation so far, if this is one.
    pub fn consolidation(&self) -> Option<&Consolidation> {
        match self {
            Active::Consolidate(state) => Some(state.so_far()),
            _ => None,
        }
    }

    /// Tells mechanics that were made anew what this stage has changed, and the
    /// stage how many steps the plan now allows it.
    pub fn restore(&mut self, coupled: &mut Coupled, plan: &Plan, kind: &StageKind) -> Result<()> {
        match (self, kind) {
            (Active::Compact(state), StageKind::Compact(stage)) => {
                state.allow(stage.max_steps);
                state.restore(coupled)
            }
            (Active::Cycle(state), StageKind::Cycle(stage)) => {
                state.allow(stage.max_steps);
                Ok(())
            }
            (Active::Consolidate(state), StageKind::Consolidate(stage)) => {
                state.allow(stage.max_steps);
                Ok(())
            }
            (Active::Run(state), StageKind::Run(stage)) => {
                state.allow(&stage.until);
                state.restore(coupled, plan)
            }
            _ => Ok(()),
        }
    }
}

impl Context<'_> {
    /// One step with the scene's time step, and with its fluid if the pores
    /// are filled.
    fn step(&mut self) -> Result<()> {
        let (wanted, safety) =
            self.plan.dem.as_ref().map_or((TimeStep::Auto, 0.8), |d| (d.dt, d.safety));
        self.step_with(wanted, safety)
    }

    /// One step with the largest safe time step, for dry stages that only look
    /// for equilibrium.
    fn quasi_static_step(&mut self) -> Result<()> {
        let safety = self.plan.dem.as_ref().map_or(0.8, |d| d.safety);
        self.step_with(TimeStep::Auto, safety)
    }

    fn step_with(&mut self, wanted: TimeStep, safety: f64) -> Result<()> {
        let dt = self.clock.next_dt(wanted, safety, self.coupled)?;
        self.coupled.step(dt)?;
        self.clock.advance();
        Ok(())
    }

    /// Fills the pores with the scene's fluid.
    fn saturate(&mut self) -> Result<()> {
        let fluid = self.plan.fluid.as_ref().ok_or_else(|| {
            InputError::new(
                "a coupled stage in a scene without fluid",
                "add a table [fluid] with its viscosity",
            )
        })?;
        self.coupled.saturate(setup::saturation(fluid));
        Ok(())
    }
}

/// Logarithmic strain along each axis, compression positive.
fn strain(from: &Aabb, to: &Aabb) -> [f64; 3] {
    from.size().zip_map(&to.size(), |a, b| (a / b).ln()).into()
}
