//! What a wall does in a run stage, for ever or as a function of time.

use crate::TimeFunction;
use crate::dem::WallControl;
use crate::domain::PerWall;
use crate::input::InputError;
use crate::scene::keys::Keys;
use crate::scene::kind::{Kind, Maybe, Number, inline, number};
use crate::scene::schema::Schema;
use crate::scene::table::{Bound, Value};
use crate::scene::time_function::InTime;
use crate::scene::walls::MAX_VELOCITY;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static WALLS: Schema = Schema::by_wall("`walls`");
pub(in crate::scene) static CONTROL: Schema =
    Schema::table("a wall's control", &["stress", "max_velocity", "velocity"]);

/// Passes over the key `walls`. What changes with time is in `in_time`; `walls` has it at the
/// stage's start. `max_velocity` is the cut of a servo's speed (m/s) where a wall gives none.
pub(super) fn keys(
    keys: &mut Keys,
    walls: &mut PerWall<WallControl>,
    in_time: &mut PerWall<Option<TimeFunction>>,
    max_velocity: Option<f64>,
) -> Result<()> {
    let mut motions =
        PerWall::from_fn(|w| Motion { control: walls[w], in_time: in_time[w].clone() });
    keys.by_wall("walls", &WALLS, &Control { max_velocity }, &mut motions.0)?;
    *walls = motions.map(|motion| motion.control);
    *in_time = motions.map(|motion| motion.in_time.clone());
    Ok(())
}

/// What a wall does, and how its stress or velocity goes on.
struct Motion {
    control: WallControl,
    in_time: Option<TimeFunction>,
}

/// The control with a stress (Pa) or a velocity (m/s) in the place of its own.
pub(crate) fn with_value(control: WallControl, value: f64) -> WallControl {
    match control {
        WallControl::Fixed => WallControl::Fixed,
        WallControl::Velocity(_) => WallControl::Velocity(value),
        WallControl::Servo { max_velocity, .. } => {
            WallControl::Servo { stress: value, max_velocity }
        }
    }
}

/// What a wall does: `"fixed"`, or a table with a stress or a velocity.
struct Control {
    max_velocity: Option<f64>,
}

const STRESS: Number = number("Pa", Bound::NotNegative);
const VELOCITY: Number = number("m/s", Bound::Finite);
/// What a wall's control may be.
const CONTROLS: &str = "give \"fixed\", { velocity = 0.01 } (m/s) or { stress = 1e3 } (Pa)";

impl Control {
    fn motion(control: WallControl, function: TimeFunction) -> Motion {
        let control = with_value(control, function.value(0.0));
        let in_time = Some(function).filter(|f| !matches!(f, TimeFunction::Constant(_)));
        Motion { control, in_time }
    }
}

impl Kind<Motion> for Control {
    fn read(&self, value: &Value) -> Result<Motion> {
        let still = |control| Motion { control, in_time: None };
        if value.is_name() {
            return value.choice(&[("fixed", WallControl::Fixed)]).map(still);
        }
        if !value.is_table() {
            return Err(value.error("is no wall control", CONTROLS));
        }
        let table = value.table(&CONTROL)?;
        let limit = table.get("max_velocity");
        match (table.get("stress"), table.get("velocity")) {
            (Some(stress), None) => {
                let max_velocity = match limit {
                    Some(limit) => Some(MAX_VELOCITY.read(&limit)?),
                    None => self.max_velocity,
                };
                let servo = WallControl::Servo { stress: 0.0, max_velocity };
                if !stress.is_table() {
                    return Ok(still(with_value(servo, STRESS.read(&stress)?)));
                }
                let function = InTime("Pa").read(&stress)?;
                match pulls(&function) {
                    Some(wrong) => Err(stress.wrong(wrong)),
                    None => Ok(Control::motion(servo, function)),
                }
            }
            (None, Some(velocity)) => match limit {
                Some(v) => Err(v.error("stands beside `velocity`", "it belongs to `stress`")),
                None => {
                    let function = InTime("m/s").read(&velocity)?;
                    Ok(Control::motion(WallControl::Velocity(0.0), function))
                }
            },
            (Some(a), Some(b)) => Err(value.source.error(
                a.at.max(b.at),
                format!("{} has two conditions: a stress and a velocity", value.key()),
                "keep one of the two",
            )),
            (None, None) => Err(value.error("says neither a stress nor a velocity", CONTROLS)),
        }
    }

    fn wrong(&self, motion: &Motion) -> Option<Wrong> {
        let named = |key: &str, wrong: Option<Wrong>| {
            let wrong = wrong?;
            Some(Wrong::new(format!("has a `{key}` that {}", wrong.problem), wrong.remedy))
        };
        let in_time = |unit| motion.in_time.as_ref().and_then(|f| InTime(unit).wrong(f));
        match &motion.control {
            WallControl::Fixed => motion.in_time.as_ref().map(|_| {
                Wrong::new("is fixed and has a function of time", "give it a stress or a velocity")
            }),
            WallControl::Velocity(velocity) => {
                named("velocity", VELOCITY.wrong(velocity).or_else(|| in_time("m/s")))
            }
            WallControl::Servo { stress, max_velocity } => {
                let function = motion.in_time.as_ref();
                let wrong = STRESS.wrong(stress).or_else(|| in_time("Pa"));
                named("stress", wrong.or_else(|| function.and_then(pulls)))
                    .or_else(|| named("max_velocity", Maybe(MAX_VELOCITY).wrong(max_velocity)))
            }
        }
    }

    fn write(&self, motion: &Motion) -> Option<String> {
        let value = |value: f64| match &motion.in_time {
            Some(function) => InTime("").write(function).unwrap_or_default(),
            None => format!("{value:?}"),
        };
        match motion.control {
            WallControl::Fixed => None,
            WallControl::Velocity(velocity) => Some(inline(&[("velocity", value(velocity))])),
            WallControl::Servo { stress, max_velocity } => {
                let limit = max_velocity.map(|v| ("max_velocity", format!("{v:?}")));
                let stress = ("stress", value(stress));
                Some(inline(&[stress].into_iter().chain(limit).collect::<Vec<_>>()))
            }
        }
    }
}

/// A servo presses: what is wrong with a stress that becomes negative.
fn pulls(stress: &TimeFunction) -> Option<Wrong> {
    let least = match stress {
        TimeFunction::Constant(value) => *value,
        TimeFunction::Ramp(points) => points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min),
        TimeFunction::Sine { mean, amplitude, .. } => mean - amplitude.abs(),
    };
    (least < 0.0).then(|| {
        Wrong::new(
            format!("comes to {least} Pa"),
            "give a stress that stays at 0 or above: walls press",
        )
    })
}
