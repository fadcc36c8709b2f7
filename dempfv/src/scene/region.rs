//! Pores of choice: a ball, a box, or those that contain points; and what they are told.

use super::kind::{Array, Kind, Number, Vector, inline};
use super::schema::Schema;
use super::table::{Bound, Table, Value};
use super::time_function::InTime;
use super::wrong::Wrong;
use crate::TimeFunction;
use crate::domain::{Aabb, Vec3};
use crate::input::InputError;
use crate::pfv::{ConductanceRegion, PoreSelection};

type Result<T> = std::result::Result<T, InputError>;

pub(super) static IMPOSED: Schema =
    Schema::table("`imposed`", &["center", "radius", "min", "max", "points", "pressure"]);
pub(super) static SOURCES: Schema =
    Schema::table("`sources`", &["center", "radius", "min", "max", "points", "rate"]);
pub(super) static BLOCKED: Schema =
    Schema::table("`blocked`", &["center", "radius", "min", "max", "points"]);
pub(super) static CONDUCTANCE_REGIONS: Schema =
    Schema::table("`conductance_regions`", &["center", "radius", "min", "max", "points", "factor"]);

const POINTS: Array<Vector> =
    Array { items: Vector("m"), form: "an array of points in m, as in [[0.5, 0.1, 0.5]]" };

/// Pores with a value that may change with time: the last of the schema's keys.
pub(super) struct Conditioned {
    pub schema: &'static Schema,
    pub unit: &'static str,
}

/// What pores of choice are told.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Condition {
    pub pores: PoreSelection,
    pub value: TimeFunction,
}

/// Pores that are blocked.
pub(super) struct BlockedRegion;

/// Pores with a factor.
pub(super) struct FactorRegion(pub Number);

impl Kind<Condition> for Conditioned {
    fn read(&self, value: &Value) -> Result<Condition> {
        let table = value.table(self.schema)?;
        let told = table.need(last_key(self.schema), "what these pores are told")?;
        Ok(Condition { value: InTime(self.unit).read(&told)?, pores: read(value, &table)? })
    }

    fn wrong(&self, condition: &Condition) -> Option<Wrong> {
        let of_value = |wrong: Wrong| {
            Wrong::new(
                format!("has a `{}` that {}", last_key(self.schema), wrong.problem),
                wrong.remedy,
            )
        };
        let value = InTime(self.unit).wrong(&condition.value).map(of_value);
        value.or_else(|| wrong(&condition.pores))
    }

    fn write(&self, condition: &Condition) -> Option<String> {
        let value = InTime(self.unit).write(&condition.value)?;
        write(&condition.pores, Some((last_key(self.schema), value)))
    }
}

impl Kind<PoreSelection> for BlockedRegion {
    fn read(&self, value: &Value) -> Result<PoreSelection> {
        read(value, &value.table(&BLOCKED)?)
    }

    fn wrong(&self, pores: &PoreSelection) -> Option<Wrong> {
        wrong(pores)
    }

    fn write(&self, pores: &PoreSelection) -> Option<String> {
        write(pores, None)
    }
}

impl Kind<ConductanceRegion> for FactorRegion {
    fn read(&self, value: &Value) -> Result<ConductanceRegion> {
        let table = value.table(&CONDUCTANCE_REGIONS)?;
        let factor = table.need("factor", "by which these pores conduct better or worse")?;
        Ok(ConductanceRegion { factor: self.0.read(&factor)?, pores: read(value, &table)? })
    }

    fn wrong(&self, region: &ConductanceRegion) -> Option<Wrong> {
        self.0.wrong(&region.factor).or_else(|| wrong(&region.pores))
    }

    fn write(&self, region: &ConductanceRegion) -> Option<String> {
        write(&region.pores, Some(("factor", self.0.write(&region.factor)?)))
    }
}

