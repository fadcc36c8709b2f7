//! Parts of the box that results are of: regions, and the plane of a section.

use serde::Serialize;

use super::kind::{AN_AXIS, AXIS, Kind, Vector, inline, quoted};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::domain::{Aabb, Axis};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static REGIONS: Schema = Schema::table("`regions`", &["min", "max"]);
pub(super) static SECTION: Schema = Schema::table("`section`", &["axis", "position"]);

/// A plane normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SectionPlane {
    /// The axis.
    pub axis: Axis,
    /// Where it cuts the axis (m).
    pub position: f64,
}

/// A box in space.
pub(super) struct Region;

impl Kind<Aabb> for Region {
    fn read(&self, value: &Value) -> Result<Aabb> {
        let table = value.table(&REGIONS)?;
        let corner = |key: &str, what: &str| table.need(key, what)?.vector("m");
        let region = Aabb {
            min: corner("min", "the lower corner of a box (m)")?,
            max: corner("max", "the upper corner of a box (m)")?,
        };
        self.wrong(&region).map_or(Ok(region), |wrong| Err(value.wrong(wrong)))
    }

    fn wrong(&self, region: &Aabb) -> Option<Wrong> {
        let holds = region.size().iter().all(|edge| *edge > 0.0 && edge.is_finite());
        let remedy = "give `max` above `min` on every axis, in m";
        (!holds).then(|| Wrong::new("has a box that is none", remedy))
    }

    fn write(&self, region: &Aabb) -> Option<String> {
        let corner = |x| Vector("m").write(x);
        Some(inline(&[("min", corner(&region.min)?), ("max", corner(&region.max)?)]))
    }
}

/// The plane of a section: a table.
pub(super) struct Plane;

impl Kind<SectionPlane> for Plane {
    fn read(&self, value: &Value) -> Result<SectionPlane> {
        let table = value.table(&SECTION)?;
        let axis = AXIS.read(&table.need("axis", AN_AXIS)?)?;
        let position = table.need("position", "where the plane cuts the axis (m)")?;
        Ok(SectionPlane { axis, position: position.number("m", Bound::Finite)? })
    }

    fn wrong(&self, plane: &SectionPlane) -> Option<Wrong> {
        let holds = plane.position.is_finite();
        (!holds).then(|| Wrong::new("has a `position` that is not finite", "give a number in m"))
    }

    fn write(&self, plane: &SectionPlane) -> Option<String> {
        let position = format!("{:?}", plane.position);
        Some(inline(&[("axis", quoted(plane.axis.name())), ("position", position)]))
    }
}
