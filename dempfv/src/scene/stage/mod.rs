//! `[[stage]]`: what happens, in order; one file per kind.

pub(super) mod cell_controls;
pub(super) mod compact;
pub(super) mod consolidate;
pub(crate) mod control;
pub(super) mod cycle;
pub(super) mod flow;
pub(super) mod permeability;
pub(super) mod run;
pub(super) mod until;

use std::borrow::Cow;

use serde::Serialize;

pub use compact::Compact;
pub use consolidate::Consolidate;
pub use cycle::Cycle;
pub use flow::FlowOnly;
pub use permeability::Permeability;
pub use run::Run;
pub use until::Until;

use super::dem::{DAMPING, Dem, Steps, TimeStep};
use super::fluid::Fluid;
use super::keys::{Keyed, Keys};
use super::kind::{Kind, Maybe, quoted};
use super::schema::Schema;
use super::table::{Table, Value};
use super::walls::Walls;
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::effects::{CELL_STRESS, GROWTH, MOVING_WALLS, SERVO_WALLS};
use crate::domain::Axis;
use crate::excerpt::excerpt;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// The name of a stage.
pub(super) struct StageName;

impl Kind<String> for StageName {
    fn read(&self, value: &Value) -> Result<String> {
        value.text("the name of a stage").map(str::to_owned)
    }

    fn wrong(&self, _: &String) -> Option<Wrong> {
        None
    }

    fn write(&self, name: &String) -> Option<String> {
        Some(quoted(name))
    }
}

/// Whether what begins with the stage named in `from`, or with the first, begins with this one.
pub(super) fn begins_with(from: Option<&str>, stage: &str, is_first: bool) -> bool {
    from.map_or(is_first, |from| from == stage)
}

/// A stage of the simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// Name, unlike any other stage's. Default: the kind, with a number from the second on.
    pub name: String,
    /// What happens.
    pub kind: StageKind,
    /// Time step of this stage. `None`: that of `[dem]`.
    pub dt: Option<TimeStep>,
    /// Local damping λ in this stage (1). `None`: that of `[dem]`.
    pub damping: Option<f64>,
}

/// What happens in a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StageKind {
    /// Growth of radii to an isotropic stress.
    Compact(Compact),
    /// Dry load and unload cycles that measure the oedometric modulus.
    Cycle(Cycle),
    /// Static flow through the packing at rest.
    Permeability(Permeability),
    /// The fluid alone, through spheres at rest.
    Flow(FlowOnly),
    /// Coupled one-dimensional consolidation.
    Consolidate(Consolidate),
    /// A number of steps under given wall motions.
    Run(Run),
}

