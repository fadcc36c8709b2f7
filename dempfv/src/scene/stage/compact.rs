//! `kind = "compact"`: all radii grow in the fixed box until the walls feel an isotropic
//! stress; dry.

use serde::Serialize;

use crate::input::InputError;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{Angle, Count, Flag, Maybe, number};
use crate::scene::schema::Schema;
use crate::scene::table::Bound;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "a compact stage",
    &[
        "kind",
        "name",
        "stress",
        "friction_angle",
        "unbalanced",
        "tolerance",
        "max_steps",
        "keep_radii",
        "dt",
        "damping",
    ],
);

/// All radii grow in the fixed box until the walls feel an isotropic stress; dry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compact {
    /// Goal: mean stress on the six walls (Pa). Default 1e4; a scene file must say it.
    pub stress: f64,
    /// Friction angle of the particles during this stage (rad). Default: the particles'.
    pub friction_angle: Option<f64>,
    /// Stop at this unbalanced force (1). Default 0.001.
    pub unbalanced: f64,
    /// Stop within this share of the goal (1). Default 0.001.
    pub tolerance: f64,
    /// Give up after so many steps. Default 500,000.
    pub max_steps: u64,
    /// Do radii stay, and the box shrinks instead? Default false.
    pub keep_radii: bool,
}

impl Default for Compact {
    fn default() -> Compact {
        Compact {
            stress: 1e4,
            friction_angle: None,
            unbalanced: 1e-3,
            tolerance: 1e-3,
            max_steps: 500_000,
            keep_radii: false,
        }
    }
}

impl Keyed for Compact {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.need_number("stress", number("Pa", Bound::Positive), &mut self.stress)?;
        keys.take("friction_angle", &Maybe(Angle), &mut self.friction_angle)?;
        keys.take("unbalanced", &number("", Bound::InsideUnit), &mut self.unbalanced)?;
        keys.take("tolerance", &number("", Bound::InsideUnit), &mut self.tolerance)?;
        keys.take("max_steps", &Count(1), &mut self.max_steps)?;
        keys.take("keep_radii", &Flag, &mut self.keep_radii)
    }
}
