//! The other programs: where they are, and which versions.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::Error;

/// Which programs are compared with. YADE is in every comparison, and CHOLMOD in ours.
pub struct Others {
    /// LAMMPS, with the start of parallel programs.
    pub lammps: Option<Lammps>,
    /// A Python that has `pypardiso`.
    pub pardiso: Option<PathBuf>,
    /// The program of `evidence/peers/faer`.
    pub faer: Option<PathBuf>,
}

/// LAMMPS on this machine.
pub struct Lammps {
    pub program: PathBuf,
    pub starter: PathBuf,
    pub version: String,
}

/// A program that can be left out.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Name {
    /// Debian's LAMMPS
    Lammps,
    /// PARDISO of the MKL, from PyPI
    Pardiso,
    /// faer
    Faer,
}

impl Lammps {
    /// Asks LAMMPS for its version.
    ///
    /// # Errors
    /// [`Error::Peer`] when it or `mpirun` is not there.
    pub fn find(program: &Path) -> Result<Lammps, Error> {
        let starter = PathBuf::from("mpirun");
        said("mpirun", &starter, &["--version"], "openmpi-bin")?;
        let text = said("LAMMPS", program, &["-h"], "lammps")?;
        let line = text.lines().find(|line| line.contains("Simulator"));
        let version = line.and_then(|line| line.split_once(" - ").map(|(_, version)| version));
        let version = version.unwrap_or("of unknown version").trim().to_owned();
        Ok(Lammps { program: program.to_owned(), starter, version })
    }
}

/// Checks that a file is there.
///
/// # Errors
/// [`Error::Peer`] when it is not, with what would help.
pub fn existing(name: &str, path: &Path, remedy: &str) -> Result<PathBuf, Error> {
    let what = |e| format!("{}: {e}; {remedy}", path.display());
    // Not canonicalize: a Python of a virtual environment is a link that must keep its name.
    path.metadata().and_then(|_| std::path::absolute(path)).map_err(|e| Error::Peer {
        step: name.to_owned(),
        what: what(e),
        log: None,
    })
}

/// What a program prints when asked for its version.
fn said(name: &str, program: &Path, arguments: &[&str], package: &str) -> Result<String, Error> {
    let fails = |what: String| Error::Peer { step: name.to_owned(), what, log: None };
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().map_err(|e| {
        let program = program.display();
        fails(format!(
            "{program} does not start: {e}; install Debian's package `{package}`, or leave it out \
             with --without"
        ))
    })?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(fails(format!("{} {}", program.display(), output.status))),
    }
}