impl StageKind {
    /// The kind's name in scene files.
    pub const fn name(&self) -> &'static str {
        match self {
            StageKind::Compact(_) => "compact",
            StageKind::Cycle(_) => "cycle",
            StageKind::Permeability(_) => "permeability",
            StageKind::Flow(_) => "flow",
            StageKind::Consolidate(_) => "consolidate",
            StageKind::Run(_) => "run",
        }
    }

    /// True when spheres move in this stage.
    pub const fn moves(&self) -> bool {
        !matches!(self, StageKind::Permeability(_) | StageKind::Flow(_))
    }

    /// True when the fluid flows under the conditions of its table in this stage.
    pub const fn has_conditions(&self) -> bool {
        self.is_coupled() || matches!(self, StageKind::Flow(_))
    }

    /// True when the flow is solved at every step of this stage, beside the motion of the spheres.
    pub const fn is_coupled(&self) -> bool {
        match self {
            StageKind::Consolidate(_) => true,
            StageKind::Run(run) => run.fluid,
            _ => false,
        }
    }

    /// The scene's fluid with the pressures of this stage, whose functions of time count from
    /// `start` on (s).
    pub fn fluid<'f>(&self, fluid: &'f Fluid, start: f64) -> Cow<'f, Fluid> {
        match self {
            StageKind::Run(Run { pressure: Some(walls), .. }) => {
                Cow::Owned(fluid.with_pressures(walls, start))
            }
            _ => Cow::Borrowed(fluid),
        }
    }

    /// True when a wall moves with a given velocity in this stage.
    pub fn has_moving_wall(&self) -> bool {
        matches!(self, StageKind::Run(run) if run.has_moving_wall())
    }

    /// True when a wall is held at a stress in this stage.
    pub fn has_servo(&self) -> bool {
        match self {
            StageKind::Cycle(_) | StageKind::Consolidate(_) => true,
            StageKind::Run(run) => run.has_servo(),
            StageKind::Compact(_) | StageKind::Permeability(_) | StageKind::Flow(_) => false,
        }
    }

    /// True when a component of the stress on a periodic cell is prescribed in this stage.
    pub fn has_cell_stress(&self) -> bool {
        matches!(self, StageKind::Run(run) if run.has_cell_stress())
    }

    fn schema(&self) -> &'static Schema {
        match self {
            StageKind::Compact(stage) => stage.schema(),
            StageKind::Cycle(stage) => stage.schema(),
            StageKind::Permeability(stage) => stage.schema(),
            StageKind::Flow(stage) => stage.schema(),
            StageKind::Consolidate(stage) => stage.schema(),
            StageKind::Run(stage) => stage.schema(),
        }
    }

    fn check(&self) -> Result<()> {
        match self {
            StageKind::Compact(stage) => stage.check(),
            StageKind::Cycle(stage) => stage.check(),
            StageKind::Permeability(stage) => stage.check(),
            StageKind::Flow(stage) => stage.check(),
            StageKind::Consolidate(stage) => stage.check(),
            StageKind::Run(stage) => stage.check(),
        }
    }

    fn write(&self) -> Vec<(&'static str, String)> {
        match self {
            StageKind::Compact(stage) => stage.write(),
            StageKind::Cycle(stage) => stage.write(),
            StageKind::Permeability(stage) => stage.write(),
            StageKind::Flow(stage) => stage.write(),
            StageKind::Consolidate(stage) => stage.write(),
            StageKind::Run(stage) => stage.write(),
        }
    }

    /// With what its table and the tables before say.
    fn read(mut self, table: &Table, before: &Before) -> Result<StageKind> {
        let max_velocity = before.walls.max_velocity;
        match &mut self {
            StageKind::Cycle(stage) => stage.max_velocity = max_velocity,
            StageKind::Consolidate(stage) => stage.max_velocity = max_velocity,
            StageKind::Run(stage) => stage.fluid = before.has_fluid,
            StageKind::Compact(_) | StageKind::Permeability(_) | StageKind::Flow(_) => {}
        }
        Ok(match self {
            StageKind::Compact(stage) => StageKind::Compact(stage.read(table)?),
            StageKind::Cycle(stage) => StageKind::Cycle(stage.read(table)?),
            StageKind::Permeability(stage) => StageKind::Permeability(stage.read(table)?),
            StageKind::Flow(stage) => StageKind::Flow(stage.read(table)?),
            StageKind::Consolidate(stage) => StageKind::Consolidate(stage.read(table)?),
            StageKind::Run(stage) => StageKind::Run(stage.read_with(table, max_velocity)?),
        })
    }
}

/// What the scene said before its stages.
pub(super) struct Before<'a> {
    pub walls: &'a Walls,
    pub has_fluid: bool,
}

impl Stage {
    /// A stage with the mechanics of `[dem]`.
    ///
    /// ```
    /// use dempfv::scene::{Compact, Stage, StageKind};
    /// let kind = StageKind::Compact(Compact { stress: 2e4, ..Compact::default() });
    /// assert_eq!(Stage::new("compact", kind).damping, None);
    /// ```
    pub fn new(name: impl Into<String>, kind: StageKind) -> Stage {
        Stage { name: name.into(), kind, dt: None, damping: None }
    }

