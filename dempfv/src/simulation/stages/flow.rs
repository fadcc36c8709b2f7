//! `flow`: the fluid alone, through spheres at rest.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::coupling::Coupled;
use crate::scene;
use crate::simulation::clock::Clock;
use crate::simulation::outcome::{FlowTest, Outcome};
use crate::{Result, Vec3};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Step at which it began.
    start: u64,
    steps: u64,
    time_step: f64,
}

impl State {
    pub fn start(plan: &scene::FlowOnly, context: &mut Context) -> Result<State> {
        context.saturate()?;
        let start = context.clock.step;
        Ok(State { start, steps: plan.steps, time_step: plan.time_step() })
    }

    /// Goes on with what the plan now says.
    pub fn restore(&mut self, plan: &scene::FlowOnly) {
        (self.steps, self.time_step) = (plan.steps, plan.time_step());
    }

    pub fn progress(&self, clock: &Clock) -> f64 {
        (clock.step.saturating_sub(self.start) as f64 / self.steps as f64).min(1.0)
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        if context.stage_steps < self.steps {
            context.step_fluid(self.time_step)?;
            if context.clock.step - self.start < self.steps {
                return Ok(Progress::Running);
            }
        }
        Ok(Progress::finished(Outcome::Flow(Box::new(outcome(context.coupled)))))
    }
}

/// What the last step left.
fn outcome(coupled: &Coupled) -> FlowTest {
    let flow = coupled.storage_flow();
    let size = |f: &crate::pfv::Flow| (f.network().pores(), f.operators().unknowns());
    let (pores, unknowns) = flow.map_or((0, 0), size);
    FlowTest {
        flux_m3_s: flow.map_or([0.0; 6], |f| f.flux()),
        imposed_flux_m3_s: flow.map_or_else(Vec::new, |f| f.imposed_flux()),
        mean_pressure_pa: coupled.mean_pressure(),
        force_n: coupled.fluid_force().iter().sum::<Vec3>().into(),
        wall_force_n: flow.map_or([[0.0; 3]; 6], |f| f.wall_force().map(Into::into)),
        imbalance: flow.map_or(0.0, |f| f.imbalance()),
        pores: pores as u64,
        unknowns: unknowns as u64,
    }
}
