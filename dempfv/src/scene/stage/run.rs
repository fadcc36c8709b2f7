//! `kind = "run"`: a number of steps under given wall motions.

use serde::Serialize;

use super::cell_controls;
use crate::dem::{CellControl, CellControls, WallControl};
use crate::domain::{Axis, PerWall};
use crate::input::InputError;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{AN_AXIS, AXIS, Angle, Count, Flag, Kind, Maybe, Number, inline};
use crate::scene::kind::{number, quoted};
use crate::scene::schema::Schema;
use crate::scene::table::{Bound, Table, Value};
use crate::scene::walls::MAX_VELOCITY;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "a run stage",
    &[
        "kind",
        "name",
        "steps",
        "time",
        "until",
        "fluid",
        "walls",
        "velocity_gradient",
        "cell_stress",
        "friction_angle",
        "dt",
        "damping",
    ],
);
pub(in crate::scene) static UNTIL: Schema =
    Schema::table("`until`", &["strain", "axis", "max_steps"]);
pub(in crate::scene) static WALLS: Schema = Schema::by_wall("`walls`");
pub(in crate::scene) static CONTROL: Schema =
    Schema::table("a wall's control", &["stress", "max_velocity", "velocity"]);

/// A number of steps under given wall motions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// When the stage ends. Default: after 1000 steps; a scene file must say it.
    pub until: Until,
    /// Is the flow solved at every step? Default false; in a scene file, true when it has
    /// `[fluid]`.
    pub fluid: bool,
    /// What each wall does. Default: fixed.
    pub walls: PerWall<WallControl>,
    /// What moves the periodic cell, where there is one. Default: nothing.
    pub cell: Box<CellControls>,
    /// Friction angle of the particles during this stage (rad). Default: the particles'.
    pub friction_angle: Option<f64>,
}

/// When a run stage ends.
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
        /// Give up after so many steps. Default 5,000,000.
        max_steps: u64,
    },
}

impl Default for Run {
    fn default() -> Run {
        let walls = PerWall::from_fn(|_| WallControl::Fixed);
        Run {
            until: Until::Steps(1000),
            fluid: false,
            walls,
            cell: Box::default(),
            friction_angle: None,
        }
    }
}

impl Keyed for Run {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        self.keys_with(keys, None)
    }
}

impl Run {
    /// Reads a stage whose servos move walls at up to `max_velocity` (m/s) where it says no
    /// other.
    pub(super) fn read_with(mut self, table: &Table, max_velocity: Option<f64>) -> Result<Run> {
        self.keys_with(&mut Keys::Read(table), max_velocity)?;
        Ok(self)
    }

    fn keys_with(&mut self, keys: &mut Keys, max_velocity: Option<f64>) -> Result<()> {
        keys.by_wall("walls", &WALLS, &Control { max_velocity }, &mut self.walls.0)?;
        cell_controls::keys(keys, &mut self.cell)?;
        self.until.keys(keys)?;
        keys.take("fluid", &Flag, &mut self.fluid)?;
        keys.take("friction_angle", &Maybe(Angle), &mut self.friction_angle)
    }

    /// A strain must be within reach of the walls or the cell.
    pub(super) fn wrong(&self) -> Option<Wrong> {
        let Until::Strain { axis, strain, .. } = self.until else { return None };
        match self.cell[axis.index()][axis.index()] {
            CellControl::Stress(_) => return None,
            CellControl::Rate(rate) if rate != 0.0 => {
                let problem = format!("waits for a strain of {strain} along {}", axis.name());
                let remedy = "strain is positive in compression, a velocity gradient in extension";
                let other = || Wrong::new(problem + ", but the cell goes the other way", remedy);
                return (rate * strain > 0.0).then(other);
            }
            CellControl::Rate(_) => {}
        }
        let mut shortening = 0.0;
        for (wall, control) in self.walls.iter().filter(|(w, _)| Axis::of(*w) == axis) {
            match control {
                WallControl::Fixed => {}
                WallControl::Velocity(velocity) => shortening += velocity * wall.inward(),
                // The servo goes where the stress leads it.
                WallControl::Servo { .. } => return None,
            }
        }
        let axis = axis.name();
        if shortening == 0.0 {
            return Some(Wrong::new(
                format!("waits for a strain along {axis}, but the walls there do not move"),
                "give one of them a velocity or a stress; a cell a velocity gradient or a stress",
            ));
        }
        (shortening * strain < 0.0).then(|| {
            Wrong::new(
                format!(
                    "waits for a strain of {strain} along {axis}, but the walls move the other way"
                ),
                "strain is positive in compression, velocity towards larger coordinates",
            )
        })
    }
}