    /// The settings of `[dem]` with what this stage says otherwise.
    pub fn mechanics(&self, dem: &Dem) -> Dem {
        let mut dem = *dem;
        dem.dt = self.dt.unwrap_or(dem.dt);
        dem.options.damping = self.damping.unwrap_or(dem.options.damping);
        dem
    }

    /// Reads a stage; `earlier` are those before it.
    pub(super) fn read(value: &Value, earlier: &[Stage], before: &Before) -> Result<Stage> {
        let kind = read_kind(value)?;
        let table = value.table(kind.schema())?;
        let kind = kind.read(&table, before)?;
        let mut stage = Stage::new(read_name(&table, &kind, earlier)?, kind);
        if stage.kind.moves() {
            stage.keys(&mut Keys::Read(&table))?;
        }
        Ok(stage)
    }

    /// The keys that all stages have that move spheres.
    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.take("dt", &Maybe(Steps), &mut self.dt)?;
        keys.take("damping", &Maybe(DAMPING), &mut self.damping)
    }

    /// Checks every value.
    pub(super) fn check(&self) -> Result<()> {
        self.kind.check()?;
        let mut keys = Keys::Check(self.kind.schema());
        self.clone().keys(&mut keys)?;
        let unused = [("dt", self.dt.is_some()), ("damping", self.damping.is_some())];
        match unused.into_iter().find(|(_, given)| *given && !self.kind.moves()) {
            Some((key, _)) => {
                let wrong = Wrong::new("is given, but nothing moves there", "leave it out");
                keys.rule(key, Some(wrong))
            }
            None => Ok(()),
        }
    }

    /// Each key with its value as a scene has it.
    pub(super) fn write(&self) -> Vec<(&'static str, String)> {
        let kind = [("kind", quoted(self.kind.name())), ("name", quoted(&self.name))];
        let own = [
            ("dt", Maybe(Steps).write(&self.dt)),
            ("damping", Maybe(DAMPING).write(&self.damping)),
        ];
        let own = own.into_iter().filter_map(|(key, text)| Some((key, text?)));
        kind.into_iter().chain(self.kind.write()).chain(own).collect()
    }

    /// What is wrong with this stage in its scene; to be read after its name.
    pub(super) fn wrong_in(
        &self,
        earlier: &[Stage],
        dem: Option<&Dem>,
        fluid: Option<&Fluid>,
    ) -> Option<Wrong> {
        let kind = &self.kind;
        if self.name.trim().is_empty() || earlier.iter().any(|s| s.name == self.name) {
            let problem = "has an empty name or the name of an earlier stage";
            return Some(Wrong::new(problem, "give every stage a name of its own"));
        }
        if kind.moves() && dem.is_none() {
            let problem = "moves spheres, but there is no [dem]";
            return Some(Wrong::new(problem, "add [dem] (it may be empty)"));
        }
        let needs_fluid = kind.has_conditions() || matches!(kind, StageKind::Permeability(_));
        let Some(fluid) = fluid else {
            let problem = "needs a fluid, but there is no [fluid]";
            let remedy = "add [fluid] with `viscosity` in Pa·s";
            return needs_fluid.then(|| Wrong::new(problem, remedy)).or_else(|| self.wrong());
        };
        match kind {
            StageKind::Consolidate(stage) => {
                stage.wrong_after(&measured(Axis::of(stage.wall), earlier), fluid)
            }
            StageKind::Flow(stage) => stage.wrong_with(fluid.effects.store()),
            _ => self.wrong(),
        }
    }

    /// What is wrong with this stage between walls, or in a periodic cell.
    pub(super) fn wrong_around(&self, is_cell: bool) -> Option<Wrong> {
        let in_cell = |problem: &str, remedy: &str| Some(Wrong::new(problem, remedy));
        match &self.kind {
            StageKind::Run(run) if is_cell && run.moves_walls() => in_cell(
                "moves walls, but [cell] leaves none",
                "move the cell, by `velocity_gradient` or `cell_stress`",
            ),
            StageKind::Run(run) if !is_cell && run.moves_cell() => in_cell(
                "moves a periodic cell, but there is none",
                "add [cell] with its `size`, or move `walls`",
            ),
            StageKind::Run(_) | StageKind::Compact(_) | StageKind::Permeability(_) => None,
            _ if !is_cell => None,
            _ => in_cell("needs walls, but [cell] leaves none", "give [box] in its place"),
        }
    }

    /// What is wrong with the stresses asked for in a periodic cell of spheres of this modulus
    /// (Pa), which something holds together or not.
    pub(super) fn cell_stress_wrong(&self, young: f64, pulls: bool) -> Option<Wrong> {
        let StageKind::Run(run) = &self.kind else { return None };
        cell_controls::beyond_reach(&run.cell, young, pulls)
    }

    /// What is wrong with this stage where an incompressible fluid fills a periodic cell.
    pub(super) fn volume_wrong(&self) -> Option<Wrong> {
        let StageKind::Run(run) = &self.kind else { return None };
        cell_controls::changes_volume(&run.cell).filter(|_| run.fluid)
    }

    /// What is wrong with this stage alone.
    fn wrong(&self) -> Option<Wrong> {
        match &self.kind {
            StageKind::Run(run) => run.wrong(),
            _ => None,
        }
    }
}

