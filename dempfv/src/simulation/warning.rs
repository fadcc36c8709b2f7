//! What a user should know of a run that goes on all the same.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::estimate::UnstableStage;
use super::restart::Change;
use crate::domain::WallId;

/// A warning of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Warning {
    /// A fixed time step is above its limit.
    UnstableTimeStep(UnstableStage),
    /// A servo wall has not held its stress.
    ServoMissed(ServoMissed),
    /// The servo of a periodic cell has not held a stress.
    CellStressMissed(CellStressMissed),
    /// The load of a consolidation has not come at once.
    LateLoad(LateLoad),
    /// Bonds were made on contacts that carried a load.
    BondsUnderLoad(BondsUnderLoad),
    /// A restart has changed what is simulated.
    Restarted {
        /// Steps that were done before.
        step: u64,
        /// What it has changed.
        change: Change,
    },
}

/// A servo wall that did not hold the stress asked for in the last part of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoMissed {
    /// The stage's name.
    pub stage: String,
    /// The wall.
    pub wall: WallId,
    /// Stress asked for (Pa).
    pub asked: f64,
    /// Mean stress (Pa).
    pub mean: f64,
    /// Lowest and highest stress (Pa).
    pub range: [f64; 2],
}

impl fmt::Display for ServoMissed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ServoMissed { stage, wall, asked, mean, range: [low, high] } = self;
        write!(
            f,
            "stage \"{stage}\": the servo on {wall} was asked for {asked:.4e} Pa and got {mean:.4e} Pa in the last \
             part of the stage, from {low:.4e} to {high:.4e} Pa"
        )
    }
}

/// Bonds that were made on contacts that carried a load, which is gone with them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BondsUnderLoad {
    /// The name of the stage that began with making them.
    pub stage: String,
    /// Their number.
    pub loaded: u64,
    /// Bonds in all.
    pub made: u64,
}

impl fmt::Display for BondsUnderLoad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let BondsUnderLoad { stage, loaded, made } = self;
        write!(
            f,
            "stage \"{stage}\": {loaded} of {made} bonds were made on contacts that carried a load; a bond is made \
             without force, so their forces fell to 0 and the packing comes to rest anew"
        )
    }
}

/// A stress on a periodic cell that was not what was asked for in the last part of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellStressMissed {
    /// The stage's name.
    pub stage: String,
    /// The component, by the numbers of its two axes from 0 on.
    pub component: [u8; 2],
    /// Stress asked for (Pa).
    pub asked: f64,
    /// Mean stress (Pa).
    pub mean: f64,
    /// Lowest and highest stress (Pa).
    pub range: [f64; 2],
}

impl fmt::Display for CellStressMissed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CellStressMissed { stage, component, asked, mean, range: [low, high] } = self;
        let [a, b] = component.map(|axis| ["x", "y", "z"].get(usize::from(axis)).unwrap_or(&"?"));
        write!(
            f,
            "stage \"{stage}\": the cell was asked for a stress {a}{b} of {asked:.4e} Pa and got {mean:.4e} Pa in \
             the last part of the stage, from {low:.4e} to {high:.4e} Pa"
        )
    }
}

/// A consolidation whose load took a time that is not short beside that of the consolidation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LateLoad {
    /// The stage's name.
    pub stage: String,
    /// The loaded wall.
    pub wall: WallId,
    /// Time until nine tenths of the load were there (s); `None` where they never were.
    pub arrived: Option<f64>,
    /// Square of the drainage path over c_v (s).
    pub consolidation: f64,
}

impl fmt::Display for LateLoad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LateLoad { stage, wall, arrived, consolidation } = self;
        write!(f, "stage \"{stage}\": nine tenths of the load on {wall} were there ")?;
        match arrived {
            Some(after) => write!(f, "after {after:.3e} s, T_v = {:.3}", after / consolidation)?,
            None => f.write_str("at no time")?,
        }
        write!(
            f,
            ", and d²/c_v is {consolidation:.3e} s: the theory is that of a load put on at once; give a larger \
             max_velocity"
        )
    }
}

impl Warning {
    /// Whether another one says the same again, of the same stage.
    fn repeats(&self, other: &Warning) -> bool {
        match (self, other) {
            (Warning::UnstableTimeStep(a), Warning::UnstableTimeStep(b)) => a.stage == b.stage,
            (Warning::ServoMissed(a), Warning::ServoMissed(b)) => {
                (&a.stage, a.wall) == (&b.stage, b.wall)
            }
            (Warning::CellStressMissed(a), Warning::CellStressMissed(b)) => {
                (&a.stage, a.component) == (&b.stage, b.component)
            }
            (Warning::LateLoad(a), Warning::LateLoad(b)) => a.stage == b.stage,
            _ => false,
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::UnstableTimeStep(stage) => stage.fmt(f),
            Warning::ServoMissed(missed) => missed.fmt(f),
            Warning::CellStressMissed(missed) => missed.fmt(f),
            Warning::LateLoad(late) => late.fmt(f),
            Warning::BondsUnderLoad(bonds) => bonds.fmt(f),
            Warning::Restarted { step, change } => write!(f, "restart at step {step}: {change}"),
        }
    }
}

/// Adds a warning that was not given yet.
pub(super) fn warn(warnings: &mut Vec<Warning>, warning: Warning) {
    if !warnings.iter().any(|known| known.repeats(&warning)) {
        warnings.push(warning);
    }
}
