//! `[particles]`: the spheres, where they come from and what they are made of.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::clump::Members;
use super::keys::{Keyed, Keys};
use super::kind::{Angle, Maybe, number, quoted};
use super::schema::Schema;
use super::sizes::Cloud;
use super::table::{Bound, Table, Value};
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::effects::{CLUMPS, CONTACTS, FRICTION};
use crate::dem::{ClumpTemplate, Material};
use crate::domain::Aabb;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[particles]",
    &["packing", "cloud", "clump", "density", "young", "stiffness_ratio", "friction_angle"],
);

/// The spheres: where they come from and what they are made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Particles {
    /// Where they come from. Default: a [`Cloud`].
    pub source: ParticleSource,
    /// The clump that takes the place of each sphere of a cloud. Default: single spheres.
    pub clump: Option<ClumpTemplate>,
    /// What they are made of. Default: ρ = 2600 kg/m³, E = 1e6 Pa, k_s/k_n = 0.5, φ = 30°.
    #[serde(flatten)]
    pub material: Material,
}

/// Where the spheres come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ParticleSource {
    /// A packing file. A relative path in the scene has been joined to the scene's folder.
    Packing(PathBuf),
    /// Random positions in the box, without overlaps.
    Cloud(Cloud),
}

impl Default for Particles {
    fn default() -> Particles {
        let material = Material {
            young: 1e6,
            stiffness_ratio: 0.5,
            friction_angle: 30f64.to_radians(),
            density: 2600.0,
        };
        Particles { source: ParticleSource::default(), clump: None, material }
    }
}

impl Default for ParticleSource {
    fn default() -> ParticleSource {
        ParticleSource::Cloud(Cloud::default())
    }
}

impl Keyed for Particles {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    /// The source may depend on the box: it is read apart.
    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        match (&*keys, &self.source) {
            (Keys::Check(_), ParticleSource::Cloud(cloud)) => cloud.check()?,
            (Keys::Read(_) | Keys::Check(_), _) => {}
            (Keys::Write(_), _) => keys.push(self.source.to_toml()),
        }
        keys.take("clump", &Maybe(Members), &mut self.clump)?;
        let read_from_file = matches!(self.source, ParticleSource::Packing(_));
        let stray = || {
            let problem = "stands beside `packing`, whose spheres stay as they are";
            Wrong::new(problem, "take a `cloud`, or leave it out")
        };
        keys.rule("clump", (read_from_file && self.clump.is_some()).then(stray))?;
        let m = &mut self.material;
        keys.take("density", &number("kg/m³", Bound::Positive), &mut m.density)?;
        keys.take("young", &number("Pa", Bound::Positive), &mut m.young)?;
        keys.take("stiffness_ratio", &number("", Bound::NotNegative), &mut m.stiffness_ratio)?;
        keys.take("friction_angle", &Angle, &mut m.friction_angle)
    }
}

impl Particles {
    /// Reads the table of a scene whose box is known or not.
    pub(super) fn read_in(value: &Value, bounds: Option<&Aabb>) -> Result<Particles> {
        let table = value.table(&SCHEMA)?;
        let source = read_source(&table, bounds)?;
        Particles { source, ..Particles::default() }.read(&table)
    }

    /// What is wrong between the spheres and the box.
    pub(super) fn wrong_in(&self, bounds: Option<&Aabb>) -> Option<Wrong> {
        match &self.source {
            ParticleSource::Cloud(cloud) => cloud.wrong_in(bounds),
            ParticleSource::Packing(_) => None,
        }
    }

    /// Shear stiffness and friction between spheres: without either, contacts are smooth.
    pub(super) fn has_friction(&self) -> bool {
        self.material.friction_angle > 0.0 && self.material.stiffness_ratio > 0.0
    }

    /// Effects of this table, where spheres move or not.
    pub(super) fn effects(&self, contacts: bool) -> [(&'static Effect, bool); 3] {
        [
            (&CONTACTS, contacts),
            (&FRICTION, contacts && self.has_friction()),
            (&CLUMPS, contacts && self.clump.is_some()),
        ]
    }
}

impl ParticleSource {
    fn to_toml(&self) -> (&'static str, String) {
        match self {
            ParticleSource::Packing(path) => ("packing", quoted(&path.to_string_lossy())),
            ParticleSource::Cloud(cloud) => ("cloud", cloud.to_toml()),
        }
    }
}

fn read_source(table: &Table, bounds: Option<&Aabb>) -> Result<ParticleSource> {
    match (table.get("packing"), table.get("cloud")) {
        (Some(file), None) => Ok(ParticleSource::Packing(read_packing_path(&file)?)),
        (None, Some(cloud)) => Ok(ParticleSource::Cloud(Cloud::read_in(&cloud, bounds)?)),
        (Some(file), Some(cloud)) => {
            let later = if file.at > cloud.at { file } else { cloud };
            Err(later.error("is a second source of spheres", "keep `packing` or `cloud`"))
        }
        (None, None) => Err(table.source.error(
            table.at,
            "[particles] has neither `packing` nor `cloud`",
            "give `packing = \"FILE\"` or `cloud = { count = 1000, porosity = 0.95 }`",
        )),
    }
}

fn read_packing_path(value: &Value) -> Result<PathBuf> {
    let name = value.text("the name of a packing file")?;
    let folder = value.source.file.and_then(Path::parent);
    let path = folder.map_or_else(|| PathBuf::from(name), |f| f.join(name));
    if path.is_file() {
        return Ok(path);
    }
    Err(value.error(
        &format!("is \"{name}\", but there is no file {}", path.display()),
        "name an existing packing file; a relative name starts at the scene's folder",
    ))
}
