//! Where measurements are made: a folder, the programs that run in it with their logs,
//! and what was measured before.

mod ours;
pub mod sample;

use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};

use dempfv::io::atomic;
use dempfv_report::progress::Progress;
use dempfv_report::{json, versions};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use self::ours::Run;
use crate::Error;

/// Folders below that of the results.
const FOLDERS: [&str; 5] = ["jobs", "logs", "points", "runs", "scenes"];

/// The workplace of a series of measurements, perhaps with another program beside ours.
pub struct Bench<P = ()> {
    /// Folder of the results.
    pub folder: PathBuf,
    /// The other program.
    pub peer: P,
    /// What holds of the whole run and makes older measurements useless when it changes.
    key: String,
}

/// A measurement with what it depends on.
#[derive(Serialize, Deserialize)]
struct Point<T> {
    key: String,
    value: T,
}

impl<P> Bench<P> {
    /// Makes the folders. `versions`: those of the other program.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn new(folder: PathBuf, peer: P, versions: &str) -> Result<Bench<P>, Error> {
        let key = format!("{versions}, {:?}", versions::all());
        Bench::with_key(folder, peer, key)
    }

    /// As [`new`](Bench::new), for measurements of hours: they outlast changes of this
    /// program, and each has to say with which revision it was made. `machine`: what they
    /// depend on beside the libraries.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn lasting(folder: PathBuf, peer: P, machine: &str) -> Result<Bench<P>, Error> {
        let mut versions = versions::all();
        versions.remove("git");
        Bench::with_key(folder, peer, format!("{machine}, {versions:?}"))
    }

    fn with_key(folder: PathBuf, peer: P, key: String) -> Result<Bench<P>, Error> {
        for name in FOLDERS {
            let path = folder.join(name);
            std::fs::create_dir_all(&path).map_err(|e| dempfv::Error::io(&path, e))?;
        }
        Ok(Bench { folder, peer, key })
    }

    /// Forgets the points whose names begin like this.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn forget(&self, prefix: &str) -> Result<(), Error> {
        let points = self.folder.join("points");
        let entries = std::fs::read_dir(&points).map_err(|e| dempfv::Error::io(&points, e))?;
        for path in entries.flatten().map(|e| e.path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with(prefix) {
                std::fs::remove_file(&path).map_err(|e| dempfv::Error::io(&path, e))?;
            }
        }
        Ok(())
    }

    /// What `measure` returns, or what it returned in an earlier call. `input` is
    /// everything that the value depends on beside the versions of both programs. The name
    /// begins with that of its part.
    ///
    /// # Errors
    /// Those of `measure`, and when the value cannot be kept.
    pub fn remembered<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        input: &impl Serialize,
        measure: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        if let Some(value) = self.known(name, input)? {
            return Ok(value);
        }
        let value = measure()?;
        let point = Point { key: self.key(input)?, value };
        json::write(&self.point(name), &point)?;
        Ok(point.value)
    }

    /// What an earlier call measured on the same input.
    ///
    /// # Errors
    /// When the input cannot be written as JSON.
    pub fn known<T: DeserializeOwned>(
        &self,
        name: &str,
        input: &impl Serialize,
    ) -> Result<Option<T>, Error> {
        let key = self.key(input)?;
        let kept = std::fs::read(self.point(name)).ok();
        let kept = kept.and_then(|text| serde_json::from_slice::<Point<T>>(&text).ok());
        Ok(kept.filter(|point| point.key == key).map(|point| point.value))
    }

    fn point(&self, name: &str) -> PathBuf {
        self.folder.join("points").join(format!("{name}.json"))
    }

    fn key(&self, input: &impl Serialize) -> Result<String, Error> {
        let input = serde_json::to_string(input)
            .map_err(|e| dempfv::Error::io(self.folder.join("points"), e.into()))?;
        Ok(format!("{}; {input}", self.key))
    }

    /// A file in a folder of the comparison, written at once.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write(&self, name: &str, text: &str) -> Result<PathBuf, Error> {
        let path = self.folder.join(name);
        atomic::write(&path, text.as_bytes())?;
        Ok(path)
    }

    /// Does one step with a line on the terminal that says so.
    pub fn step<T>(&self, name: &str, work: impl FnOnce() -> T) -> T {
        let mut progress = Progress::new();
        progress.wait(name);
        let out = work();
        progress.waited();
        out
    }

    /// Runs a program to its end, with what it prints in a log; returns the log.
    ///
    /// # Errors
    /// [`Error::Peer`] when it does not start or does not end well.
    pub fn run_logged(
        &self,
        step: &str,
        program: &str,
        command: &mut Command,
    ) -> Result<PathBuf, Error> {
        let path = self.folder.join("logs").join(format!("{step}.log"));
        let io = |e| dempfv::Error::io(&path, e);
        let log = File::create(&path).map_err(io)?;
        let errors = log.try_clone().map_err(io)?;
        command.stdin(Stdio::null()).stdout(log).stderr(errors);
        let wrong = |what: String, log| Error::Peer { step: step.to_owned(), what, log };
        let status = self
            .step(step, || command.status())
            .map_err(|e| wrong(format!("{program} does not start: {e}"), None))?;
        match status.success() {
            true => Ok(path),
            false => Err(wrong(format!("{program} {}", ending(status)), Some(path.clone()))),
        }
    }
}

/// How a program ended, in words.
pub fn ending(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match (status.code(), status.signal()) {
        (Some(0), _) => "ends well".to_owned(),
        (Some(code), _) => format!("ends with status {code}"),
        (None, Some(11)) => "crashes (segmentation fault)".to_owned(),
        (None, signal) => format!("is ended by signal {}", signal.unwrap_or(0)),
    }
}
