//! `compact`: all radii grow in the fixed box until the walls feel a stress.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::Result;
use crate::coupling::{Coupled, Phase};
use crate::dem::{GrowthCompaction, GrowthOptions};
use crate::scene::{self, TimeStep};
use crate::simulation::outcome::{Compaction, Outcome};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    growth: GrowthCompaction,
    friction_angle: Option<f64>,
}

impl State {
    pub fn start(plan: &scene::Compact, context: &mut Context) -> Result<State> {
        let mut options = GrowthOptions::new(plan.stress, context.plan.particles.material.young);
        options.unbalanced_tolerance = plan.unbalanced;
        options.stress_tolerance = plan.tolerance;
        options.max_steps = plan.max_steps;
        let mechanics = context.mechanics();
        options.time_step_safety = mechanics.safety;
        let mut state =
            State { growth: GrowthCompaction::new(options)?, friction_angle: plan.friction_angle };
        state.restore(context.coupled, &mechanics)?;
        Ok(state)
    }

    pub fn restore(&mut self, coupled: &mut Coupled, mechanics: &scene::Dem) -> Result<()> {
        self.growth.set_time_step(match mechanics.dt {
            TimeStep::Auto => None,
            TimeStep::Fixed(dt) => Some(dt),
        });
        if let Some(angle) = self.friction_angle {
            coupled.controls().set_friction(angle)?;
        }
        Ok(())
    }

    /// Changes how many steps the stage may take in all.
    pub fn allow(&mut self, max_steps: u64) {
        self.growth.set_max_steps(max_steps);
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        let growth = &mut self.growth;
        let coupled = &mut *context.coupled;
        let status = coupled.change_mechanics(Phase::Contacts, |dem| growth.step(dem))?;
        if !status.done {
            context.clock.dt = growth.time_step();
            context.clock.bounds = None;
            context.clock.advance();
            return Ok(Progress::Running);
        }
        coupled.controls().set_friction(context.plan.particles.material.friction_angle)?;
        // The spheres have found their places: neighbours in space become
        // neighbours in memory.
        coupled.sort_spatially()?;
        Ok(Progress::Finished(Outcome::Compact(Compaction {
            stress_pa: status.stress,
            unbalanced_force: status.unbalanced,
            porosity: coupled.dem().porosity(),
            coordination_number: coupled.dem().coordination_number(),
        })))
    }
}
