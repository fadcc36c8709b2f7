//! `[[material]]` and `[[pair]]`: spheres of another material, and what two materials have against
//! each other.

use serde::Serialize;

use super::choice::SphereChoice;
use super::keys::{Keyed, Keys};
use super::kind::{Angle, Array, Kind, Maybe, number, quoted};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::effects::MATERIALS;
use crate::dem::{Material, MaterialPair};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static MATERIAL: Schema = Schema::table(
    "[[material]]",
    &[
        "name",
        "numbers",
        "center",
        "radius",
        "min",
        "max",
        "radii",
        "density",
        "young",
        "stiffness_ratio",
        "friction_angle",
    ],
);
pub(super) static PAIR: Schema =
    Schema::table("[[pair]]", &["between", "young", "stiffness_ratio", "friction_angle"]);

/// The name of the material of [particles].
const FIRST: &str = "particles";

/// Some of the spheres, of another material than that of `[particles]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OtherMaterial {
    /// Its name.
    pub name: String,
    /// Which spheres, by their places when the run begins. Of several tables the last one counts.
    #[serde(flatten)]
    pub which: SphereChoice,
    /// Density of the solid (kg/m³). Default: that of `[particles]`, and so on.
    pub density: Option<f64>,
    /// Modulus (Pa).
    pub young: Option<f64>,
    /// Shear stiffness over normal stiffness.
    pub stiffness_ratio: Option<f64>,
    /// Friction angle (rad).
    pub friction_angle: Option<f64>,
}

/// What two materials have against each other, in the place of what follows from both.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Pair {
    /// Their names; `"particles"` is that of `[particles]`.
    pub between: Vec<String>,
    /// Modulus that both have here (Pa).
    pub young: Option<f64>,
    /// Shear stiffness over normal stiffness.
    pub stiffness_ratio: Option<f64>,
    /// Friction angle (rad).
    pub friction_angle: Option<f64>,
}

/// A name.
struct Name;

impl Kind<String> for Name {
    fn read(&self, value: &Value) -> Result<String> {
        value.text("the name of a material").map(str::to_owned)
    }

    fn wrong(&self, name: &String) -> Option<Wrong> {
        name.is_empty().then(|| Wrong::new("is empty", "give a name, as \"gravel\""))
    }

    fn write(&self, name: &String) -> Option<String> {
        Some(quoted(name))
    }
}

impl Keyed for OtherMaterial {
    fn schema(&self) -> &'static Schema {
        &MATERIAL
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.need("name", "its name, as \"gravel\"", &Name, &mut self.name)?;
        self.which.keys(keys)?;
        keys.take("density", &Maybe(number("kg/m³", Bound::Positive)), &mut self.density)?;
        keys.take("young", &Maybe(number("Pa", Bound::Positive)), &mut self.young)?;
        let ratio = number("", Bound::NotNegative);
        keys.take("stiffness_ratio", &Maybe(ratio), &mut self.stiffness_ratio)?;
        keys.take("friction_angle", &Maybe(Angle), &mut self.friction_angle)
    }
}

impl Keyed for Pair {
    fn schema(&self) -> &'static Schema {
        &PAIR
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        let names = Array { items: Name, form: "two names, as in [\"particles\", \"gravel\"]" };
        keys.need("between", "the names of two materials", &names, &mut self.between)?;
        let wrong = (self.between.len() != 2)
            .then(|| Wrong::new("is no pair", "give two names, as in [\"particles\", \"gravel\"]"));
        keys.rule("between", wrong)?;
        keys.take("young", &Maybe(number("Pa", Bound::Positive)), &mut self.young)?;
        let ratio = number("", Bound::NotNegative);
        keys.take("stiffness_ratio", &Maybe(ratio), &mut self.stiffness_ratio)?;
        keys.take("friction_angle", &Maybe(Angle), &mut self.friction_angle)
    }
}

/// All materials, that of `[particles]` first.
pub(super) fn all(first: &Material, others: &[OtherMaterial]) -> Vec<Material> {
    let other = |m: &OtherMaterial| Material {
        young: m.young.unwrap_or(first.young),
        stiffness_ratio: m.stiffness_ratio.unwrap_or(first.stiffness_ratio),
        friction_angle: m.friction_angle.unwrap_or(first.friction_angle),
        density: m.density.unwrap_or(first.density),
    };
    std::iter::once(*first).chain(others.iter().map(other)).collect()
}

/// The index of a material by its name.
fn index(name: &str, others: &[OtherMaterial]) -> Option<u16> {
    let names = std::iter::once(FIRST).chain(others.iter().map(|m| m.name.as_str()));
    (0u16..).zip(names).find(|(_, other)| *other == name).map(|(index, _)| index)
}

/// The pairs by the indices of their materials; those with unknown names are left out.
pub(super) fn pairs(pairs: &[Pair], others: &[OtherMaterial]) -> Vec<MaterialPair> {
    let by_index = |pair: &Pair| {
        let [first, second] = &pair.between[..] else { return None };
        let Pair { young, stiffness_ratio, friction_angle, .. } = *pair;
        let between = [index(first, others)?, index(second, others)?];
        Some(MaterialPair { between, young, stiffness_ratio, friction_angle })
    };
    pairs.iter().filter_map(by_index).collect()
}

/// What is wrong between the tables.
pub(super) fn wrong(others: &[OtherMaterial], pairs: &[Pair]) -> Option<Wrong> {
    let twice = |(i, m): (usize, &OtherMaterial)| {
        m.name == FIRST || others[..i].iter().any(|other| other.name == m.name)
    };
    if let Some(i) = others.iter().enumerate().position(twice) {
        let problem = format!("[[material]] has the name \"{}\" twice", others[i].name);
        return Some(Wrong::new(
            problem,
            "give each its own; \"particles\" is that of [particles]",
        ));
    }
    let unknown = |name: &&String| index(name, others).is_none();
    pairs.iter().flat_map(|pair| &pair.between).find(unknown).map(|name| {
        let names: Vec<&str> = others.iter().map(|m| m.name.as_str()).collect();
        let problem =
            format!("[[pair]] is between \"{name}\" and another, and there is no such material");
        Wrong::new(problem, format!("give two of {FIRST}, {}", names.join(", ")))
    })
}

/// Names of the effects of these tables.
pub(super) fn described(of: &[OtherMaterial], moves: bool) -> [(&'static Effect, bool); 1] {
    [(&MATERIALS, moves && !of.is_empty())]
}
