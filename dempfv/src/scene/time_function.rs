//! A value that may change with time: a number, a ramp or a sine.

use super::kind::{Kind, inline, number};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::TimeFunction;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("a function of time", &["ramp", "mean", "amplitude", "frequency"]);

/// A value in a unit that may change with time.
#[derive(Clone, Copy)]
pub(super) struct InTime(pub &'static str);

impl Kind<TimeFunction> for InTime {
    fn read(&self, value: &Value) -> Result<TimeFunction> {
        if !value.is_table() {
            return Ok(TimeFunction::Constant(value.number(self.0, Bound::Finite)?));
        }
        let table = value.table(&SCHEMA)?;
        let function = if let Some(ramp) = table.get("ramp") {
            let points = ramp.items("an array of points [time, value]")?;
            let point = |point: &Value| match point.items("a point [time, value]")?.as_slice() {
                [t, v] => Ok([t.number("s", Bound::Finite)?, v.number(self.0, Bound::Finite)?]),
                other => Err(point.error(
                    &format!("has a point of {} numbers", other.len()),
                    "give [time, value]",
                )),
            };
            if let Some(other) =
                ["mean", "amplitude", "frequency"].iter().find_map(|k| table.get(k))
            {
                return Err(other.error("stands beside a ramp", "give a ramp or a sine"));
            }
            TimeFunction::Ramp(points.iter().map(point).collect::<Result<_>>()?)
        } else {
            let part = |key: &str, what: &str, unit: &str| {
                table.need(key, what)?.number(unit, Bound::Finite)
            };
            TimeFunction::Sine {
                mean: part("mean", "what it swings about", self.0)?,
                amplitude: part("amplitude", "how far it swings", self.0)?,
                frequency: part("frequency", "how often, in Hz", "Hz")?,
            }
        };
        self.wrong(&function).map_or(Ok(function), |wrong| Err(value.wrong(wrong)))
    }

    fn wrong(&self, function: &TimeFunction) -> Option<Wrong> {
        if let TimeFunction::Constant(value) = function {
            return number(self.0, Bound::Finite).wrong(value);
        }
        let (problem, remedy) = function.problem()?;
        Some(Wrong::new(problem, remedy))
    }

    fn write(&self, function: &TimeFunction) -> Option<String> {
        Some(match function {
            TimeFunction::Constant(value) => format!("{value:?}"),
            TimeFunction::Ramp(points) => {
                let points: Vec<String> =
                    points.iter().map(|[t, v]| format!("[{t:?}, {v:?}]")).collect();
                inline(&[("ramp", format!("[{}]", points.join(", ")))])
            }
            TimeFunction::Sine { mean, amplitude, frequency } => inline(&[
                ("mean", format!("{mean:?}")),
                ("amplitude", format!("{amplitude:?}")),
                ("frequency", format!("{frequency:?}")),
            ]),
        })
    }
}
