//! `compact`: all radii grow in the fixed box until the walls feel a stress.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::Result;
use crate::coupling::{Coupled, Phase};
use crate::dem::{GrowthCompaction, GrowthOptions};
use crate::scene::{self, Plan, TimeStep};
use crate::simulation::outcome::{Compaction, Outcome};
use crate::simulation::setup;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    growth: GrowthCompaction,
}

impl State {
    pub fn start(plan: &scene::Compact, context: &mut Context) -> Result<State> {
        let mechanics = context.mechanics();
        let options = options(plan, context.plan, &mechanics);
        let mut state = State { growth: GrowthCompaction::new(options)? };
        state.restore(context.coupled, plan, context.plan, &mechanics)?;
        Ok(state)
    }

    pub fn restore(
        &mut self,
        coupled: &mut Coupled,
        plan: &scene::Compact,
        scene: &Plan,
        mechanics: &scene::Dem,
    ) -> Result<()> {
        self.growth.set_options(options(plan, scene, mechanics))?;
        self.growth.set_time_step(match mechanics.dt {
            TimeStep::Auto => None,
            TimeStep::Fixed(dt) => Some(dt),
        });
        if let Some(angle) = plan.friction_angle {
            coupled.controls().set_friction(angle)?;
        }
        Ok(())
    }

    /// Makes the next step choose its time step anew.
    pub fn refresh_time_step(&mut self) {
        self.growth.refresh_time_step();
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
        setup::own_materials(coupled, context.plan)?;
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

fn options(plan: &scene::Compact, scene: &Plan, mechanics: &scene::Dem) -> GrowthOptions {
    let mut options = GrowthOptions::new(plan.stress, scene.particles.material.young);
    options.unbalanced_tolerance = plan.unbalanced;
    options.stress_tolerance = plan.tolerance;
    options.max_steps = plan.max_steps;
    options.time_step_safety = mechanics.safety;
    options
}
