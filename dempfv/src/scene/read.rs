//! TOML text to [`Plan`], and back.

use std::path::Path;

use toml::de::DeTable;

use super::accuracy::{self, Accuracy};
use super::bonds::{self, Bonds};
use super::cell::{self, CellShape};
use super::contacts::{self, Contacts};
use super::dem::{self, Dem};
use super::fluid::{self, Fluid};
use super::grading;
use super::keys::{Keyed, Keys};
use super::kind::{Count, Kind, Vector, quoted};
use super::materials::{self, OtherMaterial, Pair};
use super::motion::{self, GivenMotion};
use super::output::{self, Output};
use super::packing_check::box_wrong;
use super::particles::{self, Particles};
use super::plan::{self, Place, Plan};
use super::region;
use super::schema::Schema;
use super::sizes;
use super::stage::{Before, Stage, cell_controls, compact, consolidate, control, cycle};
use super::stage::{flow, permeability, run, until};
use super::syntax;
use super::table::{Source, Table, Value};
use super::time_function;
use super::wall_pressure;
use super::walls::{self, Walls};
use super::watched;
use crate::domain::Aabb;
use crate::error::Error;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// All tables of a scene.
static SCHEMAS: [&Schema; 36] = [
    &plan::SCHEMA,
    &plan::BOX,
    &cell::SCHEMA,
    &particles::SCHEMA,
    &materials::MATERIAL,
    &materials::PAIR,
    &sizes::SCHEMA,
    &grading::LOG_NORMAL,
    &walls::SCHEMA,
    &contacts::SCHEMA,
    &bonds::SCHEMA,
    &dem::SCHEMA,
    &motion::SCHEMA,
    &fluid::SCHEMA,
    &accuracy::SCHEMA,
    &fluid::PRESSURE,
    &time_function::SCHEMA,
    &wall_pressure::SCHEMA,
    &region::IMPOSED,
    &region::SOURCES,
    &region::BLOCKED,
    &region::CONDUCTANCE_REGIONS,
    &output::SCHEMA,
    &watched::REGIONS,
    &watched::SECTION,
    &compact::SCHEMA,
    &cycle::SCHEMA,
    &permeability::SCHEMA,
    &flow::SCHEMA,
    &consolidate::SCHEMA,
    &run::SCHEMA,
    &until::SCHEMA,
    &control::WALLS,
    &control::CONTROL,
    &cell_controls::GRADIENT,
    &cell_controls::STRESS,
];

/// Every key that a scene may hold, table by table: how messages name the table (`[dem]`,
/// `a compact stage`), and its keys.
///
/// ```
/// let (_, keys) = dempfv::scene::known_keys().find(|(table, _)| *table == "[dem]").unwrap();
/// assert!(keys.contains(&"damping"));
/// ```
pub fn known_keys() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    SCHEMAS.iter().map(|schema| (schema.name, schema.keys))
}

