//! When a run stage ends: after steps or time, or at a state that it comes to.

use serde::Serialize;

use crate::domain::Axis;
use crate::input::InputError;
use crate::scene::keys::Keys;
use crate::scene::kind::{AN_AXIS, AXIS, Count, Kind, Number, inline, number, quoted};
use crate::scene::schema::Schema;
use crate::scene::table::{Bound, Table, Value};
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "`until`",
    &["strain", "stress", "porosity", "unbalanced", "tolerance", "axis", "max_steps"],
);

/// When a run stage ends. One that ends at a state gives up after `max_steps` steps, by default
/// 5,000,000.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Until {
    /// After so many steps.
    Steps(u64),
    /// After so much model time (s).
    Time(f64),
    /// When the box has this strain since the start of the stage.
    Strain {
        /// Logarithmic strain (1), positive in compression, not 0.
        strain: f64,
        /// Axis along which it is taken.
        axis: Axis,
        /// Give up after so many steps.
        max_steps: u64,
    },
    /// When the total stress along an axis comes to this value, from above or from below.
    Stress {
        /// Stress of contacts and fluid (Pa), the mean of both walls, or of the cell.
        stress: f64,
        /// Axis along which it is taken.
        axis: Axis,
        /// Give up after so many steps.
        max_steps: u64,
    },
    /// When the porosity comes to this value, from above or from below.
    Porosity {
        /// Porosity of the box or the cell (1).
        porosity: f64,
        /// Give up after so many steps.
        max_steps: u64,
    },
    /// When the spheres are at rest, and the stresses that servos hold are there.
    Unbalanced {
        /// Unbalanced force (1).
        unbalanced: f64,
        /// Share of its goal that the stress on a servo wall may miss (1). Default 0.01.
        tolerance: f64,
        /// Give up after so many steps.
        max_steps: u64,
    },
}

const STEPS: Count = Count(1);
const TIME: Number = number("s", Bound::Positive);
const MAX_STEPS: u64 = 5_000_000;
const TOLERANCE: f64 = 0.01;

const STRESS: Number = number("Pa", Bound::Finite);
const SHARE: Number = number("", Bound::InsideUnit);

impl Until {
    /// Exactly one of three keys.
    pub(super) fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        if let Keys::Read(table) = keys {
            *self = read_until(table)?;
            return Ok(());
        }
        match self {
            Until::Steps(steps) => keys.take("steps", &STEPS, steps),
            Until::Time(time) => keys.take("time", &TIME, time),
            _ => keys.take("until", &State, self),
        }
    }
}

fn read_until(table: &Table) -> Result<Until> {
    const ENDS: &str = "give one of `steps = 600`, `time = 0.1` (s), \
                        `until = { strain = 0.2, axis = \"y\" }`";
    match (table.get("steps"), table.get("time"), table.get("until")) {
        (Some(steps), None, None) => STEPS.read(&steps).map(Until::Steps),
        (None, Some(time), None) => TIME.read(&time).map(Until::Time),
        (None, None, Some(until)) => State.read(&until),
        (None, None, None) => {
            Err(table.source.error(table.at, "a run stage does not say when it ends", ENDS))
        }
        (steps, time, until) => {
            let last = [steps, time, until].iter().flatten().map(|v| v.at).max();
            let at = last.unwrap_or(table.at);
            Err(table.source.error(at, "a run stage has more than one end", ENDS))
        }
    }
}

/// The state that ends a stage: a table of its own.
struct State;

/// The quantities that a stage may wait for, and the keys that go with each.
const GOALS: [(&str, &[&str]); 4] = [
    ("strain", &["axis"]),
    ("stress", &["axis"]),
    ("porosity", &[]),
    ("unbalanced", &["tolerance"]),
];

