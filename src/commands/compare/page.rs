//! The report: one section for each part.

use std::path::{Path, PathBuf};

use dempfv::io::atomic;

use super::Part;
use super::peer::Bench;
use super::verdict::Verdict;
use crate::commands::Error;

/// The report while it grows.
pub struct Page {
    text: String,
    verdicts: Vec<Verdict>,
}

impl Page {
    /// The head of the report.
    pub fn new(bench: &Bench) -> Page {
        Page { text: format!("# dempfv beside YADE {}\n", bench.peer.version), verdicts: vec![] }
    }

    /// Adds the section of a part. A chosen one is measured unless it was measured before;
    /// with `force` in any case. One that is not chosen is shown if it is known.
    ///
    /// # Errors
    /// Those of the part.
    pub fn add<P: Part>(
        &mut self,
        bench: &Bench,
        packings: &[PathBuf],
        chosen: bool,
        force: bool,
    ) -> Result<(), Error> {
        if chosen && force {
            bench.forget(P::NAME)?;
        }
        let part = match chosen {
            true => bench.remembered(P::NAME, &packings, || P::measure(bench, packings))?,
            false => match bench.known::<P>(P::NAME, &packings)? {
                Some(part) => part,
                None => return Ok(()),
            },
        };
        self.text.push('\n');
        self.text += &part.section(&bench.folder)?;
        self.verdicts.extend(part.verdicts());
        Ok(())
    }

    /// Writes the report; returns what was judged.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write(self, path: &Path) -> Result<Vec<Verdict>, Error> {
        atomic::write(path, self.text.as_bytes())?;
        Ok(self.verdicts)
    }
}
