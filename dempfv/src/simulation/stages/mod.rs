//! The stages of a scene, one file per kind. A stage holds what must survive a
//! checkpoint in the midst of it.

mod cell_watch;
mod changes;
mod compact;
mod consolidate;
mod context;
mod cycle;
mod end;
mod flow;
mod permeability;
mod run;
mod servo_watch;
mod strain;
mod wall_layers;

use serde::{Deserialize, Serialize};

pub(super) use changes::Changes;
pub(super) use context::{Context, Progress};

use super::clock::Clock;
use super::outcome::Consolidation;
use super::setup;
use crate::coupling::Coupled;
use crate::dem::{CellControls, WallControl};
use crate::scene::{Plan, Stage, StageKind};
use crate::{Result, WallId};

/// The stage that is being carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Active {
    Compact(compact::State),
    Cycle(cycle::State),
    Permeability(permeability::State),
    Flow(flow::State),
    Consolidate(consolidate::State),
    Run(run::State),
}

impl Active {
    /// Begins the context's stage.
    pub fn start(context: &mut Context) -> Result<Active> {
        // The last step of the stage before ends under its own friction, and
        // this one knows the stresses that it starts from; after a restart too.
        if context.plan.moves() {
            context.coupled.compute_contacts()?;
        }
        for wall in WallId::ALL {
            context.coupled.controls().set_control(wall, WallControl::Fixed)?;
        }
        if context.coupled.dem().cell().is_some() {
            context.coupled.controls().set_cell_controls(CellControls::default())?;
        }
        if !context.stage.kind.has_conditions() {
            context.coupled.drain();
        }
        let damping = context.mechanics().options.damping;
        context.coupled.controls().set_damping(damping)?;
        let kind = &context.stage.kind;
        track_energy(context.coupled, context.plan, kind);
        Ok(match kind {
            StageKind::Compact(plan) => Active::Compact(compact::State::start(plan, context)?),
            StageKind::Cycle(plan) => Active::Cycle(cycle::State::start(plan, context)?),
            StageKind::Permeability(plan) => Active::Permeability(permeability::State::start(plan)),
            StageKind::Flow(plan) => Active::Flow(flow::State::start(plan, context)?),
            StageKind::Consolidate(plan) => {
                Active::Consolidate(consolidate::State::start(plan, context)?)
            }
            StageKind::Run(plan) => Active::Run(run::State::start(plan, context)?),
        })
    }

    /// One step, or the whole of a stage that has none. The damping that a stage
    /// has changed ends with it.
    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        let progress = match self {
            Active::Compact(state) => state.advance(context),
            Active::Cycle(state) => state.advance(context),
            Active::Permeability(state) => state.advance(context),
            Active::Flow(state) => state.advance(context),
            Active::Consolidate(state) => state.advance(context),
            Active::Run(state) => state.advance(context),
        }?;
        if let Progress::Finished(_) = progress {
            context.coupled.controls().set_damping(setup::options(context.plan).damping)?;
        }
        Ok(progress)
    }

    /// The kind of the stage, as scenes name it.
    pub fn kind(&self) -> &'static str {
        match self {
            Active::Compact(_) => "compact",
            Active::Cycle(_) => "cycle",
            Active::Permeability(_) => "permeability",
            Active::Flow(_) => "flow",
            Active::Consolidate(_) => "consolidate",
            Active::Run(_) => "run",
        }
    }

    /// Share of the stage that is done.
    pub fn progress(&self, clock: &Clock) -> Option<f64> {
        match self {
            Active::Consolidate(state) => Some(state.progress(clock)),
            Active::Run(state) => Some(state.progress(clock)),
            Active::Flow(state) => Some(state.progress(clock)),
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
    /// stage what the plan, in which it began at this step and time, now says of it.
    pub fn restore(
        &mut self,
        coupled: &mut Coupled,
        plan: &Plan,
        stage: &Stage,
        changes: &Changes,
        (start, clock): ((u64, f64), &Clock),
    ) -> Result<()> {
        let mechanics = plan.mechanics(stage).unwrap_or_default();
        coupled.controls().set_damping(mechanics.options.damping)?;
        track_energy(coupled, plan, &stage.kind);
        match (self, &stage.kind) {
            (Active::Compact(state), StageKind::Compact(stage)) => {
                state.restore(coupled, stage, plan, &mechanics)?;
                if changes.any() {
                    state.refresh_time_step();
                }
                Ok(())
            }
            (Active::Cycle(state), StageKind::Cycle(stage)) => {
                state.restore(coupled, stage, changes)
            }
            (Active::Permeability(state), StageKind::Permeability(stage)) => {
                *state = permeability::State::start(stage);
                Ok(())
            }
            (Active::Flow(state), StageKind::Flow(stage)) => {
                state.restore(stage);
                Ok(())
            }
            (Active::Consolidate(state), StageKind::Consolidate(stage)) => {
                state.restore(coupled, stage, changes, clock)
            }
            (Active::Run(state), StageKind::Run(stage)) => {
                state.restore(coupled, stage, plan, changes, (start, clock))
            }
            _ => Ok(()),
        }
    }
}

/// Tracks energy where the plan asks for it. Growth has no balance: radii and masses change.
fn track_energy(coupled: &mut Coupled, plan: &Plan, kind: &StageKind) {
    let tracked = match kind {
        StageKind::Compact(_) => false,
        // Nothing moves.
        StageKind::Permeability(_) | StageKind::Flow(_) => return,
        StageKind::Cycle(_) | StageKind::Consolidate(_) | StageKind::Run(_) => plan.output.energy,
    };
    if tracked != coupled.dem().tracks_energy() {
        coupled.controls().track_energy(tracked);
    }
}
