//! `[accuracy]`: an error of the pore pressures that the run keeps to by itself.

use serde::Serialize;

use super::fluid::Fluid;
use super::keys::{Keyed, Keys};
use super::kind::number;
use super::schema::Schema;
use super::stage::Stage;
use super::table::Bound;
use super::wrong::Wrong;
use crate::coupling::Swap;
use crate::input::InputError;
use crate::{Effect, EffectKey, Family};

pub(super) static SCHEMA: Schema = Schema::table("[accuracy]", &["target"]);

/// What this effect says of itself.
pub const ERROR_CONTROL: Effect = Effect {
    name: "error control",
    family: Family::Numerics,
    equation: "remesh strain, tolerance and time step follow estimated errors of the pore pressures",
    source: "docs/accuracy.md",
    keys: &[EffectKey { key: "target in [accuracy]", unit: "", default: "none" }],
    needs: "pore flow",
    test: "dempfv/tests/error_control.rs",
};

/// An error that the run keeps to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// Relative error of the pore pressures that is wanted (1), above 0 and below 1. No default.
    pub target: f64,
}

impl Default for Accuracy {
    fn default() -> Accuracy {
        Accuracy { target: 0.01 }
    }
}

impl Keyed for Accuracy {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<(), InputError> {
        keys.need_number("target", number("", Bound::InsideUnit), &mut self.target)
    }
}

impl Accuracy {
    /// What leaves the error without an estimate.
    pub(super) fn wrong_in(&self, stages: &[Stage], fluid: Option<&Fluid>) -> Option<Wrong> {
        let coupled = |_: &&Fluid| stages.iter().any(|stage| stage.kind.is_coupled());
        let Some(fluid) = fluid.filter(coupled) else {
            let problem = "stands in a scene where no fluid flows between moving spheres";
            return Some(Wrong::new(problem, "leave it out: its error is that of pore pressures"));
        };
        let by_clock =
            fluid.acceleration.auto_interval || fluid.acceleration.swap == Swap::WhenReady;
        if by_clock {
            let problem = "stands beside a remesh that goes by the clock";
            let remedy =
                "leave out `remesh_interval = \"auto\"` and `swap = \"when ready\"` in [fluid]";
            return Some(Wrong::new(problem, remedy));
        }
        if fluid.effects.store() {
            let problem = "stands beside `bulk_modulus` in [fluid]: what such a fluid stores makes errors grow over \
                           many networks, which the estimate does not follow";
            return Some(Wrong::new(
                problem,
                "leave one of the two out; `dempfv accuracy` chooses settings, too",
            ));
        }
        None
    }
}
