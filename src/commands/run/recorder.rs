//! What a run writes while it goes on: history, frames, checkpoints.

use std::path::{Path, PathBuf};

use dempfv::Result;
use dempfv::io::checkpoint;
use dempfv::io::history::History;
use dempfv::simulation::{Simulation, history};

use super::end_state;
use super::frames::Frames;

/// Writes what the scene asks for, when it asks for it.
pub struct Recorder {
    folder: PathBuf,
    history: History,
    history_every: u64,
    checkpoint_every: u64,
    vtk_every: u64,
    frames: Frames,
    /// Step that was looked at last: a stage without steps adds none.
    last_step: Option<u64>,
    /// What is still to be written of it.
    due: Due,
    /// Step of the last row.
    last_row: Option<u64>,
}

/// What is to be written of a step.
#[derive(Clone, Copy, Default)]
struct Due {
    row: bool,
    frames: bool,
    checkpoint: bool,
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
        let columns = history::columns(plan);
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let path = folder.join("history.csv");
        let history = match from {
            Some((step, _)) => History::resume(&path, &columns, "step", step)?,
            None => History::create(&path, &columns)?,
        };
        Ok(Recorder {
            folder: folder.to_owned(),
            last_row: history.last_step(),
            history,
            history_every: output.history_every,
            checkpoint_every: output.checkpoint_every,
            vtk_every: output.vtk_every,
            frames: Frames::new(folder, output.contacts, from)?,
            last_step: from.map(|(step, _)| step),
            due: Due::default(),
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
                frames: due(self.vtk_every),
                checkpoint: due(self.checkpoint_every),
            };
        }
        if std::mem::take(&mut self.due.row) {
            self.write_row(simulation)?;
        }
        if self.due.frames {
            self.frames.write(&self.folder, simulation)?;
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
        history::row(simulation, &mut values);
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

    /// Hands everything to the system; a finished run ends with its last state, of which a restart
    /// can go on too.
    pub fn close(&mut self, simulation: &mut Simulation, finished: bool) -> Result<()> {
        let step = simulation.step();
        let written = step.is_multiple_of(self.history_every.max(1)) || self.last_row == Some(step);
        if finished && self.history_every > 0 && !written {
            self.write_row(simulation)?;
        }
        self.history.flush()?;
        if finished {
            self.frames.write(&self.folder, simulation)?;
            end_state::write(&self.folder, simulation)?;
        }
        Ok(())
    }
}
