//! What can be seen of a simulation between two steps.

use super::active_network::ActiveNetwork;
use super::coupled::Coupled;
use crate::pfv::Flow;
use crate::{Axis, Tensor, Vec3, WallId};

/// Scalars of the current state, for histories and progress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Edge lengths of the box (m), or of the box around a periodic cell.
    pub size: [f64; 3],
    /// What a periodic cell has come to; `None` between walls.
    pub cell: Option<CellObservation>,
    /// Stress on each wall by contacts (Pa).
    pub contact_stress: [f64; 6],
    /// Stress on each wall by the fluid (Pa); 0 where the pores are empty.
    pub fluid_stress: [f64; 6],
    /// Displacement of each wall along its axis (m).
    pub wall_displacement: [f64; 6],
    /// Porosity of the box or the cell, overlaps counted twice (1).
    pub porosity: f64,
    /// Mean resultant force over mean contact force (1).
    pub unbalanced_force: f64,
    /// Live contacts, walls included.
    pub contacts: usize,
    /// Contacts per sphere (1).
    pub coordination_number: f64,
    /// Kinetic energy (J).
    pub kinetic_energy: f64,
    /// Elastic energy of the contacts (J).
    pub elastic_energy: f64,
    /// Largest pore pressure (Pa); 0 where the pores are empty.
    pub largest_pressure: f64,
    /// Mean pore pressure by volume (Pa).
    pub mean_pressure: f64,
    /// Flux through each wall, positive into the box (m³/s).
    pub flux: [f64; 6],
}

/// A periodic cell at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellObservation {
    /// Lengths of its edges (m), and the angles between the second and the third, the third and
    /// the first, the first and the second (rad).
    pub lengths: [f64; 3],
    /// See above.
    pub angles: [f64; 3],
    /// ∫ L dt since the cell was made (1), positive in extension.
    pub strain: Tensor,
    /// Stress by contacts and motion (Pa, positive in compression); that of the fluid is beside it.
    pub stress: Tensor,
    /// Mean velocity of the fluid over the whole area, relative to the spheres at rest (m/s); zero
    /// where the pores are empty.
    pub fluid_velocity: Vec3,
}

impl Coupled {
    /// Looks at the periodic cell, if there is one.
    pub fn observe_cell(&self) -> Option<CellObservation> {
        let cell = self.dem.cell()?;
        Some(CellObservation {
            lengths: cell.cell().lengths(),
            angles: cell.cell().angles(),
            strain: *cell.strain(),
            stress: self.cell_stress()?,
            fluid_velocity: self.storage_flow().and_then(Flow::mean_velocity).unwrap_or_default(),
        })
    }

    /// Stress by contacts and motion in a periodic cell (Pa); `None` between walls.
    pub(crate) fn cell_stress(&self) -> Option<Tensor> {
        self.dem.cell().map(|_| self.dem.stress_in_cell() + self.dem.kinetic_stress())
    }

    /// Normal stress along an axis (Pa): of its two walls, contacts and fluid together, or of the
    /// periodic cell.
    pub fn axis_stress(&self, axis: Axis) -> f64 {
        let k = axis.index();
        match self.cell_stress() {
            Some(stress) => stress[(k, k)],
            None => {
                let [lower, upper] = [2 * k, 2 * k + 1].map(|w| WallId::ALL[w]);
                0.5 * (self.wall_stress(lower) + self.wall_stress(upper))
            }
        }
    }

    /// Looks at the current state.
    pub fn observe(&self) -> Observation {
        let dem = &self.dem;
        let bounds = dem.box_();
        let flow = self.storage_flow();
        let network = self.remesher.current.as_ref();
        let fluid_force = network.map(ActiveNetwork::wall_force).unwrap_or_default();
        let stress = |force: Vec3, w: WallId| -force.dot(&w.inward_normal()) / bounds.wall_area(w);
        let contact_force = dem.wall_force();
        let largest_pressure =
            flow.map_or(0.0, |f| f.pressure().iter().copied().fold(f64::NEG_INFINITY, f64::max));
        Observation {
            size: bounds.size().into(),
            cell: self.observe_cell(),
            contact_stress: WallId::ALL.map(|w| stress(contact_force[w], w)),
            fluid_stress: WallId::ALL.map(|w| stress(fluid_force[w.index()], w)),
            wall_displacement: dem.walls().map(|w| w.displacement).0,
            porosity: dem.porosity(),
            unbalanced_force: self.unbalanced_force(),
            contacts: dem.sphere_contact_count() + dem.wall_contact_count(),
            coordination_number: dem.coordination_number(),
            kinetic_energy: dem.kinetic_energy(),
            elastic_energy: dem.elastic_energy(),
            largest_pressure,
            mean_pressure: self.mean_pressure(),
            flux: flow.map(|f| f.flux()).unwrap_or_default(),
        }
    }

    /// Mean resultant force on the spheres, the fluid's included, over the
    /// mean contact force (1).
    pub fn unbalanced_force(&self) -> f64 {
        self.dem.force_ratio(self.storage_fluid_force())
    }

    /// Mean pore pressure by volume (Pa); 0 where the pores are empty.
    pub fn mean_pressure(&self) -> f64 {
        self.storage_flow().map_or(0.0, |f| {
            let volume: f64 = f.network().volume.iter().sum();
            let weighted: f64 =
                f.pressure().iter().zip(&f.network().volume).map(|(p, v)| p * v).sum();
            weighted / volume
        })
    }

    /// Stress on a wall by contacts and fluid together (Pa, compression positive).
    pub fn wall_stress(&self, wall: WallId) -> f64 {
        let network = self.remesher.current.as_ref();
        let fluid = network.map_or(Vec3::zeros(), |network| network.wall_force()[wall.index()]);
        let force = self.dem.wall_force()[wall] + fluid;
        -force.dot(&wall.inward_normal()) / self.dem.box_().wall_area(wall)
    }

    /// The fluid's force on each sphere in the last step (N), by the user's
    /// numbers; zero where the pores are empty.
    pub fn fluid_force(&self) -> Vec<Vec3> {
        match self.storage_fluid_force() {
            Some(force) => self.dem.numbered(force),
            None => vec![Vec3::zeros(); self.dem.len()],
        }
    }

    /// Mean pressure of the pores around each sphere, weighted by their volumes (Pa),
    /// by the user's numbers; 0 for a sphere that is a vertex of no pore.
    pub fn pressure_at_spheres(&self) -> Vec<f64> {
        let spheres = self.dem.storage().len();
        match self.storage_flow() {
            Some(flow) => self.dem.numbered(&flow.pressure_at_spheres(spheres)),
            None => vec![0.0; spheres],
        }
    }

    /// Pressure of the pore that contained each watched point when the network was built
    /// (Pa). NaN where there is no network, and for a point that was outside its box.
    pub fn probe_pressures(&self) -> impl Iterator<Item = f64> + '_ {
        let network = self.remesher.current.as_ref();
        (0..self.probes.len())
            .map(move |k| network.map_or(f64::NAN, |network| network.probe_pressure(k)))
    }
}
