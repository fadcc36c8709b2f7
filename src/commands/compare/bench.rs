//! Where a comparison works: its folder, the other program, ours, and what was measured
//! before.

use std::path::{Path, PathBuf};

use dempfv::io::atomic;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::peer::Yade;
use crate::commands::context;
use crate::commands::{Error, doctor};
use crate::report::progress::Progress;

/// Folders below that of the results.
const FOLDERS: [&str; 5] = ["jobs", "logs", "points", "runs", "scenes"];

/// The workplace of a comparison.
pub struct Bench {
    /// Folder of the results.
    pub folder: PathBuf,
    /// The other program.
    pub yade: Yade,
    /// What holds of the whole run and makes older measurements useless when it changes.
    key: String,
}

/// A measurement with what it depends on.
#[derive(Serialize, Deserialize)]
struct Point<T> {
    key: String,
    value: T,
}

impl Bench {
    /// Makes the folders; with `force`, forgets what was measured before.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn new(folder: PathBuf, yade: Yade, force: bool) -> Result<Bench, Error> {
        let io = |path: &Path, e| dempfv::Error::io(path, e);
        for name in FOLDERS {
            let path = folder.join(name);
            if force && path.exists() {
                std::fs::remove_dir_all(&path).map_err(|e| io(&path, e))?;
            }
            std::fs::create_dir_all(&path).map_err(|e| io(&path, e))?;
        }
        let key = format!("YADE {}, {:?}", yade.version, doctor::versions());
        Ok(Bench { folder, yade, key })
    }

    /// What `measure` returns, or what it returned in an earlier call that did not come
    /// to its end. `input` is everything that the value depends on beside the versions
    /// of both programs.
    ///
    /// # Errors
    /// Those of `measure`, and when the value cannot be kept.
    pub fn remembered<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        input: &impl Serialize,
        measure: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        let path = self.folder.join("points").join(format!("{name}.json"));
        let input = serde_json::to_string(input).map_err(|e| dempfv::Error::io(&path, e.into()))?;
        let key = format!("{}; {input}", self.key);
        let kept = std::fs::read(&path).ok();
        let kept = kept.and_then(|text| serde_json::from_slice::<Point<T>>(&text).ok());
        if let Some(point) = kept.filter(|point| point.key == key) {
            return Ok(point.value);
        }
        let value = measure()?;
        let point = Point { key, value };
        context::write_json(&path, &point)?;
        Ok(point.value)
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
}
