//! Carries out a plan, one step at a time.

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::outcome::{Consolidation, LoadCycles, Outcome, PermeabilityTest, StageOutcome};
use super::setup;
use super::stages::{Active, Context, Progress};
use crate::coupling::{Coupled, FluidState, Observation, TimeStepBounds};
use crate::dem::{Dem, DemState};
use crate::scene::{Plan, Stage};
use crate::{Axis, Error, InputError, Result};

/// A plan being carried out.
///
/// [`advance`](Simulation::advance) does one step; between two steps the
/// caller may look, save the [`State`], or stop.
pub struct Simulation {
    plan: Plan,
    coupled: Coupled,
    clock: Clock,
    /// Index of the current stage; the number of stages when all are done.
    stage: usize,
    active: Option<Active>,
    stage_start: (u64, f64),
    outcomes: Vec<StageOutcome>,
    previous_remeshes: u64,
}

/// Everything that a checkpoint must hold to go on with the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    clock: Clock,
    stage: u64,
    active: Option<Active>,
    stage_start: (u64, f64),
    outcomes: Vec<StageOutcome>,
    remeshes: u64,
    largest_residual: f64,
    largest_imbalance: f64,
    dem: DemState,
    fluid: Option<FluidState>,
}

impl State {
    /// Steps done when the state was taken.
    pub fn step(&self) -> u64 {
        self.clock.step
    }

    /// Model time when the state was taken (s).
    pub fn time(&self) -> f64 {
        self.clock.time
    }
}

impl Simulation {
    /// Loads or draws the packing of a plan and puts it at rest in its box.
    ///
    /// # Errors
    /// When the packing is wrong, or the plan's values make no sense together.
    pub fn new(plan: Plan) -> Result<Simulation> {
        let coupled = setup::coupled(&plan, setup::mechanics(&plan)?);
        Ok(Simulation {
            plan,
            coupled,
            clock: Clock::new(),
            stage: 0,
            active: None,
            stage_start: (0, 0.0),
            outcomes: vec![],
            previous_remeshes: 0,
        })
    }

    /// Goes on from a state, with the same bits as if it had not stopped. What
    /// the plan allows a stage (`max_steps`) holds from here on.
    ///
    /// # Errors
    /// When the plan's stages are not those that the state has come through, or
    /// as a step.
    pub fn restart(plan: Plan, state: State) -> Result<Simulation> {
        let stage = state.stage as usize;
        check_stages(&plan, &state)?;
        let dem = Dem::from_state(
            state.dem,
            setup::material(&plan),
            setup::wall_material(&plan),
            setup::options(&plan),
        )?;
        let mut coupled = setup::coupled(&plan, dem);
        coupled.count_from(state.clock.step);
        coupled.remember_worst(state.largest_residual, state.largest_imbalance);
        let mut active = state.active;
        if let (Some(active), Some(stage)) = (&mut active, plan.stages.get(stage)) {
            active.restore(&mut coupled, &plan, &stage.kind)?;
        }
        // So that it can be observed before its first step; the step itself
        // finds this done. The stage has had its say on friction before.
        coupled.dem.compute_contacts()?;
        if let (Some(fluid), Some(saved)) = (&plan.fluid, state.fluid) {
            coupled.restore_fluid(setup::saturation(fluid), saved)?;
        }
        Ok(Simulation {
            plan,
            coupled,
            clock: state.clock,
            stage,
            active,
            stage_start: state.stage_start,
            outcomes: state.outcomes,
            previous_remeshes: state.remeshes,
        })
    }

    /// Does one step, or the whole of a stage that has no steps. Returns
    /// whether there is more to do.
    ///
    /// # Errors
    /// [`Error::AtStep`] says at which step what went wrong.
    pub fn advance(&mut self) -> Result<bool> {
        let step = self.clock.step;
        self.try_advance().map_err(|source| match source {
            Error::Input(input) => Error::Input(input),
            source => Error::AtStep { step, source: Box::new(source) },
        })
    }

    fn try_advance(&mut self) -> Result<bool> {
        let Some(stage) = self.plan.stages.get(self.stage) else { return Ok(false) };
        let mut context = Context {
            plan: &self.plan,
            coupled: &mut self.coupled,
            clock: &mut self.clock,
            outcomes: &self.outcomes,
        };
        let mut active = match self.active.take() {
            Some(active) => active,
            None => Active::start(&stage.kind, &mut context)?,
        };
        match active.advance(&mut context) {
            Ok(Progress::Finished(outcome)) => {
                let name = stage.name.clone();
                self.finish_stage(name, outcome);
            }
            Ok(Progress::Running) => self.active = Some(active),
            Err(error) => {
                // A checkpoint of the failure knows how far the stage came.
                self.active = Some(active);
                return Err(error);
            }
        }
        Ok(self.stage < self.plan.stages.len())
    }

