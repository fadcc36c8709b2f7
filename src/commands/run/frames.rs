//! Snapshots for ParaView.

use std::path::Path;

use dempfv::dem::{Contact, Partner, PeriodicCell};
use dempfv::io::vtk::{self, Collection, LineData, SphereFrame};
use dempfv::simulation::Simulation;
use dempfv::{Cell, Result, Vec3};
use dempfv_report::outputs::frames as names;

/// Snapshots, and the collections that give each its time.
pub struct Frames {
    spheres: Collection,
    pores: Collection,
    cell: Collection,
    contacts: Option<Collection>,
    /// Step of the last snapshot.
    last: Option<u64>,
}

impl Frames {
    /// Starts the collections, or goes on with those of the run that `from` (step and time)
    /// restarts.
    pub fn new(folder: &Path, contacts: bool, from: Option<(u64, f64)>) -> Result<Frames> {
        let open = |name: &str| {
            let path = folder.join(name);
            match from {
                Some((_, time)) => Collection::resume(&path, time),
                None => Ok(Collection::new(&path)),
            }
        };
        Ok(Frames {
            spheres: open("spheres.pvd")?,
            pores: open("pores.pvd")?,
            cell: open("cell.pvd")?,
            contacts: contacts.then(|| open("contacts.pvd")).transpose()?,
            last: None,
        })
    }

    /// Writes a snapshot, unless there is one of this step.
    pub fn write(&mut self, folder: &Path, simulation: &Simulation) -> Result<()> {
        let (step, time) = (simulation.step(), simulation.time());
        if self.last == Some(step) {
            return Ok(());
        }
        let dem = simulation.coupled().dem();
        if let Some(cell) = dem.cell() {
            let name = format!("cell-{step:09}.vtu");
            write_cell(&folder.join(&name), cell.cell())?;
            self.cell.push(time, &name)?;
        }
        let name = format!("spheres-{step:09}.vtu");
        write_spheres(&folder.join(&name), simulation)?;
        self.spheres.push(time, &name)?;
        if let Some(collection) = &mut self.contacts {
            let name = format!("contacts-{step:09}.vtu");
            write_contacts(&folder.join(&name), simulation)?;
            collection.push(time, &name)?;
        }
        let name = format!("pores-{step:09}.vtu");
        if write_pores(&folder.join(&name), simulation)? {
            self.pores.push(time, &name)?;
        }
        self.last = Some(step);
        Ok(())
    }
}

fn write_spheres(path: &Path, simulation: &Simulation) -> Result<()> {
    let coupled = simulation.coupled();
    let dem = coupled.dem();
    let particles = dem.storage();
    let mut force = dem.storage_forces().to_vec();
    if let Some(fluid) = coupled.storage_fluid_force() {
        force.iter_mut().zip(fluid).for_each(|(sum, fluid)| *sum += fluid);
    }
    // Those copies that are in the cell, where there is one.
    let inside = dem.cell().map(|cell| {
        particles.position.iter().map(|x| cell.cell().wrap(x).0).collect::<Vec<Vec3>>()
    });
    let frame = SphereFrame {
        position: inside.as_deref().unwrap_or(&particles.position),
        radius: &particles.radius,
        velocity: &particles.velocity,
        force: &force,
        id: &particles.id,
    };
    Ok(vtk::write_spheres(path, &frame)?)
}

/// Whether there are pores to write.
fn write_pores(path: &Path, simulation: &Simulation) -> Result<bool> {
    let coupled = simulation.coupled();
    let Some(flow) = coupled.storage_flow() else { return Ok(false) };
    let (network, position) = (flow.network(), &coupled.dem().storage().position);
    let bounds = coupled.dem().box_();
    let ((points, cells), volume) = match coupled.dem().cell().map(PeriodicCell::cell) {
        None => {
            let volume = network.volumes_at(position, &bounds)?;
            (vtk::pore_cells(network, position, &bounds)?, volume)
        }
        Some(cell) => {
            let volume = network.volumes_in_cell(position, cell)?;
            (vtk::pore_cells_in_cell(network, position, cell)?, volume)
        }
    };
    let mut data = vec![(names::PRESSURE, flow.pressure()), (names::VOLUME, &volume)];
    let total = coupled.fluid_has_weight().then(|| coupled.total_pressures()).flatten();
    data.extend(total.as_deref().map(|total| (names::TOTAL_PRESSURE, total)));
    vtk::write_cells(path, &points, &cells, &data)?;
    Ok(true)
}

/// Contacts as lines: from centre to centre, or to a wall.
fn write_contacts(path: &Path, simulation: &Simulation) -> Result<()> {
    let dem = simulation.coupled().dem();
    let contacts: Vec<Contact> = dem.contacts().collect();
    let from = |contact: &Contact| match dem.cell() {
        Some(cell) => cell.cell().wrap(&dem.position(contact.i as usize)).0,
        None => dem.position(contact.i as usize),
    };
    let ends: Vec<[Vec3; 2]> = contacts
        .iter()
        .map(|c| (from(c), c))
        .map(|(x, c)| [x, x + c.distance * c.normal])
        .collect();
    let of = |value: fn(&Contact) -> f64| contacts.iter().map(value).collect::<Vec<f64>>();
    let normal = of(|c| c.normal_force);
    let (shear, overlap) = (of(|c| c.shear.norm()), of(|c| c.overlap));
    let wall = of(|c| f64::from(u8::from(matches!(c.partner, Partner::Wall(_)))));
    let force: Vec<Vec3> = contacts.iter().map(Contact::force).collect();
    let data = LineData {
        scalars: &[
            (names::NORMAL_FORCE, &normal),
            (names::SHEAR_FORCE, &shear),
            (names::OVERLAP, &overlap),
            (names::WALL_CONTACT, &wall),
        ],
        vectors: &[(names::CONTACT_FORCE, &force)],
    };
    Ok(vtk::write_lines(path, &ends, &data)?)
}

/// The periodic cell as a hexahedron.
fn write_cell(path: &Path, cell: &Cell) -> Result<()> {
    let [a, b, c] = cell.edges();
    let base = [Vec3::zeros(), a, a + b, b];
    let points: Vec<Vec3> = base.into_iter().chain(base.map(|x| x + c)).collect();
    let mut cells = vtk::Cells::default();
    cells.push_hexahedron([0, 1, 2, 3, 4, 5, 6, 7]);
    let angles = cell.angles().map(f64::to_degrees);
    let data = [(names::CELL_VOLUME, &[cell.volume()][..]), (names::GAMMA, &[angles[2]][..])];
    Ok(vtk::write_cells(path, &points, &cells, &data)?)
}
