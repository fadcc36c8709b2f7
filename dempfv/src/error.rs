//! The library's errors: what happened, where, and what would be right.

use std::path::PathBuf;

use crate::coupling::CouplingError;
use crate::dem::DemError;
use crate::pfv::PfvError;
use crate::simulation::StageError;
use crate::solver::SolverError;

/// Something the user wrote is wrong: one message that says where, what, and
/// what would be right. Nothing was computed or written.
#[derive(Clone, Debug, PartialEq)]
pub struct InputError {
    /// File the input came from, if any.
    pub file: Option<PathBuf>,
    /// Line in that file, counted from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub what: String,
    /// What would be right.
    pub remedy: String,
}

impl InputError {
    /// An error that is not tied to a line of a file.
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        InputError { file: None, line: None, what: what.into(), remedy: remedy.into() }
    }

    /// Says in which file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<PathBuf>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Says on which line (from 1).
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}", file.display())?;
            if let Some(line) = self.line {
                write!(f, ":{line}")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(&self.what)?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        Ok(())
    }
}

impl std::error::Error for InputError {}

/// Any error of the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The input is wrong.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The mechanics cannot go on.
    #[error(transparent)]
    Dem(#[from] DemError),
    /// The pore network cannot be built or used.
    #[error(transparent)]
    Pfv(#[from] PfvError),
    /// Spheres and fluid cannot go on together; what mechanics, network or
    /// solver say for themselves is in the variants of these.
    #[error(transparent)]
    Coupling(CouplingError),
    /// A stage cannot come to its end.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The linear solver failed.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A system in a file cannot be solved.
    #[error("{}: {solver}: {source}{}", path.display(), in_file(source))]
    System {
        /// The file of the matrix.
        path: PathBuf,
        /// Name of the solver.
        solver: &'static str,
        /// What failed.
        source: SolverError,
    },
    /// A failure of the simulation, with the step at which it arose.
    #[error("step {step}: {source}")]
    AtStep {
        /// Step of the simulation, counted from 0 over all stages.
        step: u64,
        /// What failed.
        source: Box<Error>,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl Error {
    /// Wraps an input/output error with the file it concerns.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::Io { path: path.into(), source }
    }

    /// True when what the user wrote is wrong (the program exits with 2),
    /// false when the simulation cannot go on (3).
    pub fn is_input(&self) -> bool {
        matches!(self, Error::Input(_))
    }

    /// Whether the state after the failure is of no use to go on from: spheres
    /// where they cannot be, or numbers that are none. A stage that has used up
    /// its steps and a solver that has used up the memory leave a sound one.
    pub fn spoils_state(&self) -> bool {
        match self {
            Error::Dem(error) => CouplingError::from(error.clone()).spoils_state(),
            Error::Pfv(error) => CouplingError::from(error.clone()).spoils_state(),
            Error::Coupling(error) => error.spoils_state(),
            Error::AtStep { source, .. } => source.spoils_state(),
            _ => false,
        }
    }
}

/// Each cause has one variant, wherever it was met.
impl From<CouplingError> for Error {
    fn from(error: CouplingError) -> Self {
        match error {
            CouplingError::Dem(error) => error.into(),
            CouplingError::Pfv(error) => error.into(),
            CouplingError::Solver(error) => error.into(),
            foreign @ CouplingError::ForeignState { .. } => {
                let remedy = "take a state that this version of dempfv has made";
                InputError::new(foreign.to_string(), remedy).into()
            }
            other => Error::Coupling(other),
        }
    }
}

/// Says where a file has the unknown that an error names.
fn in_file(error: &SolverError) -> String {
    match error.column() {
        Some(column) => format!(", which is column {} of the file (counted from 1)", column + 1),
        None => String::new(),
    }
}

/// The library's result type.
pub type Result<T, E = Error> = std::result::Result<T, E>;