impl Plan {
    /// Reads a scene.
    ///
    /// `file` is named in errors, and a relative packing path is taken from its folder.
    /// The packing file must exist, but is not read.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and what would be right.
    ///
    /// ```
    /// let plan = dempfv::scene::Plan::from_toml(r#"
    ///     [box]
    ///     min = [0, 0, 0]
    ///     max = [1, 1, 1]
    ///     [particles]
    ///     cloud = { count = 100, porosity = 0.9 }
    ///     [dem]
    ///     [[stage]]
    ///     kind = "compact"
    ///     stress = 1e4
    /// "#, None).unwrap();
    /// assert!(plan.fluid.is_none());
    ///
    /// let error = dempfv::scene::Plan::from_toml("sede = 1", None).unwrap_err();
    /// assert_eq!(error.line, Some(1));
    /// assert_eq!(error.remedy, "did you mean `seed`?");
    /// ```
    pub fn from_toml(text: &str, file: Option<&Path>) -> Result<Plan> {
        let source = Source { text, file, schemas: &SCHEMAS };
        let document = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(0, |s| s.start);
            source.error(at, format!("not TOML: {}", e.message()), syntax::remedy(text, at))
        })?;
        let root = Table::new(&source, &plan::SCHEMA, document.get_ref(), 0)?;
        let plan = read(&root)?;
        plan.rules().map_err(|fault| {
            let at = match fault.place {
                Place::Stage(i) => {
                    root.get("stage").and_then(|s| Some(s.items("").ok()?.get(i)?.at))
                }
                Place::Table(key) => root.get(key).map(|v| v.at),
            };
            source.error(at.unwrap_or(0), fault.what, fault.remedy)
        })?;
        Ok(plan)
    }

    /// Reads a scene file; see [`Plan::from_toml`].
    ///
    /// # Errors
    /// [`Error::Input`] when the file is not there or cannot be read, or something in it is
    /// wrong.
    pub fn load(path: impl AsRef<Path>) -> std::result::Result<Plan, Error> {
        let path = path.as_ref();
        let wrong = |what: String| InputError::new(what, "name a scene file in TOML").in_file(path);
        let bytes =
            std::fs::read(path).map_err(|e| wrong(format!("cannot read the scene: {e}")))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| wrong("the scene is not text, perhaps a checkpoint".to_owned()))?;
        Ok(Plan::from_toml(&text, Some(path))?)
    }

    /// The plan as a scene file, with every default written out.
    ///
    /// Of a plan that is valid, [`from_toml`](Plan::from_toml) makes the same plan again. A
    /// relative packing path starts at the current folder then. Angles are in degrees: one
    /// that no number of degrees is, comes back as the nearest (within 10⁻¹⁵ of itself).
    ///
    /// ```
    /// use dempfv::scene::{Dem, Plan, Run, Stage, StageKind};
    /// let plan = Plan {
    ///     dem: Some(Dem::default()),
    ///     stages: vec![Stage::new("shake", StageKind::Run(Run::default()))],
    ///     ..Plan::default()
    /// };
    /// assert_eq!(Plan::from_toml(&plan.to_toml(), None)?, plan);
    /// # Ok::<(), dempfv::InputError>(())
    /// ```
    pub fn to_toml(&self) -> String {
        let mut text = format!("title = {}\nseed = {}\n", quoted(&self.title), self.seed);
        let mut table = |head: &str, entries: Vec<(&'static str, String)>| {
            text += &format!("\n{head}\n");
            text.extend(entries.iter().map(|(key, value)| format!("{key} = {value}\n")));
        };
        if let Some(Aabb { min, max }) = &self.bounds {
            let corner = |x| Vector("m").write(x).unwrap_or_default();
            table("[box]", vec![("min", corner(min)), ("max", corner(max))]);
        }
        self.cell.iter().for_each(|cell| table("[cell]", cell.write()));
        table("[particles]", self.particles.write());
        self.other_materials.iter().for_each(|m| table("[[material]]", m.write()));
        self.pairs.iter().for_each(|pair| table("[[pair]]", pair.write()));
        if self.cell.is_none() {
            table("[walls]", self.walls.write());
        }
        if self.contacts != Contacts::default() {
            table("[contacts]", self.contacts.write());
        }
        self.bonds.iter().for_each(|bonds| table("[bonds]", bonds.write()));
        self.dem.iter().for_each(|dem| table("[dem]", dem.write()));
        self.motions.iter().for_each(|motion| table("[[motion]]", motion.write()));
        self.fluid.iter().for_each(|fluid| table("[fluid]", fluid.write()));
        self.accuracy.iter().for_each(|accuracy| table("[accuracy]", accuracy.write()));
        self.stages.iter().for_each(|stage| table("[[stage]]", stage.write()));
        table("[output]", self.output.write());
        text
    }
}

