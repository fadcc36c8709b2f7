//! How fast pores that store fluid grow: by their volumes, not by what is linear in the motion.
//!
//! Rates by the gradients of a network (`E v`) add up to what the volumes change by in the first order
//! of the strain since it was built. An incompressible fluid forgets the rest in the next step; what
//! pores store would keep it: a box that strains by a would lose or win a² of its volume.

use super::frame::Frame;
use super::packing_check::require_length;
use super::{Network, PfvError};
use crate::parallel::for_each;
use crate::{Aabb, Cell, Vec3};

/// Where spheres are, and what is around them.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    /// Sphere centres (m).
    pub position: &'a [Vec3],
    /// The box (m), or that around the cell.
    pub bounds: &'a Aabb,
    /// The periodic cell in the place of walls.
    pub cell: Option<&'a Cell>,
}

/// The pores' volumes as far as their growth was taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Grown {
    /// Of each pore (m³).
    volume: Vec<f64>,
    /// Those of the moment: kept for its memory.
    now: Vec<f64>,
    /// Sphere centres from the box's lower corner (m): kept for its memory.
    local: Vec<Vec3>,
    /// The volumes are not those up to which growth was taken: rates took its place.
    forgotten: bool,
}

impl Grown {
    /// Evaluates the volumes of the moment. Says whether it could: a periodic cell may have changed too
    /// much since the network was built.
    pub fn measure(
        &mut self,
        network: &Network,
        radius: &[f64],
        place: Place,
    ) -> Result<bool, PfvError> {
        let Place { position, bounds, cell } = place;
        require_length("position", position.len(), radius.len(), "spheres")?;
        let Grown { now, local, .. } = self;
        now.resize(network.pores(), 0.0);
        if let Some(cell) = cell {
            return Ok(network.write_volumes_in_cell(position, cell, now));
        }
        let mut x = std::mem::take(local);
        x.clear();
        x.extend(position.iter().map(|x| x - bounds.min));
        let frame = Frame { x, r: radius, size: bounds.size() };
        network.write_volumes(&frame, now);
        *local = frame.x;
        Ok(true)
    }

    /// Rates take the place of growth.
    pub fn forget(&mut self) {
        self.forgotten = true;
    }

    /// Whether rates took the place of growth in the last step.
    pub fn is_forgotten(&self) -> bool {
        self.forgotten
    }

    /// The growth up to the volumes measured last is taken.
    pub fn settle(&mut self) {
        self.forgotten = false;
        std::mem::swap(&mut self.volume, &mut self.now);
    }

    /// Writes how fast pores grow (m³/s) that do so in a step (s) by what has not been taken, which is
    /// taken herewith.
    pub fn take(&mut self, time_step: f64, rate: &mut [f64]) {
        let Grown { volume, now, .. } = self;
        if volume.len() != now.len() {
            // Nobody has said where they were.
            volume.clone_from(now);
        }
        let per_second = 1.0 / time_step;
        for_each(rate, &|i, rate| *rate = (now[i] - volume[i]) * per_second);
        self.settle();
    }
}
