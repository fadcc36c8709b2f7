//! `cycle`: dry load and unload cycles of one wall measure the oedometric
//! modulus.

use serde::{Deserialize, Serialize};

use super::changes::Changes;
use super::context::{Context, Progress};
use super::strain::logarithmic_strain;
use super::wall_layers::{self, Rest};
use crate::coupling::Coupled;
use crate::dem::WallControl;
use crate::simulation::StageError;
use crate::simulation::outcome::{LoadCycles, Outcome};
use crate::{Aabb, Axis, Result, WallId, scene};

/// Steps between two looks at the equilibrium.
const LOOK: u64 = 20;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    wall: WallId,
    from: f64,
    to: f64,
    /// Holds still to come: one at the lower stress, then two a cycle.
    holds: u64,
    unbalanced: f64,
    tolerance: f64,
    max_velocity: Option<f64>,
    max_steps: u64,
    steps: u64,
    reference: Aabb,
    strain: Vec<f64>,
    stress: Vec<f64>,
    /// Where all was at the last hold at the lower stress but the final one, and at the last at the
    /// higher; empty before.
    rests: Vec<Rest>,
}

impl State {
    pub fn start(plan: &scene::Cycle, context: &mut Context) -> Result<State> {
        let mut state = State {
            wall: plan.wall,
            from: 0.0,
            to: 0.0,
            holds: 0,
            unbalanced: 0.0,
            tolerance: 0.0,
            max_velocity: None,
            max_steps: 0,
            steps: 0,
            reference: context.coupled.dem().box_(),
            strain: vec![],
            stress: vec![],
            rests: vec![],
        };
        state.follow(plan);
        state.load(context.coupled)?;
        Ok(state)
    }

    /// Takes all but the wall from the plan.
    fn follow(&mut self, plan: &scene::Cycle) {
        self.from = plan.from;
        self.to = plan.to;
        self.holds = 1 + 2 * u64::from(plan.cycles);
        self.unbalanced = plan.unbalanced;
        self.tolerance = plan.tolerance;
        self.max_velocity = plan.max_velocity;
        self.max_steps = plan.max_steps;
    }

    pub fn restore(
        &mut self,
        coupled: &mut Coupled,
        plan: &scene::Cycle,
        changes: &Changes,
    ) -> Result<()> {
        self.follow(plan);
        match ["from", "to", "max_velocity"].iter().any(|key| changes.in_stage(key)) {
            true => self.load(coupled),
            false => Ok(()),
        }
    }

    fn goal(&self) -> f64 {
        if self.strain.len().is_multiple_of(2) { self.from } else { self.to }
    }

    fn load(&self, coupled: &mut Coupled) -> Result<()> {
        let control = WallControl::Servo { stress: self.goal(), max_velocity: self.max_velocity };
        Ok(coupled.controls().set_control(self.wall, control)?)
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        context.step()?;
        self.steps += 1;
        if !self.steps.is_multiple_of(LOOK) {
            return Ok(Progress::Running);
        }
        let stress = context.coupled.wall_stress(self.wall);
        let unbalanced = context.coupled.unbalanced_force();
        if (stress - self.goal()).abs() > self.tolerance * self.goal()
            || unbalanced > self.unbalanced
        {
            if self.steps >= self.max_steps {
                let (steps, goal) = (self.steps, self.goal());
                return Err(StageError::NotSettled { steps, stress, goal, unbalanced }.into());
            }
            return Ok(Progress::Running);
        }
        self.strain.push(
            logarithmic_strain(&self.reference, &context.coupled.dem().box_())[self.wall.axis()],
        );
        self.stress.push(stress);
        // The last hold is one at the lower stress, also where a restart asks for fewer.
        if (self.strain.len() as u64) < self.holds || self.strain.len().is_multiple_of(2) {
            self.load(context.coupled)?;
            self.rests.truncate((self.strain.len() + 1) % 2);
            self.rests.push(Rest::of(context.coupled));
            return Ok(Progress::Running);
        }
        Ok(Progress::finished(Outcome::Cycle(self.result(context)?)))
    }

    fn result(&self, context: &Context) -> Result<LoadCycles> {
        let last = self.strain.len() - 1;
        let secant = |a: usize, b: usize| {
            (self.stress[b] - self.stress[a]) / (self.strain[b] - self.strain[a])
        };
        let layers = match (&self.rests[..], &context.plan.fluid) {
            ([lower, higher], Some(fluid)) => {
                let (rests, axis) = ([lower, higher], Axis::of(self.wall));
                Some(wall_layers::settlement(rests, context.coupled, &fluid.fluid, axis)?)
            }
            _ => None,
        };
        Ok(LoadCycles {
            wall: self.wall,
            modulus_pa: secant(last - 2, last - 1),
            unloading_modulus_pa: secant(last - 1, last),
            strain: self.strain.clone(),
            stress_pa: self.stress.clone(),
            wall_layer_settlement: layers,
        })
    }
}
