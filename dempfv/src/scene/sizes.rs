//! `cloud`: spheres at random places in the box, and how large they are.

use serde::Serialize;

use super::grading::{Curve, GradingCurve, LogNormal, Normal};
use super::keys::{Keyed, Keys};
use super::kind::{Count, Kind, Number, OneOf, inline, number};
use super::schema::Schema;
use super::table::{Bound, Table, Value};
use super::wrong::Wrong;
use crate::domain::Aabb;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "`cloud`",
    &["count", "porosity", "radius", "spread", "sizes", "sizes_by", "curve", "log_normal"],
);

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
    /// A grading curve by mass.
    Curve(GradingCurve),
    /// A log-normal grading by mass.
    LogNormal(LogNormal),
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
        4.0 / 3.0 * std::f64::consts::PI * self.moments()[1]
    }

    /// Diameter with the mean ratio of volume to surface, 2 Σ r³ / Σ r² (m).
    pub fn sauter_diameter(&self) -> f64 {
        let [square, cube] = self.moments();
        2.0 * cube / square
    }

    /// Means of r² and r³ by number (m², m³).
    fn moments(&self) -> [f64; 2] {
        match self {
            // Of the uniform distribution m² (1 + s²/3) and m³ (1 + s²).
            Sizes::Uniform { mean, spread } => {
                let s2 = spread * spread;
                [mean.powi(2) * (1.0 + s2 / 3.0), mean.powi(3) * (1.0 + s2)]
            }
            Sizes::Classes(classes) => {
                [2, 3].map(|k| classes.iter().map(|c| c.share * c.radius.powi(k)).sum())
            }
            Sizes::Curve(curve) => of_curve(curve),
            Sizes::LogNormal(grading) => of_curve(&grading.curve()),
        }
    }

    /// Smallest radius that can be drawn (m).
    pub fn smallest(&self) -> f64 {
        self.ends()[0]
    }

    /// Largest radius that can be drawn (m).
    pub fn largest(&self) -> f64 {
        self.ends()[1]
    }

    fn ends(&self) -> [f64; 2] {
        match self {
            Sizes::Uniform { mean, spread } => [mean * (1.0 - spread), mean * (1.0 + spread)],
            Sizes::Classes(classes) => {
                let radii = classes.iter().map(|c| c.radius);
                radii.fold([f64::INFINITY, 0.0], |[a, b], r| [a.min(r), b.max(r)])
            }
            Sizes::Curve(curve) => curve.ends().map(|d| 0.5 * d),
            Sizes::LogNormal(grading) => grading.curve().ends().map(|d| 0.5 * d),
        }
    }

    /// The grading by mass that is asked for, if one is.
    pub fn grading_curve(&self) -> Option<GradingCurve> {
        match self {
            Sizes::Curve(curve) => Some(curve.clone()),
            Sizes::LogNormal(grading) => Some(grading.curve()),
            Sizes::Uniform { .. } | Sizes::Classes(_) => None,
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

/// Means of r² and r³ by number (m², m³): the number of spheres goes with d⁻³ by mass.
fn of_curve(curve: &GradingCurve) -> [f64; 2] {
    let number = curve.moment(-3);
    [0.25 * curve.moment(-1) / number, 0.125 / number]
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
            Sizes::Curve(curve) => keys.take("curve", &Curve, curve),
            Sizes::LogNormal(grading) => keys.take("log_normal", &Normal, grading),
        }
    }
}

/// Keys that say how large the spheres are.
const SIZES: [&str; 5] = ["porosity", "radius", "sizes", "curve", "log_normal"];

/// Reads the one of these keys that is there, with what goes with it.
fn read_sizes(value: &Value, table: &Table, bounds: &Aabb, count: u32) -> Result<Sizes> {
    const WANTED: &str = "give one of `porosity`, `radius` (the mean, m), `sizes` ([[radius, share], ...]), \
                          `curve` ([[diameter, finer], ...]), `log_normal` ({ median, deviation })";
    let mut given = SIZES.iter().filter_map(|key| table.get(key));
    let Some(v) = given.next() else {
        return Err(value.error("does not say how large the spheres are", WANTED));
    };
    if given.next().is_some() {
        let problem = "has more than one of `porosity`, `radius`, `sizes`, `curve`, `log_normal`";
        return Err(value.error(problem, "keep one: each says how large the spheres are"));
    }
    for (key, with) in [("spread", &["porosity", "radius"][..]), ("sizes_by", &["sizes"])] {
        if let Some(other) = table.get(key).filter(|_| !with.contains(&v.key())) {
            return Err(other.error(&format!("stands beside `{}`", v.key()), "keep one of the two"));
        }
    }
    let spread = table.get("spread").map_or(Ok(0.0), |v| SPREAD.read(&v))?;
    match v.key() {
        "porosity" => {
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
        "radius" => Ok(Sizes::Uniform { mean: RADIUS.read(&v)?, spread }),
        "curve" => Curve.read(&v).map(Sizes::Curve),
        "log_normal" => Normal.read(&v).map(Sizes::LogNormal),
        _ => {
            let mut classes = Classes.read(&v)?;
            let by_mass = OneOf(&[("number", false), ("mass", true)]);
            if table.get("sizes_by").map_or(Ok(false), |by| by_mass.read(&by))? {
                by_number(&mut classes);
            }
            Ok(Sizes::Classes(classes))
        }
    }
}

/// Shares of the mass become shares of the number.
fn by_number(classes: &mut [SizeClass]) {
    classes.iter_mut().for_each(|class| class.share /= class.radius.powi(3));
    let total: f64 = classes.iter().map(|c| c.share).sum();
    classes.iter_mut().for_each(|class| class.share /= total);
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
