//! `cloud`: spheres at random places in the box, and how large they are.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Count, Kind, Number, inline, number};
use super::schema::Schema;
use super::table::{Bound, Table, Value};
use super::wrong::Wrong;
use crate::domain::Aabb;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("`cloud`", &["count", "porosity", "radius", "spread", "sizes"]);

const RADIUS: Number = number("m", Bound::Positive);
const SHARE: Number = number("", Bound::Positive);
const SPREAD: Number = number("(half width over mean)", Bound::BelowOne);

/// A random cloud of spheres without overlaps, drawn with the scene's seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cloud {
    /// Number of spheres, at least 1.
    pub count: u32,
    /// Their radii.
    pub sizes: Sizes,
}

/// Distribution of radii.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sizes {
    /// Uniform in `mean·(1 ± spread)`.
    Uniform {
        /// Mean radius (m). Where the scene gives a porosity, the mean that gives that
        /// porosity in the box.
        mean: f64,
        /// Half width over mean (1), in [0, 1). Default 0: all alike.
        spread: f64,
    },
    /// A few radii with their shares.
    Classes(Vec<SizeClass>),
}

/// One class of a size distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SizeClass {
    /// Radius (m).
    pub radius: f64,
    /// Share of the number of spheres; the shares of all classes add up to 1.
    pub share: f64,
}

impl Default for Cloud {
    /// 1000 equal spheres, which leave a porosity of 0.9 in a box of 1 m³.
    fn default() -> Cloud {
        let unit = Sizes::Uniform { mean: 1.0, spread: 0.0 };
        Cloud { count: 1000, sizes: unit.for_porosity(0.9, 1.0, 1000) }
    }
}

impl Sizes {
    /// Expected volume of one sphere (m³).
    pub fn mean_volume(&self) -> f64 {
        let mean_cube = match self {
            // Third moment of the uniform distribution: m³ (1 + s²).
            Sizes::Uniform { mean, spread } => mean.powi(3) * (1.0 + spread * spread),
            Sizes::Classes(classes) => classes.iter().map(|c| c.share * c.radius.powi(3)).sum(),
        };
        4.0 / 3.0 * std::f64::consts::PI * mean_cube
    }

    /// Diameter with the mean ratio of volume to surface, 2 Σ r³ / Σ r² (m).
    pub fn sauter_diameter(&self) -> f64 {
        let mean_square = match self {
            // Second moment of the uniform distribution: m² (1 + s²/3).
            Sizes::Uniform { mean, spread } => mean.powi(2) * (1.0 + spread * spread / 3.0),
            Sizes::Classes(classes) => classes.iter().map(|c| c.share * c.radius.powi(2)).sum(),
        };
        2.0 * self.mean_volume() / (4.0 / 3.0 * std::f64::consts::PI * mean_square)
    }

