//! Runs our own program as a user would, in a process of its own.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use super::Bench;
use crate::Error;

/// A run of ours.
pub struct Run {
    /// Its `summary.json`.
    pub summary: Value,
    /// Its `history.csv`.
    pub history: History,
}

/// A table of numbers, by column.
pub struct History {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl History {
    /// Reads a table with a header; what is no number becomes NaN.
    fn parse(text: &str) -> History {
        let mut lines = text.lines().map(|line| line.split(','));
        let columns = lines.next().map(|c| c.map(str::to_owned).collect()).unwrap_or_default();
        let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
        History { columns, rows: lines.map(|row| row.map(number).collect()).collect() }
    }

    /// The values of a column from row to row; `None` if there is no such column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|c| c == name)?;
        Some(self.rows.iter().map(|row| row.get(at).copied().unwrap_or(f64::NAN)).collect())
    }
}

impl<P> Bench<P> {
    /// Our own program, for a process of its own.
    ///
    /// # Errors
    /// [`Error::Peer`] when the system does not tell where it is.
    pub fn program(&self, step: &str) -> Result<PathBuf, Error> {
        std::env::current_exe().map_err(|e| {
            let what = format!("this program is not to be found: {e}");
            Error::Peer { step: step.to_owned(), what, log: None }
        })
    }

    /// Carries out a scene with our own program; `summary.json` and `history.csv` stay in
    /// `runs/STEP`.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails; its log is kept.
    pub fn ours(&self, step: &str, scene: &str, threads: usize) -> Result<Run, Error> {
        let scene = self.write(&format!("scenes/{step}.toml"), scene)?;
        let folder = self.folder.join("runs").join(step);
        let wrong = |what: String, log| Error::Peer { step: step.to_owned(), what, log };
        let mut command = Command::new(self.program(step)?);
        command.arg("run").arg(&scene).arg("--out").arg(&folder).arg("--force");
        command.args(["--threads", &threads.to_string()]);
        let log = self.run_logged(&format!("{step}-dempfv"), "dempfv", &mut command)?;
        let read = |name: &str| {
            std::fs::read_to_string(folder.join(name))
                .map_err(|e| wrong(format!("dempfv left no {name}: {e}"), Some(log.clone())))
        };
        let summary = serde_json::from_str(&read("summary.json")?)
            .map_err(|e| wrong(format!("dempfv's summary is none: {e}"), Some(log.clone())))?;
        let history = History::parse(&read("history.csv")?);
        Ok(Run { summary, history })
    }
}