impl Kind<Until> for State {
    fn read(&self, value: &Value) -> Result<Until> {
        let table = value.table(&SCHEMA)?;
        let mut given = GOALS.iter().filter_map(|(key, with)| Some((table.get(key)?, *with)));
        let Some((goal, with)) = given.next() else {
            return Err(value.error(
                "does not say what ends the stage",
                "give one of `strain`, `stress`, `porosity` and `unbalanced`",
            ));
        };
        if let Some((second, _)) = given.next() {
            let problem = format!("stands beside `{}`", goal.key());
            return Err(second.error(&problem, "keep one: a stage has one end"));
        }
        let unused = ["axis", "tolerance"].iter().find(|key| !with.contains(key));
        if let Some(unused) = unused.and_then(|key| table.get(key)) {
            let problem = format!("has no meaning beside `{}`", goal.key());
            return Err(unused.error(&problem, "leave it out"));
        }
        let axis = || AXIS.read(&table.need("axis", AN_AXIS)?);
        let max_steps = table.get("max_steps").map_or(Ok(MAX_STEPS), |v| STEPS.read(&v))?;
        let until = match goal.key() {
            "strain" => {
                Until::Strain { strain: goal.number("", Bound::Finite)?, axis: axis()?, max_steps }
            }
            "stress" => Until::Stress { stress: STRESS.read(&goal)?, axis: axis()?, max_steps },
            "porosity" => Until::Porosity { porosity: SHARE.read(&goal)?, max_steps },
            _ => {
                let tolerance = table.get("tolerance").map(|v| SHARE.read(&v)).transpose()?;
                let tolerance = tolerance.unwrap_or(TOLERANCE);
                Until::Unbalanced { unbalanced: SHARE.read(&goal)?, tolerance, max_steps }
            }
        };
        match until {
            Until::Strain { strain: 0.0, .. } => {
                Err(goal.error("is 0", "give a strain to reach, as in 0.2"))
            }
            _ => Ok(until),
        }
    }

    fn wrong(&self, until: &Until) -> Option<Wrong> {
        let of = |key: &str, wrong: Option<Wrong>| {
            let wrong = wrong?;
            Some(Wrong::new(format!("has a `{key}` that {}", wrong.problem), wrong.remedy))
        };
        let steps = |max_steps: &u64| of("max_steps", STEPS.wrong(max_steps));
        match until {
            Until::Steps(_) | Until::Time(_) => None,
            Until::Strain { strain, .. } if !(strain.is_finite() && *strain != 0.0) => {
                let problem = format!("has the strain {strain}");
                Some(Wrong::new(problem, "give a strain to reach, as in 0.2"))
            }
            Until::Strain { max_steps, .. } => steps(max_steps),
            Until::Stress { stress, max_steps, .. } => {
                of("stress", STRESS.wrong(stress)).or_else(|| steps(max_steps))
            }
            Until::Porosity { porosity, max_steps } => {
                of("porosity", SHARE.wrong(porosity)).or_else(|| steps(max_steps))
            }
            Until::Unbalanced { unbalanced, tolerance, max_steps } => {
                of("unbalanced", SHARE.wrong(unbalanced))
                    .or_else(|| of("tolerance", SHARE.wrong(tolerance)))
                    .or_else(|| steps(max_steps))
            }
        }
    }

    fn write(&self, until: &Until) -> Option<String> {
        let number = |x: &f64| format!("{x:?}");
        let axis = |axis: &Axis| ("axis", quoted(axis.name()));
        let (goal, max_steps) = match until {
            Until::Steps(_) | Until::Time(_) => return None,
            Until::Strain { strain, axis: along, max_steps } => {
                (vec![("strain", number(strain)), axis(along)], max_steps)
            }
            Until::Stress { stress, axis: along, max_steps } => {
                (vec![("stress", number(stress)), axis(along)], max_steps)
            }
            Until::Porosity { porosity, max_steps } => {
                (vec![("porosity", number(porosity))], max_steps)
            }
            Until::Unbalanced { unbalanced, tolerance, max_steps } => {
                let tolerance = ("tolerance", number(tolerance));
                (vec![("unbalanced", number(unbalanced)), tolerance], max_steps)
            }
        };
        let last = ("max_steps", max_steps.to_string());
        Some(inline(&goal.into_iter().chain([last]).collect::<Vec<_>>()))
    }
}
