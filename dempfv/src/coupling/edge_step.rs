//! The forces between neighbours in a step.

use super::active_network::ActiveNetwork;
use super::coupled::Coupled;
use super::phases::Phase;
use crate::Vec3;

impl Coupled {
    /// Computes what the edges of the network put on spheres and walls, once contacts and pressures of
    /// the step are there.
    pub(super) fn act_on_edges(&mut self, dt: f64) {
        let Coupled { dem, remesher, phases, .. } = self;
        let Some(ActiveNetwork { flow, edges: Some(edges), .. }) = &mut remesher.current else {
            return;
        };
        phases.time(Phase::FluidForces, || edges.act(dem, flow.force(), dt));
    }

    /// Books what they took, once the spheres have moved.
    pub(super) fn book_edges(&mut self, dt: f64) {
        let Coupled { dem, remesher, phases, .. } = self;
        let network = remesher.current.as_mut();
        if let Some(edges) = network.and_then(|network| network.edges.as_mut()) {
            phases.time(Phase::FluidForces, || edges.book(dem, dt));
        }
    }

    /// The fluid's torque on each sphere in the last step (N m), by the user's numbers: that of forces
    /// between neighbours.
    pub fn fluid_torque(&self) -> Vec<Vec3> {
        let edges = self.remesher.current.as_ref().and_then(|network| network.edges.as_ref());
        match edges.and_then(|edges| edges.torque()) {
            Some(torque) => self.dem.numbered(torque),
            None => vec![Vec3::zeros(); self.dem.len()],
        }
    }

    /// The fluid's force on each sphere in the last step (N), that of pressures and that between
    /// neighbours, in storage order; `None` where the pores are empty.
    pub fn storage_fluid_force(&self) -> Option<&[Vec3]> {
        self.remesher.current.as_ref().map(ActiveNetwork::force)
    }
}
