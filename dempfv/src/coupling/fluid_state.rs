//! What must be kept of a network to build it again and go on with the same
//! bits.

use serde::{Deserialize, Serialize};

use super::edges::EdgeState;
use super::viscous_bound::FastestMode;
use crate::dem::Dem;
use crate::pfv::{self, Extrapolation, Flow};
use crate::{Aabb, Cell, PerWall, Vec3};

/// The positions that a network is built from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Snapshot {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// The box (m).
    pub bounds: Aabb,
    /// The periodic cell in its place.
    pub cell: Option<Cell>,
    /// Steps done before.
    pub step: u64,
    /// Length of the steps that its matrix is for (s); of no account where no pore stores fluid.
    pub time_step: f64,
}

impl Snapshot {
    pub fn of(dem: &Dem, step: u64, time_step: f64) -> Snapshot {
        let (position, bounds) = (dem.storage().position.clone(), dem.box_());
        let cell = dem.cell().map(|cell| *cell.cell());
        Snapshot { position, bounds, cell, step, time_step }
    }
}

/// A network as its last step left it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct FluidState {
    /// What the network in use was built from.
    pub snapshot: Snapshot,
    /// Where its spheres and walls were in the last step, if it follows them.
    pub followed: Option<Followed>,
    /// Where they were when the growth of its pores was last taken; `None` where no pore stores
    /// fluid.
    pub grown_to: Option<Place>,
    /// Steps since it came into use, or since a remesh failed.
    pub since: u64,
    /// Change of each pore's volume since the snapshot (m³); empty without the
    /// strain rule.
    pub volume_change: Vec<f64>,
    /// Rate at which each pore grew in the last step (m³/s).
    pub volume_rate: Vec<f64>,
    /// What each pore took up in the last step (m³/s); empty where it only grew.
    pub taken: Vec<f64>,
    /// Length of the last step (s), where pores store fluid.
    pub time_step: Option<f64>,
    /// The fluid's resistance to each wall that a servo held (N·s/m), once it
    /// is known for this network ([`Flow::wall_resistance`](crate::pfv::Flow::wall_resistance)).
    pub resistance: PerWall<Option<PerWall<f64>>>,
    /// Share of the fluid's force on each such wall that outlives a step at rest
    /// ([`Flow::wall_persistence`](crate::pfv::Flow::wall_persistence)).
    pub persistence: PerWall<f64>,
    /// The fluid's force on each wall in the step before the last (N).
    pub wall_force_before: Option<[Vec3; 6]>,
    /// The network cannot follow the spheres any further.
    pub exhausted: bool,
    /// The pressures that the next solve goes on from.
    pub extrapolation: Extrapolation,
    /// The solver that computed them.
    pub solved_by: Option<String>,
    /// What the next network is being built from.
    pub pending: Option<Snapshot>,
    /// The forces between neighbours, where there are any.
    pub edges: Option<EdgeState>,
    /// What bounds the automatic time step, as far as it is known.
    pub fastest: FastestMode,
}

impl FluidState {
    /// Notes what the pores have grown by in a step (s), where the strain rule asks.
    pub fn book_volumes(&mut self, flow: &Flow, dt: f64) {
        for (change, rate) in self.volume_change.iter_mut().zip(flow.volume_rate()) {
            *change += rate * dt;
        }
    }
}

/// Spheres and what is around them, at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Place {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// The box (m), or that around the cell.
    pub bounds: Aabb,
    /// The periodic cell in the place of walls.
    pub cell: Option<Cell>,
}

impl Place {
    pub fn of(dem: &Dem) -> Place {
        let (position, bounds) = (dem.storage().position.clone(), dem.box_());
        Place { position, bounds, cell: dem.cell().map(|cell| *cell.cell()) }
    }

    /// Moves it.
    pub fn set(&mut self, to: &pfv::Place) {
        self.position.clear();
        self.position.extend_from_slice(to.position);
        self.bounds = *to.bounds;
        self.cell = to.cell.copied();
    }

    pub fn view(&self) -> pfv::Place<'_> {
        let Place { position, bounds, cell } = self;
        pfv::Place { position, bounds, cell: cell.as_ref() }
    }
}

/// Where a network has followed its spheres to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Followed {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// The box (m).
    pub bounds: Aabb,
}
