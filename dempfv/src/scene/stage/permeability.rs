//! `kind = "permeability"`: static flow along one axis through the packing at rest.

use serde::Serialize;

use crate::domain::Axis;
use crate::input::InputError;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{AN_AXIS, AXIS};
use crate::scene::schema::Schema;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema =
    Schema::table("a permeability stage", &["kind", "name", "axis"]);

/// Static flow along one axis through the packing at rest: 1 Pa on the lower wall, 0 on
/// the upper, no flow through the other four.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Permeability {
    /// Axis of the flow. Default y; a scene file must say it.
    pub axis: Axis,
}

impl Default for Permeability {
    fn default() -> Permeability {
        Permeability { axis: Axis::Y }
    }
}

impl Keyed for Permeability {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.need("axis", AN_AXIS, &AXIS, &mut self.axis)
    }
}
