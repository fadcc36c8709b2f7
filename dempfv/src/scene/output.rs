//! `[output]`: what is written, and how often.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Array, Count, Flag, Vector};
use super::schema::Schema;
use super::wrong::Wrong;
use crate::domain::{Aabb, Vec3};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[output]",
    &["history_every", "vtk_every", "checkpoint_every", "pictures", "energy", "probes"],
);

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Steps between rows of the history. Default 10.
    pub history_every: u64,
    /// Steps between VTK snapshots; 0: none. Default 0.
    pub vtk_every: u64,
    /// Steps between checkpoints; 0: none. Default 0.
    pub checkpoint_every: u64,
    /// Are pictures drawn at the end? Default true.
    pub pictures: bool,
    /// Is energy tracked by cause? Default true.
    pub energy: bool,
    /// Points whose pore pressure is in the history (m). Default: none.
    pub probes: Vec<Vec3>,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            history_every: 10,
            vtk_every: 0,
            checkpoint_every: 0,
            pictures: true,
            energy: true,
            probes: vec![],
        }
    }
}

impl Keyed for Output {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        const POINTS: Array<Vector> =
            Array { items: Vector("m"), form: "an array of points in m, as in [[0.5, 0.1, 0.5]]" };
        keys.take("history_every", &Count(1), &mut self.history_every)?;
        keys.take("vtk_every", &Count(0), &mut self.vtk_every)?;
        keys.take("checkpoint_every", &Count(0), &mut self.checkpoint_every)?;
        keys.take("pictures", &Flag, &mut self.pictures)?;
        keys.take("energy", &Flag, &mut self.energy)?;
        keys.take("probes", &POINTS, &mut self.probes)
    }
}

impl Output {
    /// Probes lie inside the box, as far as the scene says where that is, and in a fluid.
    pub(super) fn rules(&self, keys: &Keys, bounds: Option<&Aabb>, has_fluid: bool) -> Result<()> {
        let dry = !self.probes.is_empty() && !has_fluid;
        let no_fluid =
            || Wrong::new("asks for pore pressures, but there is no [fluid]", "add [fluid]");
        keys.rule("probes", dry.then(no_fluid))?;
        match bounds.and_then(|bounds| self.probe_outside(bounds)) {
            Some((i, problem)) => {
                let wrong = Wrong::new(problem, "give points inside the box");
                keys.rule_of_item("probes", i, Some(wrong))
            }
            None => Ok(()),
        }
    }

    /// The first probe that lies outside a box, and what is wrong with it. Probes are numbered
    /// from 1, as their columns in the history are.
    pub(super) fn probe_outside(&self, bounds: &Aabb) -> Option<(usize, String)> {
        let (i, x) = self.probes.iter().enumerate().find(|(_, x)| !bounds.contains(x))?;
        let Aabb { min, max } = bounds;
        let problem = format!(
            "has probe {} at [{}, {}, {}], outside the box from [{}, {}, {}] to [{}, {}, {}]",
            i + 1,
            x.x,
            x.y,
            x.z,
            min.x,
            min.y,
            min.z,
            max.x,
            max.y,
            max.z
        );
        Some((i, problem))
    }
}
