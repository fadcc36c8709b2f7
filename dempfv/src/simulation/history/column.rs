//! A column of the history: its name, its unit, its definition and its value.

use crate::WallId;
use crate::coupling::Observation;
use crate::dem::{EnergyBalance, Fabric, WallControl};
use crate::io::history::Value;
use crate::scene::{Plan, StageKind};
use crate::simulation::run::Simulation;

/// What a row is made of: the simulation between two steps, and what was looked at once for all
/// columns.
pub struct Seen<'a> {
    pub simulation: &'a Simulation,
    pub now: Observation,
    pub energy: Option<EnergyBalance>,
    pub fabric: Option<Fabric>,
    pub servos: Vec<WallId>,
}

impl<'a> Seen<'a> {
    pub fn new(simulation: &'a Simulation) -> Seen<'a> {
        let (plan, dem) = (simulation.plan(), simulation.coupled().dem());
        Seen {
            simulation,
            now: simulation.observe(),
            energy: plan.output.energy.then(|| dem.energy_balance()).flatten(),
            fabric: plan.output.state.then(|| dem.fabric()),
            servos: servo_walls(plan),
        }
    }
}

/// A column's value; the number is that of the wall, probe or region that it is of.
pub(super) type Of = for<'a> fn(&Seen<'a>, usize) -> Value<'a>;

/// A column of the history.
pub struct Column {
    /// Its name. A word in braces stands for what the column is repeated for.
    pub name: &'static str,
    /// Its unit; `1` for a number without one, empty for a text.
    pub unit: &'static str,
    /// What it is, and when it is positive.
    pub meaning: &'static str,
    pub(super) of: Of,
}

pub(super) const fn column(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    of: Of,
) -> Column {
    Column { name, unit, meaning, of }
}

/// Columns that a history has together.
pub struct Group {
    /// When it has them.
    pub when: &'static str,
    /// They stand in this order, all of them for each label in turn.
    pub columns: &'static [Column],
    /// What stands for the label in their names, if they have one.
    pub(super) placeholder: Option<&'static str>,
    /// The labels in a scene; none where a history of it has no such columns.
    pub(super) labels: fn(&Plan) -> Vec<String>,
}

impl Group {
    /// The names of its columns in a scene's history.
    pub(super) fn names(&self, plan: &Plan) -> Vec<String> {
        let labels = (self.labels)(plan);
        let name = |column: &Column, label: &str| match self.placeholder {
            Some(placeholder) => column.name.replace(placeholder, label),
            None => column.name.to_owned(),
        };
        labels.iter().flat_map(|label| self.columns.iter().map(|c| name(c, label))).collect()
    }
}

/// The one label of columns that are not repeated.
pub(super) fn once(is_there: bool) -> Vec<String> {
    vec![String::new(); usize::from(is_there)]
}

/// Numbers from 1 on.
pub(super) fn numbered(count: usize) -> Vec<String> {
    (1..=count).map(|k| k.to_string()).collect()
}

/// The walls that a servo holds in any stage of a plan.
pub(super) fn servo_walls(plan: &Plan) -> Vec<WallId> {
    let held = |wall: WallId| {
        plan.stages.iter().any(|stage| match &stage.kind {
            StageKind::Run(run) => matches!(run.walls[wall], WallControl::Servo { .. }),
            StageKind::Consolidate(stage) => stage.wall == wall,
            StageKind::Cycle(stage) => stage.wall == wall,
            StageKind::Compact(_) | StageKind::Permeability(_) | StageKind::Flow(_) => false,
        })
    };
    WallId::ALL.into_iter().filter(|&wall| held(wall)).collect()
}
