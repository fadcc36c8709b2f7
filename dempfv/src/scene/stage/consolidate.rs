//! `kind = "consolidate"`: a stress is put on a wall at once and the packing drains.

use serde::Serialize;

use crate::domain::{Axis, WallId};
use crate::input::InputError;
use crate::scene::fluid::Fluid;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{A_WALL, Array, Count, Maybe, Number, WALL, number};
use crate::scene::schema::Schema;
use crate::scene::table::Bound;
use crate::scene::walls::MAX_VELOCITY;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "a consolidate stage",
    &[
        "kind",
        "name",
        "wall",
        "stress",
        "until_tv",
        "profiles",
        "max_velocity",
        "max_steps",
        "dt",
        "damping",
    ],
);

/// A stress is put on a wall at once and the packing drains, until a dimensionless time
/// T_v = c_v t / d², with c_v = k E_oed / μ from the modulus and the permeability that
/// the stages before measured, and the drainage path d: the height, or half of it where both
/// ends drain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Consolidate {
    /// The loaded wall. Default `y_max`; a scene file must say it.
    pub wall: WallId,
    /// Stress on it (Pa). Default 1.1e4; a scene file must say it.
    pub stress: f64,
    /// End of the stage, as T_v (1). Default 1; a scene file must say it.
    pub until_tv: f64,
    /// T_v at which pressure profiles are kept, ascending (1). Default: none.
    pub profiles: Vec<f64>,
    /// Cut of the speed that the servo asks for (m/s). Default: by stress and material, as
    /// [`WallControl::Servo`](crate::dem::WallControl::Servo) says; in a scene file, that of
    /// `[walls]`.
    pub max_velocity: Option<f64>,
    /// Give up after so many steps. Default 5,000,000.
    pub max_steps: u64,
}

impl Default for Consolidate {
    fn default() -> Consolidate {
        Consolidate {
            wall: WallId::YMax,
            stress: 1.1e4,
            until_tv: 1.0,
            profiles: vec![],
            max_velocity: None,
            max_steps: 5_000_000,
        }
    }
}

const TIME_FACTOR: Number = number("(dimensionless time)", Bound::Positive);

impl Keyed for Consolidate {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        const PROFILES: Array<Number> =
            Array { items: TIME_FACTOR, form: "an array of T_v, as in [0.1, 0.5]" };
        keys.need_number("until_tv", TIME_FACTOR, &mut self.until_tv)?;
        keys.take("profiles", &PROFILES, &mut self.profiles)?;
        if let Some((item, wrong)) = self.profile_out_of_order() {
            keys.rule_of_item("profiles", item, Some(wrong))?;
        }
        keys.need("wall", A_WALL, &WALL, &mut self.wall)?;
        keys.need_number("stress", number("Pa", Bound::Positive), &mut self.stress)?;
        keys.take("max_velocity", &Maybe(MAX_VELOCITY), &mut self.max_velocity)?;
        keys.take("max_steps", &Count(1), &mut self.max_steps)
    }
}

/// What the stages before have measured along an axis.
pub(super) struct Measured {
    pub modulus: bool,
    pub permeability: bool,
}

impl Consolidate {
    fn profile_out_of_order(&self) -> Option<(usize, Wrong)> {
        let mut last = 0.0;
        for (i, &tv) in self.profiles.iter().enumerate() {
            if tv <= last || tv > self.until_tv {
                let problem = format!("holds {tv} after {last}");
                let remedy =
                    format!("give T_v in ascending order, up to `until_tv` = {}", self.until_tv);
                return Some((i, Wrong::new(problem, remedy)));
            }
            last = tv;
        }
        None
    }

    /// What is wrong with this stage in its scene: it needs a measured c_v, and drains at one or
    /// both ends of its own axis, as Terzaghi's theory, by which T_v is defined, is one-dimensional.
    pub(super) fn wrong_after(&self, measured: &Measured, fluid: &Fluid) -> Option<Wrong> {
        let axis = Axis::of(self.wall);
        let along = axis.name();
        let missing = |what: &str, kind: &str, key: String| {
            Wrong::new(
                format!("needs the {what} along {along}, which no stage before it measures"),
                format!("put a [[stage]] with kind = \"{kind}\" and {key} before it"),
            )
        };
        if !measured.modulus {
            return Some(missing(
                "oedometric modulus",
                "cycle",
                format!("wall = \"{}\"", self.wall),
            ));
        }
        if !measured.permeability {
            return Some(missing("permeability", "permeability", format!("axis = \"{along}\"")));
        }
        let (wall, opposite) = (self.wall, self.wall.opposite());
        if let Some((side, _)) = fluid.pressure_walls().find(|(w, _)| Axis::of(*w) != axis) {
            return Some(Wrong::new(
                format!("consolidates along {along}, but {side} drains across it"),
                format!("impose a pressure on {wall}, {opposite} or both, and on no other wall"),
            ));
        }
        if fluid.changes_pressures() {
            return Some(Wrong::new(
                "consolidates against a pressure that changes with time or along a wall",
                "impose pressures that are numbers",
            ));
        }
        if fluid.effects.one_way {
            return Some(Wrong::new(
                "consolidates, but with `coupling = \"one-way\"` no load presses on the fluid",
                "take \"two-way\"",
            ));
        }
        let at = fluid.fluid.boundary.pressure;
        match (at[wall], at[opposite]) {
            (Some(p), Some(q)) if p != q => Some(Wrong::new(
                format!(
                    "drains at both ends of {along}, at {p} Pa and at {q} Pa: fluid would flow through for ever"
                ),
                format!("impose the same pressure on {wall} and {opposite}, or one on either"),
            )),
            _ => None,
        }
    }
}
