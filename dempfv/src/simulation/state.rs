//! A simulation between two steps as one value that can be stored.

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::error_control::ErrorControl;
use super::outcome::StageOutcome;
use super::restart::{Origin, UnderWay};
use super::stages::Active;
use super::warning::Warning;
use crate::coupling::CoupledState;
use crate::io::checkpoint::Spheres;
use crate::scene::Plan;
use crate::{InputError, PerWall};

/// Everything that a checkpoint must hold to go on with the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulationState {
    /// First, so that a checkpoint can be read as a packing.
    pub(super) spheres: Spheres,
    pub(super) origin: Origin,
    pub(super) clock: Clock,
    pub(super) stage: u64,
    pub(super) active: Option<Active>,
    pub(super) stage_start: (u64, f64),
    pub(super) outcomes: Vec<StageOutcome>,
    pub(super) remeshes: u64,
    pub(super) warnings: Vec<Warning>,
    pub(super) stress_extremes: PerWall<[f64; 2]>,
    pub(super) error_control: Option<ErrorControl>,
    pub(super) coupled: CoupledState,
}

impl SimulationState {
    /// Steps done when the state was taken.
    pub fn step(&self) -> u64 {
        self.clock.step
    }

    /// Model time when the state was taken (s).
    pub fn time(&self) -> f64 {
        self.clock.time
    }

    /// The scene that the state was made with, as [`Plan::to_toml`] writes it.
    pub fn scene(&self) -> &str {
        &self.origin.scene
    }

    /// Number of the stage that was going on, or comes next.
    pub(super) fn stage(&self) -> usize {
        self.stage as usize
    }

    /// The same state of a run that keeps to no error.
    pub(super) fn without_error_control(&self) -> SimulationState {
        SimulationState { error_control: None, ..self.clone() }
    }

    /// How far the run had come, in the stages of these names.
    pub(super) fn under_way<'a>(&'a self, names: &'a [String]) -> UnderWay<'a> {
        let steps = self.clock.step - self.stage_start.0;
        let going = self.active.as_ref().zip(names.get(self.stage as usize));
        UnderWay {
            over: self.outcomes.iter().map(|o| o.name.as_str()).collect(),
            stage: going.map(|(active, name)| (name.as_str(), active.kind(), steps)),
        }
    }
}

/// Refuses a state that has come through other stages than the plan's; `names` are those of its own
/// scene.
pub(super) fn check_stages(
    plan: &Plan,
    state: &SimulationState,
    names: &[String],
) -> Result<(), InputError> {
    let remedy = "restart with the scene that the checkpoint was made with";
    if state.stage_start.0 > state.clock.step {
        let what = "the checkpoint's stage begins after its last step";
        return Err(InputError::new(what, "take a checkpoint that this program wrote"));
    }
    let begun = state.outcomes.len() + usize::from(state.active.is_some());
    if begun > plan.stages.len() {
        let what =
            format!("the checkpoint is in stage {begun}, the scene has {}", plan.stages.len());
        return Err(InputError::new(what, remedy));
    }
    let done = state.outcomes.iter().map(|o| (o.name.as_str(), o.outcome.kind()));
    let name = names.get(state.stage as usize).map_or("", String::as_str);
    let going = state.active.iter().map(|a| (name, a.kind()));
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