    /// Smallest radius that can be drawn (m).
    pub fn smallest(&self) -> f64 {
        match self {
            Sizes::Uniform { mean, spread } => mean * (1.0 - spread),
            Sizes::Classes(classes) => {
                classes.iter().map(|c| c.radius).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Largest radius that can be drawn (m).
    pub fn largest(&self) -> f64 {
        match self {
            Sizes::Uniform { mean, spread } => mean * (1.0 + spread),
            Sizes::Classes(classes) => classes.iter().map(|c| c.radius).fold(0.0, f64::max),
        }
    }

    /// Uniform radii whose `count` spheres leave a porosity in a volume (m³). `self` has the
    /// unit mean.
    fn for_porosity(&self, porosity: f64, volume: f64, count: u32) -> Sizes {
        let one = (1.0 - porosity) * volume / f64::from(count);
        let spread = if let Sizes::Uniform { spread, .. } = self { *spread } else { 0.0 };
        Sizes::Uniform { mean: (one / self.mean_volume()).cbrt(), spread }
    }
}

/// Random placement without overlaps jams at a solid fraction of 0.384 for equal spheres
/// (random sequential addition; Torquato, Uche and Stillinger 2006), a little above for
/// unequal ones.
const JAMMED: f64 = 0.38;

impl Cloud {
    /// Reads a cloud that fills a box, and checks that it does fit.
    pub(super) fn read_in(value: &Value, bounds: Option<&Aabb>) -> Result<Cloud> {
        let table = value.table(&SCHEMA)?;
        let Some(bounds) = bounds else { return Err(value.wrong(no_box())) };
        let mut cloud = Cloud::default().read(&table)?;
        cloud.sizes = read_sizes(value, &table, bounds, cloud.count)?;
        match cloud.wrong_in(Some(bounds)) {
            Some(wrong) => Err(value.wrong(wrong)),
            None => Ok(cloud),
        }
    }

    /// Why the cloud does not fit into a box.
    pub(super) fn wrong_in(&self, bounds: Option<&Aabb>) -> Option<Wrong> {
        let Some(bounds) = bounds else { return Some(no_box()) };
        let solid = f64::from(self.count) * self.sizes.mean_volume() / bounds.volume();
        if solid > JAMMED {
            return Some(Wrong::new(
                format!(
                    "has a porosity of {:.3}: spheres placed at random do not fit",
                    1.0 - solid
                ),
                format!("give fewer or smaller spheres, for a porosity above {}", 1.0 - JAMMED),
            ));
        }
        let (across, edge) = (2.0 * self.sizes.largest(), bounds.size().min());
        (across >= edge).then(|| {
            Wrong::new(
                format!("has spheres of {across:.4e} m across"),
                format!("give spheres smaller than the box's shortest edge, {edge:.4e} m"),
            )
        })
    }

    /// The cloud as a scene has it.
    pub(super) fn to_toml(&self) -> String {
        inline(&self.write())
    }
}

fn no_box() -> Wrong {
    Wrong::new("needs a box to fill", "add [box] with `min` and `max` in m")
}

impl Keyed for Cloud {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    /// What sizes a scene asks for may depend on the box: they are read apart.
    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.need("count", "the number of spheres", &Count(1), &mut self.count)?;
        if let Keys::Read(_) = keys {
            return Ok(());
        }
        match &mut self.sizes {
            Sizes::Uniform { mean, spread } => {
                keys.take("radius", &RADIUS, mean)?;
                keys.take("spread", &SPREAD, spread)
            }
            Sizes::Classes(classes) => {
                keys.take("sizes", &Classes, classes)?;
                keys.rule("sizes", shares_wrong(classes))
            }
        }
    }
}

/// Reads whichever of `porosity`, `radius` and `sizes` says how large the spheres are.
fn read_sizes(value: &Value, table: &Table, bounds: &Aabb, count: u32) -> Result<Sizes> {
    let spread = match table.get("spread") {
        Some(v) => SPREAD.read(&v)?,
        None => 0.0,
    };
    match (table.get("porosity"), table.get("radius"), table.get("sizes")) {
        (Some(v), None, None) => {
            let porosity = v.number("", Bound::InsideUnit)?;
            let unit = Sizes::Uniform { mean: 1.0, spread };
            let sizes = unit.for_porosity(porosity, bounds.volume(), count);
            let smallest = sizes.smallest();
            let wrong = || {
                let problem = format!("leaves spheres of {smallest:e} m in radius");
                Wrong::new(problem, "give another porosity, or a box in metres")
            };
            if smallest.is_normal() { Ok(sizes) } else { Err(v.wrong(wrong())) }
        }
        (None, Some(v), None) => Ok(Sizes::Uniform { mean: RADIUS.read(&v)?, spread }),
        (None, None, Some(v)) => match table.get("spread") {
            None => Ok(Sizes::Classes(Classes.read(&v)?)),
            Some(spread) => Err(spread.error("stands beside `sizes`", "keep one of the two")),
        },
        (None, None, None) => Err(value.error(
            "does not say how large the spheres are",
            "give one of `porosity`, `radius` (the mean, m), `sizes` ([[radius, share], ...])",
        )),
        _ => Err(value.error(
            "has more than one of `porosity`, `radius`, `sizes`",
            "keep one: each says how large the spheres are",
        )),
    }
}

/// Round-off that the sum of shares may have.
const ROUND_OFF: f64 = 1e-12;

fn shares_wrong(classes: &[SizeClass]) -> Option<Wrong> {
    let total: f64 = classes.iter().map(|c| c.share).sum();
    let holds = (total - 1.0).abs() <= ROUND_OFF;
    (!holds).then(|| {
        Wrong::new(format!("has shares that add up to {total}"), "give shares that add up to 1")
    })
}

/// Pairs of radius and share.
struct Classes;

impl Kind<Vec<SizeClass>> for Classes {
    /// Shares of another sum than 1 are divided by it.
    fn read(&self, value: &Value) -> Result<Vec<SizeClass>> {
        const WANTED: &str = "pairs of radius (m) and share, as in [[0.01, 0.4], [0.02, 0.6]]";
        let mut classes = Vec::new();
        for pair in value.items(WANTED)? {
            let items = pair.items(WANTED)?;
            let [radius, share] = items.as_slice() else {
                return Err(pair.error("has an item that is no pair", format!("give {WANTED}")));
            };
            classes.push(SizeClass { radius: RADIUS.read(radius)?, share: SHARE.read(share)? });
        }
        if classes.is_empty() {
            return Err(value.error("is empty", format!("give {WANTED}")));
        }
        if shares_wrong(&classes).is_some() {
            let total: f64 = classes.iter().map(|c| c.share).sum();
            classes.iter_mut().for_each(|class| class.share /= total);
        }
        Ok(classes)
    }

    fn wrong(&self, classes: &Vec<SizeClass>) -> Option<Wrong> {
        let wrong = |c: &SizeClass| RADIUS.wrong(&c.radius).or_else(|| SHARE.wrong(&c.share));
        let (i, wrong) = classes.iter().enumerate().find_map(|(i, c)| Some((i, wrong(c)?)))?;
        Some(Wrong::new(format!("has a pair {} that {}", i + 1, wrong.problem), wrong.remedy))
    }

    fn write(&self, classes: &Vec<SizeClass>) -> Option<String> {
        let pair = |c: &SizeClass| format!("[{:?}, {:?}]", c.radius, c.share);
        Some(format!("[{}]", classes.iter().map(pair).collect::<Vec<_>>().join(", ")))
    }
}
