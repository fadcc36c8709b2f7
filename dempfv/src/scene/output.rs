//! `[output]`: what is written, and how often.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Array, Count, Flag, Maybe, Vector};
use super::schema::Schema;
use super::watched::{Plane, Region, SectionPlane};
use super::wrong::Wrong;
use crate::domain::{Aabb, Vec3};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[output]",
    &[
        "history_every",
        "vtk_every",
        "checkpoint_every",
        "pictures",
        "energy",
        "energy_turning",
        "state",
        "contacts",
        "probes",
        "regions",
        "section",
    ],
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
    /// Is what steps lose in which contacts turn a cause of its own? Default false: it is in the
    /// residual.
    pub energy_turning: bool,
    /// Has the history strains, effective stress and fabric? Default false.
    pub state: bool,
    /// Are the contacts written, with every VTK snapshot and at the end? Default false.
    pub contacts: bool,
    /// Points whose pore pressure is in the history (m). Default: none.
    pub probes: Vec<Vec3>,
    /// Boxes whose porosity and mean pore pressure are in the history (m). Default: none.
    pub regions: Vec<Aabb>,
    /// The plane of pictures of pore pressures. Default: normal to z, through the middle of the box.
    pub section: Option<SectionPlane>,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            history_every: 10,
            vtk_every: 0,
            checkpoint_every: 0,
            pictures: true,
            energy: true,
            energy_turning: false,
            state: false,
            contacts: false,
            probes: vec![],
            regions: vec![],
            section: None,
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
        keys.take("energy_turning", &Flag, &mut self.energy_turning)?;
        keys.take("state", &Flag, &mut self.state)?;
        keys.take("contacts", &Flag, &mut self.contacts)?;
        keys.take("probes", &POINTS, &mut self.probes)?;
        const BOXES: Array<Region> = Array {
            items: Region,
            form: "an array of boxes in m, as in [{ min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }]",
        };
        keys.take("regions", &BOXES, &mut self.regions)?;
        keys.take("section", &Maybe(Plane), &mut self.section)
    }
}

impl Output {
    /// Probes lie inside the box, as far as the scene says where that is, and in a fluid; what
    /// else is asked for is there.
    pub(super) fn rules(&self, keys: &Keys, bounds: Option<&Aabb>, has_fluid: bool) -> Result<()> {
        let dry_section = self.section.is_some() && !has_fluid;
        let no_pressures =
            || Wrong::new("cuts pore pressures, but there is no [fluid]", "leave it out");
        keys.rule("section", dry_section.then(no_pressures))?;
        let missed = bounds.and_then(|bounds| self.section_outside(bounds));
        keys.rule("section", missed)?;
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

    /// What is wrong with a plane that does not cut a box.
    fn section_outside(&self, bounds: &Aabb) -> Option<Wrong> {
        let SectionPlane { axis, position } = self.section?;
        let (from, to) = (bounds.min[axis.index()], bounds.max[axis.index()]);
        let axis = axis.name();
        (!(from..=to).contains(&position)).then(|| {
            Wrong::new(
                format!("is at {axis} = {position} m, but the box goes from {from} to {to}"),
                "give a plane that cuts the box",
            )
        })
    }

    /// What is wrong with results of a periodic cell, and of spheres that do not move.
    pub(super) fn wrong_in(&self, is_cell: bool, moves: bool) -> Option<Wrong> {
        if is_cell && !self.regions.is_empty() {
            let problem = "has `regions`, which lie nowhere in a periodic cell";
            return Some(Wrong::new(problem, "leave them out, or give [box] in place of [cell]"));
        }
        let useless = [("state", self.state), ("contacts", self.contacts)];
        let (key, _) = useless.into_iter().find(|(_, asked)| *asked && !moves)?;
        let problem = format!("has `{key}`, but without [dem] nothing touches");
        Some(Wrong::new(problem, "add [dem], or leave it out"))
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
