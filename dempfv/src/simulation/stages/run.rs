//! `run`: a number of steps under given wall motions.

use serde::{Deserialize, Serialize};

use super::cell_watch::CellWatch;
use super::changes::Changes;
use super::context::{Context, Progress};
use super::servo_watch::ServoWatch;
use super::strain::Reference;
use crate::coupling::Coupled;
use crate::scene::{self, Plan, Until};
use crate::simulation::StageError;
use crate::simulation::clock::Clock;
use crate::simulation::outcome::{CellState, Outcome, StressPath, StressPathSample};
use crate::simulation::setup;
use crate::{Axis, Result, Tensor, WallId};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    end: End,
    reference: Reference,
    steps: u64,
    start_time: f64,
    /// Share of the stage that is done, where the strain ends it.
    strained: f64,
    samples: Vec<StressPathSample>,
    /// How many of them there are beyond the share that is done: a restart may have made the
    /// stage longer.
    ahead: u64,
    servos: ServoWatch,
    cell: CellWatch,
}

/// Moments of the stage's course that are kept.
const SAMPLES: f64 = 200.0;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum End {
    Step(u64, u64),
    Time(f64, f64),
    Strain { goal: f64, axis: usize, max_steps: u64 },
}

impl End {
    /// The end of a stage that began at this step and time (s).
    fn of(until: Until, (step, time): (u64, f64)) -> End {
        match until {
            Until::Steps(steps) => End::Step(step, step + steps),
            Until::Time(length) => End::Time(time, time + length),
            Until::Strain { strain, axis, max_steps } => {
                End::Strain { goal: strain, axis: axis.index(), max_steps }
            }
        }
    }
}

impl State {
    pub fn start(plan: &scene::Run, context: &mut Context) -> Result<State> {
        for (wall, control) in plan.walls.iter() {
            context.coupled.controls().set_control(wall, *control)?;
        }
        set_cell(context.coupled, plan)?;
        if plan.fluid {
            context.saturate()?;
        }
        let clock = &context.clock;
        let state = State {
            end: End::of(plan.until, (clock.step, clock.time)),
            reference: Reference::new(context.coupled),
            steps: 0,
            start_time: clock.time,
            strained: 0.0,
            samples: vec![],
            ahead: 0,
            servos: ServoWatch::default(),
            cell: CellWatch::of(context.coupled),
        };
        set_friction(context.coupled, plan, context.plan)?;
        Ok(state)
    }

    /// `start` has step and time at which the stage began.
    pub fn restore(
        &mut self,
        coupled: &mut Coupled,
        plan: &scene::Run,
        scene: &Plan,
        changes: &Changes,
        (start, clock): ((u64, f64), &Clock),
    ) -> Result<()> {
        set_friction(coupled, plan, scene)?;
        for (wall, control) in plan.walls.iter().filter(|(wall, _)| changes.of_wall(*wall)) {
            coupled.controls().set_control(wall, *control)?;
        }
        let moves = changes.in_stage("velocity_gradient") || changes.in_stage("cell_stress");
        if moves {
            set_cell(coupled, plan)?;
        }
        self.end = End::of(plan.until, start);
        let end = ["steps", "time", "until"].iter().any(|key| changes.in_stage(key));
        if end {
            self.look_at_strain(coupled);
            let share = (self.progress(clock) * SAMPLES) as u64;
            self.ahead = (self.samples.len() as u64).saturating_sub(share);
        }
        if end || changes.in_stage("walls") {
            self.servos = ServoWatch::default();
        }
        if end || moves {
            self.cell = CellWatch::of(coupled);
        }
        Ok(())
    }

    fn sample(&self, context: &Context) -> StressPathSample {
        let coupled = &context.coupled;
        StressPathSample {
            time_s: context.clock.time - self.start_time,
            strain: self.reference.strain(coupled),
            stress_pa: [Axis::X, Axis::Y, Axis::Z].map(|axis| coupled.axis_stress(axis)),
            mean_pressure_pa: coupled.mean_pressure(),
            cell: self.cell(coupled),
        }
    }

    fn cell(&self, coupled: &Coupled) -> Option<CellState> {
        let (seen, strain) = (coupled.observe_cell()?, self.reference.cell_strain(coupled)?);
        let rows = |t: Tensor| [0, 1, 2].map(|a| [0, 1, 2].map(|b| t[(a, b)]));
        let porosity = coupled.dem().porosity();
        Some(CellState { strain: rows(strain), stress_pa: rows(seen.stress), porosity })
    }

    pub fn progress(&self, clock: &Clock) -> f64 {
        match self.end {
            End::Step(from, to) => {
                clock.step.saturating_sub(from) as f64 / to.saturating_sub(from).max(1) as f64
            }
            End::Time(from, to) => (clock.time - from) / (to - from),
            End::Strain { .. } => self.strained,
        }
    }

    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        if !self.is_over(context)? {
            context.step()?;
            self.steps += 1;
            let over = self.is_over(context)?;
            let progress = self.progress(context.clock);
            self.servos.look(context, progress);
            self.cell.look(context, progress);
            let share = (self.samples.len() as u64).saturating_sub(self.ahead);
            if over || self.progress(context.clock) * SAMPLES >= share as f64 {
                self.samples.push(self.sample(context));
            }
            if !over {
                return Ok(Progress::Running);
            }
        }
        self.servos.warn(context);
        self.cell.warn(context);
        setup::own_materials(context.coupled, context.plan)?;
        let coupled = &context.coupled;
        Ok(Progress::Finished(Outcome::Run(StressPath {
            strain: self.reference.strain(coupled),
            cell: self.cell(coupled).map(Box::new),
            wall_stress_pa: WallId::ALL.map(|w| coupled.wall_stress(w)),
            unbalanced_force: coupled.unbalanced_force(),
            samples: std::mem::take(&mut self.samples),
        })))
    }

    /// Strain of the box where one ends the stage, else 0.
    fn look_at_strain(&mut self, coupled: &Coupled) -> f64 {
        let End::Strain { goal, axis, .. } = self.end else { return 0.0 };
        let strain = self.reference.strain(coupled)[axis];
        self.strained = (strain / goal).clamp(0.0, 1.0);
        strain
    }

    fn is_over(&mut self, context: &Context) -> Result<bool> {
        match self.end {
            End::Step(_, to) => Ok(context.clock.step >= to),
            // Half a time step short counts as there, so that round-off in the
            // sum of time steps adds none.
            End::Time(_, to) => {
                Ok(self.steps > 0 && context.clock.time >= to - 0.5 * context.clock.dt)
            }
            End::Strain { goal, max_steps, .. } => {
                let now = self.look_at_strain(context.coupled);
                if now / goal < 1.0 && self.steps >= max_steps {
                    return Err(StageError::StrainNotReached {
                        steps: self.steps,
                        strain: now,
                        goal,
                    }
                    .into());
                }
                Ok(now / goal >= 1.0)
            }
        }
    }
}

/// What moves the periodic cell in the stage, where there is one.
fn set_cell(coupled: &mut Coupled, plan: &scene::Run) -> Result<()> {
    if coupled.dem().cell().is_some() {
        coupled.controls().set_cell_controls(*plan.cell)?;
    }
    Ok(())
}

/// Friction of the stage, else that of the scene's materials.
fn set_friction(coupled: &mut Coupled, plan: &scene::Run, scene: &Plan) -> Result<()> {
    setup::own_materials(coupled, scene)?;
    match plan.friction_angle {
        Some(angle) => Ok(coupled.controls().set_friction(angle)?),
        None => Ok(()),
    }
}
