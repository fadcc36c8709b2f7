//! The pressure of a wall: a number, a function of time, or a profile along the wall.

use super::kind::{AN_AXIS, AXIS, Kind, inline, quoted};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::time_function::InTime;
use super::wrong::Wrong;
use crate::TimeFunction;
use crate::domain::{PerWall, WallId};
use crate::input::InputError;
use crate::pfv::PressureProfile;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("a pressure along a wall", &["along", "points", "plus"]);

/// What the pores at a wall are told.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WallPressure {
    /// The same all along the wall (Pa).
    pub level: TimeFunction,
    /// From place to place, beside it.
    pub profile: Option<PressureProfile>,
}

/// The kind of such values.
pub(super) struct AtWall;

const LEVEL: InTime = InTime("Pa");

impl Kind<WallPressure> for AtWall {
    fn read(&self, value: &Value) -> Result<WallPressure> {
        if !SCHEMA.keys.iter().any(|key| value.peek(key).is_some()) {
            return Ok(WallPressure { level: LEVEL.read(value)?, profile: None });
        }
        let table = value.table(&SCHEMA)?;
        let along = AXIS.read(&table.need("along", AN_AXIS)?)?;
        let points = table.need("points", "an array of points [coordinate, pressure]")?;
        let point = |point: &Value| match point.items("a point [coordinate, pressure]")?.as_slice()
        {
            [x, p] => Ok([x.number("m", Bound::Finite)?, p.number("Pa", Bound::Finite)?]),
            other => Err(point.error(
                &format!("has a point of {} numbers", other.len()),
                "give [coordinate, pressure]",
            )),
        };
        let items = points.items("an array of points [coordinate, pressure]")?;
        let points = items.iter().map(point).collect::<Result<_>>()?;
        let level = table.get("plus").map(|plus| LEVEL.read(&plus)).transpose()?;
        Ok(WallPressure {
            level: level.unwrap_or(TimeFunction::Constant(0.0)),
            profile: Some(PressureProfile { along, points }),
        })
    }

    fn wrong(&self, pressure: &WallPressure) -> Option<Wrong> {
        LEVEL.wrong(&pressure.level)
    }

    fn write(&self, pressure: &WallPressure) -> Option<String> {
        let level = LEVEL.write(&pressure.level)?;
        let Some(PressureProfile { along, points }) = &pressure.profile else { return Some(level) };
        let points: Vec<String> = points.iter().map(|[x, p]| format!("[{x:?}, {p:?}]")).collect();
        let points = format!("[{}]", points.join(", "));
        Some(inline(&[("along", quoted(along.name())), ("points", points), ("plus", level)]))
    }
}

/// The first wall whose profile is none, and what is wrong with it.
pub(super) fn wrong_profile(pressures: &PerWall<Option<WallPressure>>) -> Option<Wrong> {
    let profile = |wall: WallId| Some((wall, pressures[wall].as_ref()?.profile.as_ref()?));
    let problem = |(wall, profile): (WallId, &PressureProfile)| {
        let (problem, remedy) = profile.problem(wall)?;
        Some(Wrong::new(format!("of {wall} {problem}"), remedy))
    };
    WallId::ALL.into_iter().filter_map(profile).find_map(problem)
}
