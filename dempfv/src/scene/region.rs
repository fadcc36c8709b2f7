//! Pores of choice with what they are told: a ball or a box, and a pressure or a rate.

use super::kind::{Kind, Vector, inline};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::input::InputError;
use crate::pfv::terms::PoreSource;
use crate::pfv::{ImposedPressure, PoreSelection};

type Result<T> = std::result::Result<T, InputError>;

pub(super) static IMPOSED: Schema =
    Schema::table("`imposed`", &["center", "radius", "min", "max", "pressure"]);
pub(super) static SOURCES: Schema =
    Schema::table("`sources`", &["center", "radius", "min", "max", "rate"]);

/// Pores with an imposed pressure.
pub(super) struct ImposedRegion;
/// Pores that fluid enters.
pub(super) struct SourceRegion;

impl Kind<ImposedPressure> for ImposedRegion {
    fn read(&self, value: &Value) -> Result<ImposedPressure> {
        let (pores, pressure) = read(value, &IMPOSED, "Pa")?;
        Ok(ImposedPressure { pores, pressure })
    }

    fn wrong(&self, imposed: &ImposedPressure) -> Option<Wrong> {
        wrong(&imposed.pores, imposed.pressure)
    }

    fn write(&self, imposed: &ImposedPressure) -> Option<String> {
        write(&imposed.pores, ("pressure", imposed.pressure))
    }
}

impl Kind<PoreSource> for SourceRegion {
    fn read(&self, value: &Value) -> Result<PoreSource> {
        let (pores, rate) = read(value, &SOURCES, "m³/s")?;
        Ok(PoreSource { pores, rate })
    }

    fn wrong(&self, source: &PoreSource) -> Option<Wrong> {
        wrong(&source.pores, source.rate)
    }

    fn write(&self, source: &PoreSource) -> Option<String> {
        write(&source.pores, ("rate", source.rate))
    }
}

/// The pores of an entry, and its value, the last of its keys.
fn read(value: &Value, schema: &'static Schema, unit: &str) -> Result<(PoreSelection, f64)> {
    let table = value.table(schema)?;
    let key = schema.keys[schema.keys.len() - 1];
    let number = table.need(key, "what these pores are told")?.number(unit, Bound::Finite)?;
    let is_ball = table.get("center").is_some() || table.get("radius").is_some();
    let is_box = table.get("min").is_some() || table.get("max").is_some();
    if is_ball == is_box {
        return Err(value.error(
            "has an entry that is not one ball or one box",
            "give `center` and `radius`, or `min` and `max`",
        ));
    }
    let point = |key: &str, what: &str| table.need(key, what)?.vector("m");
    let pores = if is_ball {
        PoreSelection::Around {
            center: point("center", "the middle of a ball (m)")?,
            radius: table
                .need("radius", "the radius of a ball (m)")?
                .number("m", Bound::Positive)?,
        }
    } else {
        PoreSelection::Within {
            min: point("min", "the lower corner of a box (m)")?,
            max: point("max", "the upper corner of a box (m)")?,
        }
    };
    wrong(&pores, number).map_or(Ok((pores, number)), |wrong| Err(value.wrong(wrong)))
}

fn wrong(pores: &PoreSelection, number: f64) -> Option<Wrong> {
    let problem = |problem: &str, remedy: &str| Some(Wrong::new(problem, remedy));
    if !number.is_finite() {
        return problem("has an entry whose value is not finite", "give a finite number");
    }
    match pores {
        PoreSelection::Pores(_) => problem(
            "has pores by their numbers, which the next network does not know",
            "give a ball or a box",
        ),
        PoreSelection::Around { center, radius }
            if *radius > 0.0 && radius.is_finite() && center.iter().all(|x| x.is_finite()) =>
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

fn write(pores: &PoreSelection, (key, number): (&'static str, f64)) -> Option<String> {
    let point = |x| Vector("m").write(x);
    let mut entries = match pores {
        PoreSelection::Pores(_) => return None,
        PoreSelection::Around { center, radius } => {
            vec![("center", point(center)?), ("radius", format!("{radius:?}"))]
        }
        PoreSelection::Within { min, max } => vec![("min", point(min)?), ("max", point(max)?)],
    };
    entries.push((key, format!("{number:?}")));
    Some(inline(&entries))
}
