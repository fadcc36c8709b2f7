//! `[walls]`: what the six walls are made of, and how fast a servo may move them.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Angle, Maybe, Number, number};
use super::schema::Schema;
use super::table::Bound;
use crate::Effect;
use crate::dem::WallMaterial;
use crate::dem::effects::WALL_FRICTION;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("[walls]", &["young", "friction_angle", "max_velocity"]);

/// Cut of the speed that a servo asks for, here and in the stages.
pub(super) const MAX_VELOCITY: Number = number("m/s", Bound::Positive);

/// Material of the six walls, and how fast the servo may move them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Walls {
    /// What they are made of. Default: smooth, E = 1e6 Pa; in a scene file, E of the particles.
    #[serde(flatten)]
    pub material: WallMaterial,
    /// Cut of the speed that a servo asks for (m/s), for the walls of a cube, where a stage of a
    /// scene file gives none. Default: by stress and material, as
    /// [`WallControl::Servo`](crate::dem::WallControl::Servo) says.
    pub max_velocity: Option<f64>,
}

impl Default for Walls {
    fn default() -> Walls {
        let material = WallMaterial { young: 1e6, friction_angle: 0.0 };
        Walls { material, max_velocity: None }
    }
}

impl Keyed for Walls {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.take("young", &number("Pa", Bound::Positive), &mut self.material.young)?;
        keys.take("friction_angle", &Angle, &mut self.material.friction_angle)?;
        keys.take("max_velocity", &Maybe(MAX_VELOCITY), &mut self.max_velocity)
    }
}

impl Walls {
    /// Walls as stiff as the spheres (Pa).
    pub(super) fn as_stiff_as(young: f64) -> Walls {
        let mut walls = Walls::default();
        walls.material.young = young;
        walls
    }

    /// Effects of this table, where spheres with friction move or not.
    pub(super) fn effects(&self, friction: bool) -> [(&'static Effect, bool); 1] {
        [(&WALL_FRICTION, friction && self.material.friction_angle > 0.0)]
    }
}
