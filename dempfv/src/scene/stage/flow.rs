//! `kind = "flow"`: the fluid alone, through spheres at rest.

use serde::Serialize;

use crate::input::InputError;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{Count, Maybe, number};
use crate::scene::schema::Schema;
use crate::scene::table::Bound;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema =
    Schema::table("a flow stage", &["kind", "name", "time", "steps"]);

/// The flow through spheres at rest, under the conditions of the fluid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlowOnly {
    /// Length of the stage (s). `None`: one solve at the conditions of the moment. Default.
    pub time: Option<f64>,
    /// Steps that it is divided into. Default 1.
    pub steps: u64,
}

impl Default for FlowOnly {
    fn default() -> FlowOnly {
        FlowOnly { time: None, steps: 1 }
    }
}

impl Keyed for FlowOnly {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.take("time", &Maybe(number("s", Bound::Positive)), &mut self.time)?;
        keys.take("steps", &Count(1), &mut self.steps)?;
        let endless = self.time.is_none() && self.steps > 1;
        let wrong = || Wrong::new("stands without `time`", "add the length of the stage in s");
        keys.rule("steps", endless.then(wrong))
    }
}

impl FlowOnly {
    /// Length of its steps (s); 0 for the conditions of the moment.
    pub fn time_step(&self) -> f64 {
        self.time.map_or(0.0, |time| time / self.steps as f64)
    }

    /// What is wrong with it beside a fluid that stores something, or not.
    pub(super) fn wrong_with(&self, stores: bool) -> Option<Wrong> {
        let steady = self.time.is_none() && stores;
        let remedy = "give the stage its `time` (s) and the `steps` that this is divided into";
        steady.then(|| Wrong::new("has no `time`, but the fluid has a `bulk_modulus`", remedy))
    }
}
