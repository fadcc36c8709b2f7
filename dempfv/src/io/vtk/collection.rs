//! The `.pvd` file: which frame shows which time.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::grid::{escape, unescape};
use crate::input::InputError;
use crate::io::IoError;
use crate::io::atomic;
use crate::io::error::Result;

/// A collection of frames, rewritten whole at each new one, so that ParaView
/// can open (and reload) it while the run goes on.
///
/// ```
/// use dempfv::io::vtk::Collection;
/// let path = std::env::temp_dir().join("dempfv-doc.pvd");
/// let mut frames = Collection::new(&path);
/// frames.push(0.5, "pores-000000.vtu")?;
/// assert_eq!(Collection::resume(&path, 0.5)?.len(), 1);
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), dempfv::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Collection {
    path: PathBuf,
    frames: Vec<(f64, String)>,
}

impl Collection {
    /// An empty collection; the file is written with its first frame.
    pub fn new(path: &Path) -> Collection {
        Collection { path: path.to_owned(), frames: Vec::new() }
    }

    /// The collection of an earlier run without the frames after `last_time`
    /// (s); empty if there is no file.
    ///
    /// # Errors
    /// [`InputError`] when the file is no collection of this program, or the
    /// time is no number; [`IoError::File`] when it cannot be read.
    pub fn resume(path: &Path, last_time: f64) -> Result<Collection> {
        check_time("last_time", last_time)?;
        let text = match std::fs::read_to_string(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Collection::new(path)),
            other => other.map_err(|e| IoError::file(path, e))?,
        };
        let mut collection = Collection::new(path);
        let lines = text.lines().enumerate().filter(|(_, l)| l.starts_with("<DataSet "));
        for (i, line) in lines {
            let attribute = |name: &str| line.split_once(name)?.1.split_once('"').map(|(v, _)| v);
            let time = attribute("timestep=\"").and_then(|t| t.parse::<f64>().ok());
            let (Some(time), Some(file)) = (time, attribute("file=\"")) else {
                let error =
                    InputError::new("no frame of this program", "restart into another folder");
                return Err(error.in_file(path).at_line(i + 1).into());
            };
            if time <= last_time {
                collection.frames.push((time, unescape(file)));
            }
        }
        Ok(collection)
    }

    /// Appends the frame of a time (s), in the place of an earlier one of that name. `file` is
    /// relative to the collection's folder and must exist already: a reader may come at any
    /// moment.
    ///
    /// # Errors
    /// [`IoError::File`] when the file cannot be written; the old one then stands.
    /// [`InputError`] for a time that is no number.
    pub fn push(&mut self, time: f64, file: &str) -> Result<()> {
        check_time("time", time)?;
        // Where the collection could not be written, the frame comes a second time.
        self.frames.retain(|(_, other)| other != file);
        self.frames.push((time, file.to_owned()));
        atomic::write(&self.path, self.text().as_bytes())
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// True when there is no frame.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    fn text(&self) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (time, file) in &self.frames {
            let file = escape(file);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>");
        }
        text.push_str("</Collection>\n</VTKFile>\n");
        text
    }
}

fn check_time(name: &str, time: f64) -> Result<()> {
    if time.is_finite() {
        return Ok(());
    }
    Err(InputError::new(format!("`{name}` is {time}"), "give a finite time in s").into())
}
