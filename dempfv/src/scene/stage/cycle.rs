//! `kind = "cycle"`: one wall loads and unloads the packing, dry.

use serde::Serialize;

use crate::domain::WallId;
use crate::input::InputError;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{A_WALL, Count, Maybe, WALL, number};
use crate::scene::schema::Schema;
use crate::scene::table::Bound;
use crate::scene::walls::MAX_VELOCITY;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "a cycle stage",
    &[
        "kind",
        "name",
        "wall",
        "from",
        "to",
        "cycles",
        "unbalanced",
        "tolerance",
        "max_velocity",
        "max_steps",
        "dt",
        "damping",
    ],
);

/// Dry servo cycles of one wall between two stresses: their secant slope is the
/// oedometric modulus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cycle {
    /// The wall that moves. Default `y_max`; a scene file must say it.
    pub wall: WallId,
    /// Lower stress on it (Pa). Default 1e4; a scene file must say it.
    pub from: f64,
    /// Upper stress on it (Pa), above `from`. Default 1.1e4; a scene file must say it.
    pub to: f64,
    /// Load-unload pairs. Default 2.
    pub cycles: u32,
    /// Each half cycle ends at this unbalanced force (1). Default 0.001.
    pub unbalanced: f64,
    /// and with the stress within this share of its goal (1). Default 0.001.
    pub tolerance: f64,
    /// Cut of the speed that the servo asks for (m/s). Default: by stress and material, as
    /// [`WallControl::Servo`](crate::dem::WallControl::Servo) says; in a scene file, that of
    /// `[walls]`.
    pub max_velocity: Option<f64>,
    /// Give up after so many steps in all. Default 500,000.
    pub max_steps: u64,
}

impl Default for Cycle {
    fn default() -> Cycle {
        Cycle {
            wall: WallId::YMax,
            from: 1e4,
            to: 1.1e4,
            cycles: 2,
            unbalanced: 1e-3,
            tolerance: 1e-3,
            max_velocity: None,
            max_steps: 500_000,
        }
    }
}

impl Keyed for Cycle {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        let stress = number("Pa", Bound::Positive);
        keys.need_number("from", stress, &mut self.from)?;
        keys.need("to", "a number above `from` in Pa", &stress, &mut self.to)?;
        keys.rule("to", self.not_above())?;
        keys.need("wall", A_WALL, &WALL, &mut self.wall)?;
        keys.take("cycles", &Count(1), &mut self.cycles)?;
        keys.take("unbalanced", &number("", Bound::InsideUnit), &mut self.unbalanced)?;
        keys.take("tolerance", &number("", Bound::InsideUnit), &mut self.tolerance)?;
        keys.take("max_velocity", &Maybe(MAX_VELOCITY), &mut self.max_velocity)?;
        keys.take("max_steps", &Count(1), &mut self.max_steps)
    }
}

impl Cycle {
    fn not_above(&self) -> Option<Wrong> {
        let Cycle { from, to, .. } = self;
        (to <= from).then(|| {
            Wrong::new(
                format!("is {to}, not above `from` = {from}"),
                "give a number above `from` in Pa",
            )
        })
    }
}
