//! What a run says of the checkpoint that it went on from.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use dempfv::simulation::{Change, Simulation};
use dempfv_report::format::count;
use serde::Serialize;

/// Where a run went on from, and with what.
#[derive(Clone, Serialize)]
pub struct Restart {
    /// The checkpoint.
    from: PathBuf,
    /// Steps that were done before.
    step: u64,
    /// What the scene says otherwise than the one that the checkpoint was made with.
    changed: Vec<Change>,
}

impl Restart {
    /// `None` for a run that began with its scene.
    pub fn of(simulation: &Simulation, from: Option<&Path>) -> Option<Restart> {
        let restarted = simulation.restarted()?.clone();
        Some(Restart { from: from?.to_owned(), step: restarted.step, changed: restarted.changed })
    }

    /// Says it on stderr before the first step: a run may take days, and whoever changed the
    /// wrong key wants to know at once.
    pub fn announce(&self) {
        // A closed stderr is no reason to stop.
        let _ = write!(io::stderr(), "{self}");
    }
}

impl fmt::Display for Restart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Restart { from, step, changed } = self;
        write!(f, "restart from {} at step {}: ", from.display(), count(*step))?;
        match changed.len() {
            0 => writeln!(f, "the scene is the one that it was made with"),
            1 => writeln!(f, "one key of the scene has changed"),
            n => writeln!(f, "{n} keys of the scene have changed"),
        }?;
        changed.iter().try_for_each(|change| writeln!(f, "  {change}"))
    }
}
