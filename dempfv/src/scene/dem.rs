//! `[dem]`: how the spheres are moved.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Flag, Kind, Maybe, Number, Vector, number, quoted};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::DemOptions;
use crate::dem::effects::{GRAVITY, LOCAL_DAMPING, ROTATION};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("[dem]", &["dt", "safety", "damping", "gravity", "rotation"]);

/// Local damping, here and in the stages.
pub(super) const DAMPING: Number = number("", Bound::BelowOne);

/// Settings of the mechanics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dem {
    /// Time step of every stage that does not say another. Default: automatic.
    pub dt: TimeStep,
    /// Share of the stable time step that the automatic one takes (1), in (0, 1]. Default 0.8.
    pub safety: f64,
    /// Local damping (default 0.2; a stage may say another), gravity (default none), rotation
    /// (default true). The skin of the neighbour list changes no result and is no key of scenes.
    #[serde(flatten)]
    pub options: DemOptions,
}

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// The smaller of the contact and (with fluid) the viscous time step, times `safety`.
    Auto,
    /// Always this (s).
    Fixed(f64),
}

impl Default for Dem {
    fn default() -> Dem {
        let options = DemOptions { damping: 0.2, ..DemOptions::default() };
        Dem { dt: TimeStep::Auto, safety: 0.8, options }
    }
}

impl Keyed for Dem {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.take("dt", &Steps, &mut self.dt)?;
        keys.take("safety", &number("", Bound::UpToOne), &mut self.safety)?;
        keys.take("damping", &DAMPING, &mut self.options.damping)?;
        let gravity = &mut self.options.gravity;
        keys.take("gravity", &Maybe(Vector("m/s²")), gravity)?;
        // An effect that is not there.
        *gravity = gravity.filter(|g| g.norm_squared() != 0.0);
        keys.take("rotation", &Flag, &mut self.options.rotation)
    }
}

impl Dem {
    /// Effects of this table, which are on where they are so in one of the stages that move
    /// spheres: `each` has their settings.
    pub(super) fn effects(each: &[Dem]) -> [(&'static Effect, bool); 3] {
        let any = |holds: fn(&DemOptions) -> bool| each.iter().any(|dem| holds(&dem.options));
        [
            (&ROTATION, any(|o| o.rotation)),
            (&GRAVITY, any(|o| o.gravity.is_some_and(|g| g.norm_squared() > 0.0))),
            (&LOCAL_DAMPING, any(|o| o.damping > 0.0)),
        ]
    }
}

/// A time step, or `"auto"`.
pub(super) struct Steps;

const DT: Number = number("s, or \"auto\"", Bound::Positive);

impl Kind<TimeStep> for Steps {
    fn read(&self, value: &Value) -> Result<TimeStep> {
        match value.is_name() {
            true => value.choice(&[("auto", TimeStep::Auto)]),
            false => DT.read(value).map(TimeStep::Fixed),
        }
    }

    fn wrong(&self, dt: &TimeStep) -> Option<Wrong> {
        match dt {
            TimeStep::Auto => None,
            TimeStep::Fixed(dt) => DT.wrong(dt),
        }
    }

    fn write(&self, dt: &TimeStep) -> Option<String> {
        match dt {
            TimeStep::Auto => Some(quoted("auto")),
            TimeStep::Fixed(dt) => DT.write(dt),
        }
    }
}
