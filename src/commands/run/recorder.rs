//! What a run writes while it goes on: history, frames, checkpoints.

use std::path::{Path, PathBuf};

use dempfv::dem::PeriodicCell;
use dempfv::io::checkpoint;
use dempfv::io::history::History;
use dempfv::io::vtk::{self, Collection, SphereFrame};
use dempfv::simulation::Simulation;
use dempfv::{Cell, Result, Vec3, WallId};

use super::history;

/// Writes what the scene asks for, when it asks for it.
pub struct Recorder {
    folder: PathBuf,
    history: History,
    history_every: u64,
    checkpoint_every: u64,
    frames: Option<Frames>,
    /// Step that was looked at last: a stage without steps adds none.
    last_step: Option<u64>,
    /// What is still to be written of it.
    due: Due,
    /// Step of the last row.
    last_row: Option<u64>,
    /// Walls that a servo holds at some time.
    servos: Vec<WallId>,
}

/// What is to be written of a step.
#[derive(Clone, Copy, Default)]
struct Due {
    row: bool,
    frames: bool,
    checkpoint: bool,
}

/// Frames for ParaView.
struct Frames {
    every: u64,
    spheres: Collection,
    pores: Collection,
    cell: Collection,
}

impl Recorder {
    /// Starts the files, or goes on with those of the run that `from` (step
    /// and time) restarts.
    pub fn new(
        folder: &Path,
        simulation: &Simulation,
        from: Option<(u64, f64)>,
    ) -> Result<Recorder> {
        let plan = simulation.plan();
        let output = &plan.output;
        let servos = history::servo_walls(plan);
        let columns = history::columns(plan, &servos);
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let path = folder.join("history.csv");
        let history = match from {
            Some((step, _)) => History::resume(&path, &columns, "step", step)?,
            None => History::create(&path, &columns)?,
        };
        let frames = (output.vtk_every > 0)
            .then(|| Frames::new(folder, output.vtk_every, from))
            .transpose()?;
        Ok(Recorder {
            folder: folder.to_owned(),
            last_row: history.last_step(),
            history,
            history_every: output.history_every,
            checkpoint_every: output.checkpoint_every,
            frames,
            last_step: from.map(|(step, _)| step),
            due: Due::default(),
            servos,
        })
    }

    /// Writes the row and the frames that are due after a step. Called again after a failure, it
    /// goes on where it stopped.
    pub fn after_step(&mut self, simulation: &mut Simulation) -> Result<()> {
        let step = simulation.step();
        if self.last_step != Some(step) {
            self.last_step = Some(step);
            let due = |every: u64| every > 0 && step.is_multiple_of(every);
            self.due = Due {
                row: due(self.history_every),
                frames: self.frames.as_ref().is_some_and(|f| due(f.every)),
                checkpoint: due(self.checkpoint_every),
            };
        }
        if std::mem::take(&mut self.due.row) {
            self.write_row(simulation)?;
        }
        if let Some(frames) = self.frames.as_mut().filter(|_| self.due.frames) {
            frames.write(&self.folder, simulation)?;
            self.due.frames = false;
        }
        Ok(())
    }

    /// Writes the checkpoint that is due after a step, once all else of the step is written: a
    /// restart from it finds what was before it.
    pub fn checkpoint(&mut self, simulation: &Simulation) -> Result<()> {
        if self.due.checkpoint {
            self.history.flush()?;
            checkpoint::save(&self.folder.join(super::CHECKPOINT), &simulation.state())?;
            self.due.checkpoint = false;
        }
        Ok(())
    }

    fn write_row(&mut self, simulation: &mut Simulation) -> Result<()> {
        let mut values = Vec::new();
        history::row(simulation, &self.servos, &mut values);
        let written = self.history.row(&values);
        // A row that the disk has no room for is kept for the next time.
        self.last_row = Some(simulation.step());
        simulation.reset_stress_extremes();
        Ok(written?)
    }

    /// Hands all rows so far to the system.
    pub fn flush(&mut self) -> Result<()> {
        Ok(self.history.flush()?)
    }

    /// Hands everything to the system; a finished run ends with its last state.
    pub fn close(&mut self, simulation: &mut Simulation, finished: bool) -> Result<()> {
        let step = simulation.step();
        let written = step.is_multiple_of(self.history_every.max(1)) || self.last_row == Some(step);
        if finished && self.history_every > 0 && !written {
            self.write_row(simulation)?;
        }
        Ok(self.history.flush()?)
    }
}

impl Frames {
    fn new(folder: &Path, every: u64, from: Option<(u64, f64)>) -> Result<Frames> {
        let open = |name: &str| {
            let path = folder.join(name);
            match from {
                Some((_, time)) => Collection::resume(&path, time),
                None => Ok(Collection::new(&path)),
            }
        };
        let (spheres, pores) = (open("spheres.pvd")?, open("pores.pvd")?);
        Ok(Frames { every, spheres, pores, cell: open("cell.pvd")? })
    }

    fn write(&mut self, folder: &Path, simulation: &Simulation) -> Result<()> {
        let (step, time) = (simulation.step(), simulation.time());
        let coupled = simulation.coupled();
        let particles = coupled.dem().storage();
        let fluid = coupled.storage_fluid_force();
        let force: Vec<Vec3> = match fluid {
            Some(fluid) => {
                coupled.dem().storage_forces().iter().zip(fluid).map(|(a, b)| a + b).collect()
            }
            None => coupled.dem().storage_forces().to_vec(),
        };
        if let Some(cell) = coupled.dem().cell() {
            let name = format!("cell-{step:09}.vtu");
            write_cell(&folder.join(&name), cell.cell())?;
            self.cell.push(time, &name)?;
        }
        let name = format!("spheres-{step:09}.vtu");
        // Those copies that are in the cell, where there is one.
        let inside = coupled.dem().cell().map(|cell| {
            particles.position.iter().map(|x| cell.cell().wrap(x).0).collect::<Vec<Vec3>>()
        });
        let frame = SphereFrame {
            position: inside.as_deref().unwrap_or(&particles.position),
            radius: &particles.radius,
            velocity: &particles.velocity,
            force: &force,
            id: &particles.id,
        };
        vtk::write_spheres(&folder.join(&name), &frame)?;
        self.spheres.push(time, &name)?;
        let Some(flow) = coupled.storage_flow() else { return Ok(()) };
        let (network, position) = (flow.network(), &particles.position);
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
        let name = format!("pores-{step:09}.vtu");
        vtk::write_cells(
            &folder.join(&name),
            &points,
            &cells,
            &[("pressure", flow.pressure()), ("volume", &volume)],
        )?;
        Ok(self.pores.push(time, &name)?)
    }
}

/// The periodic cell as a hexahedron.
fn write_cell(path: &Path, cell: &Cell) -> Result<()> {
    let [a, b, c] = cell.edges();
    let base = [Vec3::zeros(), a, a + b, b];
    let points: Vec<Vec3> = base.into_iter().chain(base.map(|x| x + c)).collect();
    let mut cells = vtk::Cells::default();
    cells.push_hexahedron([0, 1, 2, 3, 4, 5, 6, 7]);
    let angles = cell.angles().map(f64::to_degrees);
    let data = [("volume", &[cell.volume()][..]), ("gamma", &[angles[2]][..])];
    Ok(vtk::write_cells(path, &points, &cells, &data)?)
}