/// What stages measure along an axis.
fn measured(axis: Axis, stages: &[Stage]) -> consolidate::Measured {
    let any = |holds: &dyn Fn(&StageKind) -> bool| stages.iter().any(|s| holds(&s.kind));
    consolidate::Measured {
        modulus: any(&|k| matches!(k, StageKind::Cycle(c) if Axis::of(c.wall) == axis)),
        permeability: any(&|k| matches!(k, StageKind::Permeability(p) if p.axis == axis)),
    }
}

/// Effects of the stages.
pub(super) fn effects(stages: &[Stage]) -> [(&'static Effect, bool); 4] {
    let any = |holds: fn(&StageKind) -> bool| stages.iter().any(|s| holds(&s.kind));
    [
        (&GROWTH, any(|k| matches!(k, StageKind::Compact(_)))),
        (&MOVING_WALLS, any(StageKind::has_moving_wall)),
        (&SERVO_WALLS, any(StageKind::has_servo)),
        (&CELL_STRESS, any(StageKind::has_cell_stress)),
    ]
}

/// The kind of a stage, with its defaults.
fn read_kind(stage: &Value) -> Result<StageKind> {
    let kinds = [
        StageKind::Compact(Compact::default()),
        StageKind::Cycle(Cycle::default()),
        StageKind::Permeability(Permeability::default()),
        StageKind::Flow(FlowOnly::default()),
        StageKind::Consolidate(Consolidate::default()),
        StageKind::Run(Run::default()),
    ];
    let names: Vec<_> = kinds.iter().map(|k| (k.name(), k)).collect();
    let Some(kind) = stage.peek("kind") else {
        let known: Vec<_> = names.iter().map(|(name, _)| *name).collect();
        return Err(stage.source.error(
            stage.at,
            "a [[stage]] has no `kind`",
            format!("add `kind = \"...\"`, one of {}", known.join(", ")),
        ));
    };
    kind.choice(&names).cloned()
}

fn read_name(table: &Table, kind: &StageKind, earlier: &[Stage]) -> Result<String> {
    let taken = |name: &str| earlier.iter().any(|s| s.name == name);
    let Some(value) = table.get("name") else {
        let kind = kind.name();
        let mut name = kind.to_owned();
        let mut number = 1;
        while taken(&name) {
            number += 1;
            name = format!("{kind} {number}");
        }
        return Ok(name);
    };
    let name = value.text("the stage's name")?;
    if name.trim().is_empty() || taken(name) {
        return Err(value.error(
            &format!("is \"{}\", which is empty or the name of an earlier stage", excerpt(name)),
            "give every stage a name of its own, or none",
        ));
    }
    Ok(name.to_owned())
}