/// Reads the whole scene.
fn read(root: &Table) -> Result<Plan> {
    let file = root.source.file.map(Path::to_path_buf);
    let title = match root.get("title") {
        Some(v) => v.text("the scene's title")?.to_owned(),
        None => file
            .as_deref()
            .and_then(Path::file_stem)
            .map_or_else(|| "untitled".to_owned(), |s| s.to_string_lossy().into_owned()),
    };
    let mut seed = 1;
    Keys::Read(root).take("seed", &Count(0), &mut seed)?;
    let bounds = root.get("box").map(|v| read_box(&v)).transpose()?;
    let cell = root.get("cell").map(|v| CellShape::read(&v)).transpose()?;
    let room = bounds.or(cell.and_then(|cell| cell.room()));
    let particles = root.need("particles", "[particles] with `packing` or `cloud`")?;
    let particles = Particles::read_in(&particles, room.as_ref())?;
    let other_materials =
        read_array(root, "material", &materials::MATERIAL, OtherMaterial::default())?;
    let pairs = read_array(root, "pair", &materials::PAIR, Pair::default())?;
    if let Some(table) = root.get("walls").filter(|_| cell.is_some()) {
        let (what, remedy) = plan::WALLS_IN_CELL;
        return Err(root.source.error(table.at, what, remedy));
    }
    let walls = Walls::as_stiff_as(particles.material.young);
    let walls = read_or(root, "walls", walls.clone())?.unwrap_or(walls);
    let contacts = read_or(root, "contacts", Contacts::default())?.unwrap_or_default();
    let bonds = read_or(root, "bonds", Bonds::default())?;
    let dem = read_or(root, "dem", Dem::default())?;
    let motions = read_array(root, "motion", &motion::SCHEMA, GivenMotion::default())?;
    let fluid = read_or(root, "fluid", Fluid::default())?;
    let accuracy = read_or(root, "accuracy", Accuracy::default())?;
    let stages = read_stages(root, &Before { walls: &walls, has_fluid: fluid.is_some() })?;
    let output = match root.get("output") {
        Some(value) => read_output(&value, bounds.as_ref(), fluid.is_some())?,
        None => Output::default(),
    };
    Ok(Plan {
        title,
        file,
        seed,
        bounds,
        cell,
        particles,
        other_materials,
        pairs,
        walls,
        contacts,
        bonds,
        dem,
        motions,
        fluid,
        accuracy,
        stages,
        output,
    })
}

/// A table, where it is there: its defaults, and what it says otherwise.
fn read_or<T: Keyed>(root: &Table, key: &str, defaults: T) -> Result<Option<T>> {
    let Some(value) = root.get(key) else { return Ok(None) };
    let table = value.table(defaults.schema())?;
    defaults.read(&table).map(Some)
}

/// Tables that a scene may have several of.
fn read_array<T: Keyed>(
    root: &Table,
    key: &str,
    schema: &'static Schema,
    defaults: T,
) -> Result<Vec<T>> {
    let Some(value) = root.get(key) else { return Ok(vec![]) };
    let items = value.items(&format!("one or more [[{key}]] tables"))?;
    items.iter().map(|item| defaults.clone().read(&item.table(schema)?)).collect()
}

fn read_box(value: &Value) -> Result<Aabb> {
    let table = value.table(&plan::BOX)?;
    let min = table.need("min", "the smallest x, y, z in m")?.vector("m")?;
    let upper = table.need("max", "the largest x, y, z in m")?;
    let bounds = Aabb { min, max: upper.vector("m")? };
    match box_wrong(&bounds) {
        Some(wrong) => Err(upper.wrong(wrong)),
        None => Ok(bounds),
    }
}

fn read_stages(root: &Table, before: &Before) -> Result<Vec<Stage>> {
    const WANTED: &str = "one or more [[stage]] tables";
    let value = root.need("stage", WANTED)?;
    let items = value.items(WANTED)?;
    if items.is_empty() {
        return Err(value.error("is empty", format!("add {WANTED}")));
    }
    let mut stages = Vec::with_capacity(items.len());
    for item in items {
        let stage = Stage::read(&item, &stages, before)?;
        stages.push(stage);
    }
    Ok(stages)
}

/// Probes lie inside the box, as far as the scene says where that is.
fn read_output(value: &Value, bounds: Option<&Aabb>, has_fluid: bool) -> Result<Output> {
    let table = value.table(&output::SCHEMA)?;
    let output = Output::default().read(&table)?;
    output.rules(&Keys::Read(&table), bounds, has_fluid)?;
    Ok(output)
}