fn last_key(schema: &'static Schema) -> &'static str {
    schema.keys[schema.keys.len() - 1]
}

/// The pores of an entry.
fn read(value: &Value, table: &Table) -> Result<PoreSelection> {
    let has = |keys: &[&str]| keys.iter().any(|key| table.get(key).is_some());
    let [ball, corners, points] =
        [&["center", "radius"][..], &["min", "max"], &["points"]].map(has);
    if [ball, corners, points].into_iter().filter(|given| *given).count() != 1 {
        return Err(value.error(
            "has an entry that is not one ball, one box or one list of points",
            "give `center` and `radius`, or `min` and `max`, or `points`",
        ));
    }
    let point = |key: &str, what: &str| table.need(key, what)?.vector("m");
    let pores = if ball {
        PoreSelection::Around {
            center: point("center", "the middle of a ball (m)")?,
            radius: table
                .need("radius", "the radius of a ball (m)")?
                .number("m", Bound::Positive)?,
        }
    } else if corners {
        PoreSelection::Within {
            min: point("min", "the lower corner of a box (m)")?,
            max: point("max", "the upper corner of a box (m)")?,
        }
    } else {
        PoreSelection::At(POINTS.read(&table.need("points", "points (m)")?)?)
    };
    wrong(&pores).map_or(Ok(pores), |wrong| Err(value.wrong(wrong)))
}

fn wrong(pores: &PoreSelection) -> Option<Wrong> {
    let problem = |problem: &str, remedy: &str| Some(Wrong::new(problem, remedy));
    let finite = |x: &Vec3| x.iter().all(|c| c.is_finite());
    match pores {
        PoreSelection::Pores(_) => problem(
            "has pores by their numbers, which the next network does not know",
            "give a ball, a box or points",
        ),
        PoreSelection::At(points) if !points.is_empty() && points.iter().all(finite) => None,
        PoreSelection::At(_) => {
            problem("has a list of points that is none", "give one or more finite points")
        }
        PoreSelection::Around { center, radius }
            if *radius > 0.0 && radius.is_finite() && finite(center) =>
        {
            None
        }
        PoreSelection::Around { .. } => {
            problem("has a ball that is none", "give a finite middle and a radius above 0")
        }
        PoreSelection::Within { min, max }
            if (max - min).iter().all(|edge| *edge > 0.0 && edge.is_finite()) =>
        {
            None
        }
        PoreSelection::Within { .. } => {
            problem("has a box that is none", "give `max` above `min` on every axis")
        }
    }
}

fn write(pores: &PoreSelection, told: Option<(&'static str, String)>) -> Option<String> {
    let point = |x| Vector("m").write(x);
    let entries = match pores {
        PoreSelection::Pores(_) => return None,
        PoreSelection::At(points) => vec![("points", POINTS.write(points)?)],
        PoreSelection::Around { center, radius } => {
            vec![("center", point(center)?), ("radius", format!("{radius:?}"))]
        }
        PoreSelection::Within { min, max } => vec![("min", point(min)?), ("max", point(max)?)],
    };
    Some(inline(&entries.into_iter().chain(told).collect::<Vec<_>>()))
}

/// Whether no pore of this box can be among them.
pub(super) fn is_outside(pores: &PoreSelection, bounds: &Aabb) -> bool {
    match pores {
        PoreSelection::Pores(_) => false,
        PoreSelection::At(points) => points.iter().any(|x| !bounds.contains(x)),
        PoreSelection::Around { center, radius } => {
            (center - center.sup(&bounds.min).inf(&bounds.max)).norm() > *radius
        }
        PoreSelection::Within { min, max } => {
            (0..3).any(|k| max[k] < bounds.min[k] || min[k] > bounds.max[k])
        }
    }
}

/// Whether two regions have a part of space, or a point, in common, so that pores may lie in both.
/// Points lie in pores of their own size, which nothing tells here.
pub(super) fn overlap(a: &PoreSelection, b: &PoreSelection) -> bool {
    use PoreSelection::{Around, At, Pores, Within};
    let inside = |x: &Vec3, min: &Vec3, max: &Vec3| Aabb { min: *min, max: *max }.contains(x);
    match (a, b) {
        (Pores(_), _) | (_, Pores(_)) => false,
        (At(points), At(others)) => points.iter().any(|x| others.contains(x)),
        (At(points), Around { center, radius }) | (Around { center, radius }, At(points)) => {
            points.iter().any(|x| (x - center).norm() < *radius)
        }
        (At(points), Within { min, max }) | (Within { min, max }, At(points)) => {
            points.iter().any(|x| inside(x, min, max))
        }
        (Around { center, radius }, Around { center: c, radius: r }) => {
            (center - c).norm() < radius + r
        }
        (Around { center, radius }, Within { min, max })
        | (Within { min, max }, Around { center, radius }) => {
            (center - center.sup(min).inf(max)).norm() < *radius
        }
        (Within { min, max }, Within { min: low, max: high }) => {
            (0..3).all(|k| min[k] < high[k] && low[k] < max[k])
        }
    }
}