const STEPS: Count = Count(1);
const TIME: Number = number("s", Bound::Positive);

impl Until {
    /// Exactly one of three keys.
    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        if let Keys::Read(table) = keys {
            *self = read_until(table)?;
            return Ok(());
        }
        match self {
            Until::Steps(steps) => keys.take("steps", &STEPS, steps),
            Until::Time(time) => keys.take("time", &TIME, time),
            Until::Strain { .. } => keys.take("until", &Strain, self),
        }
    }
}

fn read_until(table: &Table) -> Result<Until> {
    const ENDS: &str = "give one of `steps = 600`, `time = 0.1` (s), \
                        `until = { strain = 0.2, axis = \"y\" }`";
    match (table.get("steps"), table.get("time"), table.get("until")) {
        (Some(steps), None, None) => STEPS.read(&steps).map(Until::Steps),
        (None, Some(time), None) => TIME.read(&time).map(Until::Time),
        (None, None, Some(until)) => Strain.read(&until),
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

/// The strain that ends a stage: a table of its own.
struct Strain;

impl Kind<Until> for Strain {
    fn read(&self, value: &Value) -> Result<Until> {
        let table = value.table(&UNTIL)?;
        let goal = table.need("strain", "logarithmic strain, positive in compression")?;
        let strain = goal.number("", Bound::Finite)?;
        if strain == 0.0 {
            return Err(goal.error("is 0", "give a strain to reach, as in 0.2"));
        }
        let axis = AXIS.read(&table.need("axis", AN_AXIS)?)?;
        let max_steps = table.get("max_steps").map_or(Ok(5_000_000), |v| STEPS.read(&v))?;
        Ok(Until::Strain { strain, axis, max_steps })
    }

    fn wrong(&self, until: &Until) -> Option<Wrong> {
        let Until::Strain { strain, max_steps, .. } = until else { return None };
        if !(strain.is_finite() && *strain != 0.0) {
            let problem = format!("has the strain {strain}");
            return Some(Wrong::new(problem, "give a strain to reach, as in 0.2"));
        }
        let wrong = STEPS.wrong(max_steps)?;
        Some(Wrong::new(format!("has a `max_steps` that {}", wrong.problem), wrong.remedy))
    }

    fn write(&self, until: &Until) -> Option<String> {
        let Until::Strain { strain, axis, max_steps } = until else { return None };
        let axis = quoted(axis.name());
        let max_steps = max_steps.to_string();
        let strain = format!("{strain:?}");
        Some(inline(&[("strain", strain), ("axis", axis), ("max_steps", max_steps)]))
    }
}

/// What a wall does: `"fixed"`, or a table with a stress or a velocity.
struct Control {
    /// Cut of a servo's speed (m/s) where the table gives none.
    max_velocity: Option<f64>,
}

const STRESS: Number = number("Pa", Bound::NotNegative);
const VELOCITY: Number = number("m/s", Bound::Finite);
/// What a wall's control may be.
const CONTROLS: &str = "give \"fixed\", { velocity = 0.01 } (m/s) or { stress = 1e3 } (Pa)";

impl Kind<WallControl> for Control {
    fn read(&self, value: &Value) -> Result<WallControl> {
        if value.is_name() {
            return value.choice(&[("fixed", WallControl::Fixed)]);
        }
        if !value.is_table() {
            return Err(value.error("is no wall control", CONTROLS));
        }
        let table = value.table(&CONTROL)?;
        let limit = table.get("max_velocity");
        match (table.get("stress"), table.get("velocity")) {
            (Some(stress), None) => Ok(WallControl::Servo {
                stress: STRESS.read(&stress)?,
                max_velocity: match limit {
                    Some(limit) => Some(MAX_VELOCITY.read(&limit)?),
                    None => self.max_velocity,
                },
            }),
            (None, Some(velocity)) => match limit {
                Some(v) => Err(v.error("stands beside `velocity`", "it belongs to `stress`")),
                None => VELOCITY.read(&velocity).map(WallControl::Velocity),
            },
            (Some(a), Some(b)) => Err(value.source.error(
                a.at.max(b.at),
                format!("{} has two conditions: a stress and a velocity", value.key()),
                "keep one of the two",
            )),
            (None, None) => Err(value.error("says neither a stress nor a velocity", CONTROLS)),
        }
    }

    fn wrong(&self, control: &WallControl) -> Option<Wrong> {
        let named = |key: &str, wrong: Option<Wrong>| {
            let wrong = wrong?;
            Some(Wrong::new(format!("has a `{key}` that {}", wrong.problem), wrong.remedy))
        };
        match control {
            WallControl::Fixed => None,
            WallControl::Velocity(velocity) => named("velocity", VELOCITY.wrong(velocity)),
            WallControl::Servo { stress, max_velocity } => named("stress", STRESS.wrong(stress))
                .or_else(|| named("max_velocity", Maybe(MAX_VELOCITY).wrong(max_velocity))),
        }
    }

    fn write(&self, control: &WallControl) -> Option<String> {
        match control {
            WallControl::Fixed => None,
            WallControl::Velocity(velocity) => {
                Some(inline(&[("velocity", format!("{velocity:?}"))]))
            }
            WallControl::Servo { stress, max_velocity } => {
                let limit = max_velocity.map(|v| ("max_velocity", format!("{v:?}")));
                let stress = ("stress", format!("{stress:?}"));
                Some(inline(&[stress].into_iter().chain(limit).collect::<Vec<_>>()))
            }
        }
    }
}

impl Run {
    /// True when a wall does anything.
    pub(super) fn moves_walls(&self) -> bool {
        self.walls.values().any(|c| *c != WallControl::Fixed)
    }

    /// True when a periodic cell is told to do anything.
    pub(super) fn moves_cell(&self) -> bool {
        *self.cell != CellControls::default()
    }

    /// True when a component of the stress on a periodic cell is prescribed.
    pub(super) fn has_cell_stress(&self) -> bool {
        self.cell.iter().flatten().any(|c| matches!(c, CellControl::Stress(_)))
    }

    /// True when a wall moves with a given velocity.
    pub(super) fn has_moving_wall(&self) -> bool {
        self.walls.values().any(|c| matches!(c, WallControl::Velocity(_)))
    }

    /// True when a wall is held at a stress.
    pub(super) fn has_servo(&self) -> bool {
        self.walls.values().any(|c| matches!(c, WallControl::Servo { .. }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::WallId;

    #[test]
    fn a_servo_goes_where_the_stress_leads_it() {
        let mut run = Run {
            until: Until::Strain { strain: -0.1, axis: Axis::Y, max_steps: 1 },
            ..Run::default()
        };
        assert!(run.wrong().unwrap().problem.contains("do not move"));
        run.walls[WallId::YMax] = WallControl::Velocity(-0.1);
        assert!(run.wrong().unwrap().problem.contains("the other way"));
        run.walls[WallId::YMax] = WallControl::Velocity(0.1);
        assert!(run.wrong().is_none());
        run.walls[WallId::YMax] = WallControl::Servo { stress: 1.0, max_velocity: None };
        assert!(run.wrong().is_none());
    }
}
