//! What a user should know of a run that goes on all the same.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::estimate::UnstableStage;

/// A warning of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Warning {
    /// A fixed time step is above its limit.
    UnstableTimeStep(UnstableStage),
}

impl Warning {
    /// Whether another one says the same again, of the same stage.
    fn repeats(&self, other: &Warning) -> bool {
        match (self, other) {
            (Warning::UnstableTimeStep(a), Warning::UnstableTimeStep(b)) => a.stage == b.stage,
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::UnstableTimeStep(stage) => stage.fmt(f),
        }
    }
}

/// Adds a warning that was not given yet.
pub(super) fn warn(warnings: &mut Vec<Warning>, warning: Warning) {
    if !warnings.iter().any(|known| known.repeats(&warning)) {
        warnings.push(warning);
    }
}