    fn finish_stage(&mut self, name: String, outcome: Outcome) {
        let (step, time) = self.stage_start;
        let steps = self.clock.step - step;
        self.outcomes.push(StageOutcome {
            name,
            steps,
            model_time_s: self.clock.time - time,
            outcome,
        });
        self.stage += 1;
        self.stage_start = (self.clock.step, self.clock.time);
        self.clock.refresh();
        // Steps of growth are the mechanics' alone.
        self.coupled.count_from(self.clock.step);
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The stage that the next step belongs to; `None` when all are done.
    pub fn stage(&self) -> Option<&Stage> {
        self.plan.stages.get(self.stage)
    }

    /// Name of the stage that did the last step; of the first stage before it.
    pub fn last_stage(&self) -> &str {
        let done = self.outcomes.iter().rev().find(|o| o.steps > 0);
        match (self.stage(), done) {
            (Some(stage), _) if self.stage_steps() > 0 => &stage.name,
            (_, Some(outcome)) => &outcome.name,
            (stage, None) => stage.map_or("", |s| &s.name),
        }
    }

    /// How much of the current stage is done, 0 to 1; `None` where that cannot
    /// be known.
    pub fn stage_progress(&self) -> Option<f64> {
        self.active.as_ref()?.progress(&self.clock)
    }

    /// Steps done in the current stage.
    pub fn stage_steps(&self) -> u64 {
        self.clock.step - self.stage_start.0
    }

    /// Steps done in all stages.
    pub fn step(&self) -> u64 {
        self.clock.step
    }

    /// Model time (s).
    pub fn time(&self) -> f64 {
        self.clock.time
    }

    /// The last time step (s).
    pub fn dt(&self) -> f64 {
        self.clock.dt
    }

    /// The spheres and the fluid.
    pub fn coupled(&self) -> &Coupled {
        &self.coupled
    }

    /// Networks built so far, before a restart included.
    pub fn remeshes(&self) -> u64 {
        self.previous_remeshes + self.coupled.remeshes()
    }

    /// What the finished stages found out.
    pub fn outcomes(&self) -> &[StageOutcome] {
        &self.outcomes
    }

    /// The consolidation that is going on, as far as it has come.
    pub fn consolidation(&self) -> Option<&Consolidation> {
        self.active.as_ref()?.consolidation()
    }

    /// Scalars of the current state.
    pub fn observe(&self) -> Observation {
        self.coupled.observe()
    }

    /// The bounds that the automatic time step was last chosen by; `None` with
    /// a fixed one.
    pub fn time_step_bounds(&self) -> Option<TimeStepBounds> {
        self.clock.bounds
    }

    /// What a checkpoint must hold.
    pub fn state(&self) -> State {
        State {
            clock: self.clock,
            stage: self.stage as u64,
            active: self.active.clone(),
            stage_start: self.stage_start,
            outcomes: self.outcomes.clone(),
            remeshes: self.remeshes(),
            largest_residual: self.coupled.largest_residual(),
            largest_imbalance: self.coupled.largest_imbalance(),
            dem: self.coupled.dem.state(),
            fluid: self.coupled.fluid_state(),
        }
    }

    /// A hash of positions, velocities and pressures, of their very bits: the
    /// same run gives the same hash for any number of threads. Spheres count
    /// in the order of the user's numbers.
    pub fn state_hash(&self) -> String {
        let particles = self.coupled.dem.storage();
        let mut order: Vec<usize> = (0..particles.len()).collect();
        order.sort_unstable_by_key(|&i| particles.id[i]);
        let vectors = order.iter().flat_map(|&i| [particles.position[i], particles.velocity[i]]);
        let pressures = self.coupled.flow().map_or(&[][..], |f| f.pressure());
        let numbers = vectors.flat_map(|v| [v.x, v.y, v.z]).chain(pressures.iter().copied());
        // FNV-1a, 64 bits.
        let hash = numbers
            .flat_map(|x| x.to_bits().to_le_bytes())
            .fold(0xcbf2_9ce4_8422_2325u64, |h, byte| {
                (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
            });
        format!("{hash:016x}")
    }
}

/// Refuses a state that has come through other stages than the plan's.
fn check_stages(plan: &Plan, state: &State) -> Result<(), InputError> {
    let remedy = "restart with the scene that the checkpoint was made with";
    let begun = state.outcomes.len() + usize::from(state.active.is_some());
    if begun > plan.stages.len() {
        let what =
            format!("the checkpoint is in stage {begun}, the scene has {}", plan.stages.len());
        return Err(InputError::new(what, remedy));
    }
    let done = state.outcomes.iter().map(|o| (o.name.as_str(), o.outcome.kind()));
    let going = state.active.iter().map(|a| (plan.stages[begun - 1].name.as_str(), a.kind()));
    for ((name, kind), stage) in done.chain(going).zip(&plan.stages) {
        if (name, kind) != (stage.name.as_str(), stage.kind.name()) {
            let what = format!(
                "the checkpoint has a {kind} stage `{name}` where the scene has a {} stage `{}`",
                stage.kind.name(),
                stage.name
            );
            return Err(InputError::new(what, remedy));
        }
    }
    Ok(())
}

/// The last finished measurement of the oedometric modulus along an axis.
pub(super) fn last_cycles(outcomes: &[StageOutcome], axis: Axis) -> Option<&LoadCycles> {
    outcomes.iter().rev().find_map(|o| match &o.outcome {
        Outcome::Cycle(cycles) if Axis::of(cycles.wall) == axis => Some(cycles),
        _ => None,
    })
}

/// The last finished measurement of the permeability along an axis.
pub(super) fn last_permeability(
    outcomes: &[StageOutcome],
    axis: Axis,
) -> Option<&PermeabilityTest> {
    outcomes.iter().rev().find_map(|o| match &o.outcome {
        Outcome::Permeability(test) if test.axis == axis.name() => Some(test),
        _ => None,
    })
}
