//! `[[motion]]`: spheres whose motion is given, and which they are.

use serde::Serialize;

use super::choice::SphereChoice;
use super::keys::{Keyed, Keys};
use super::kind::{Kind, Maybe, Vector};
use super::schema::Schema;
use super::stage::{Stage, StageName, begins_with};
use super::table::Value;
use super::time_function::InTime;
use super::wrong::Wrong;
use crate::dem::Motion;
use crate::dem::effects::PRESCRIBED_MOTION;
use crate::input::InputError;
use crate::{Effect, TimeFunction};

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[[motion]]",
    &["numbers", "center", "radius", "min", "max", "radii", "velocity", "spin", "about", "from"],
);

/// A motion that spheres are given from the beginning of a stage on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GivenMotion {
    /// Which spheres, by their places when the stage begins.
    #[serde(flatten)]
    pub which: SphereChoice,
    /// What they do. Default: they are held fast.
    #[serde(flatten)]
    pub motion: Motion,
    /// Name of the stage that begins with it. Default: the first.
    pub from: Option<String>,
}

/// Three values that may change with time.
struct Functions(&'static str);

impl Kind<[TimeFunction; 3]> for Functions {
    fn read(&self, value: &Value) -> Result<[TimeFunction; 3]> {
        let wanted = format!("three values in {}, each a number or a function of time", self.0);
        let items = value.items(&wanted)?;
        let read: Vec<TimeFunction> =
            items.iter().map(|item| InTime(self.0).read(item)).collect::<Result<_>>()?;
        read.try_into().map_err(|read: Vec<_>| {
            value.error(&format!("has {} values", read.len()), format!("give {wanted}"))
        })
    }

    fn wrong(&self, functions: &[TimeFunction; 3]) -> Option<Wrong> {
        functions.iter().find_map(|function| InTime(self.0).wrong(function))
    }

    fn write(&self, functions: &[TimeFunction; 3]) -> Option<String> {
        let all: Vec<String> =
            functions.iter().filter_map(|function| InTime(self.0).write(function)).collect();
        Some(format!("[{}]", all.join(", ")))
    }
}

impl Keyed for GivenMotion {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        self.which.keys(keys)?;
        keys.take("velocity", &Functions("m/s"), &mut self.motion.velocity)?;
        keys.take("spin", &Functions("rad/s"), &mut self.motion.spin)?;
        keys.take("about", &Maybe(Vector("m")), &mut self.motion.about)?;
        keys.take("from", &Maybe(StageName), &mut self.from)
    }
}

impl GivenMotion {
    /// What is wrong between the motion and the stages.
    pub(super) fn wrong_in(&self, stages: &[Stage]) -> Option<Wrong> {
        let begins = |(k, stage): (usize, &Stage)| self.begin_with(&stage.name, k == 0);
        let Some(first) = stages.iter().enumerate().position(begins) else {
            let from = self.from.as_deref().unwrap_or_default();
            let names: Vec<&str> = stages.iter().map(|s| s.name.as_str()).collect();
            let remedy = format!("give one of {}", names.join(", "));
            return Some(Wrong::new(format!("is from \"{from}\", which is no stage"), remedy));
        };
        stages[first..].iter().all(|stage| !stage.kind.moves()).then(|| {
            let problem =
                format!("is from \"{}\", and nothing moves from there on", stages[first].name);
            Wrong::new(problem, "name a stage that moves spheres, or leave the motion out")
        })
    }

    /// Whether this stage begins with it.
    pub(crate) fn begin_with(&self, stage: &str, is_first: bool) -> bool {
        begins_with(self.from.as_deref(), stage, is_first)
    }

    /// Names of the effects of these tables.
    pub(super) fn described(of: &[GivenMotion], moves: bool) -> [(&'static Effect, bool); 1] {
        [(&PRESCRIBED_MOTION, moves && !of.is_empty())]
    }
}
