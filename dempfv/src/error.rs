//! The library's errors: what happened, where, and what would be right.

use std::path::PathBuf;

use crate::coupling::{CouplingError, TimeStepRule};
use crate::dem::DemError;
use crate::input::InputError;
use crate::io::IoError;
use crate::pfv::PfvError;
use crate::solver::SolverError;
use crate::stage_error::StageError;

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
    /// A failure under a time step above its limit, which is the likely cause.
    #[error(
        "{source}; the likely cause: the time step of {dt:.3e} s is above the limit of {limit:.3e} s that is set by \
         {rule}; take a smaller dt, or dt = \"auto\""
    )]
    Unstable {
        /// What failed.
        source: Box<Error>,
        /// The time step (s).
        dt: f64,
        /// The largest stable one (s).
        limit: f64,
        /// What sets it.
        rule: TimeStepRule,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(IoError),
}

impl Error {
    /// An error of the system, with the file that it concerns.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::Io(IoError::file(path, source))
    }

    /// The same error without the cause that it takes for likely: whoever asks knows a better one.
    pub(crate) fn without_cause(self) -> Error {
        match self {
            Error::Dem(DemError::LeftBox { particle, wall, speed, radii, .. }) => {
                DemError::LeftBox { particle, wall, speed, radii, cause: None }.into()
            }
            other => other,
        }
    }

    /// True when what the user wrote is wrong (the program exits with 2),
    /// false when the simulation cannot go on (3).
    pub fn is_input(&self) -> bool {
        matches!(self, Error::Input(_))
    }

    /// The step at which the simulation failed, counted from 0 over all stages, where it is known.
    pub fn step(&self) -> Option<u64> {
        match self {
            Error::AtStep { step, .. } => Some(*step),
            Error::Unstable { source, .. } => source.step(),
            _ => None,
        }
    }

    /// The user's number of the sphere that the error is about, where it is about one.
    pub fn sphere(&self) -> Option<u32> {
        match self {
            Error::Dem(error) => error.particle(),
            Error::Coupling(error) => error.particle(),
            Error::AtStep { source, .. } | Error::Unstable { source, .. } => source.sphere(),
            _ => None,
        }
    }

    /// The pore that the error is about, where it is about one.
    pub fn pore(&self) -> Option<u32> {
        match self {
            Error::Pfv(error) => error.pore(),
            Error::Coupling(error) => error.pore(),
            Error::AtStep { source, .. } | Error::Unstable { source, .. } => source.pore(),
            _ => None,
        }
    }

    /// Whether the state after the failure is of no use to go on from: spheres
    /// where they cannot be, or numbers that are none. A stage that has used up
    /// its steps and a solver that has used up the memory leave a sound one.
    pub fn spoils_state(&self) -> bool {
        match self {
            Error::Dem(error) => CouplingError::from(error.clone()).spoils_state(),
            Error::Pfv(error) => CouplingError::from(error.clone()).spoils_state(),
            Error::Coupling(error) => error.spoils_state(),
            Error::AtStep { source, .. } | Error::Unstable { source, .. } => source.spoils_state(),
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
            foreign @ CouplingError::ForeignState { .. } => {
                let remedy = "take a state that this version of dempfv has made";
                InputError::new(foreign.to_string(), remedy).into()
            }
            other => Error::Coupling(other),
        }
    }
}

impl From<IoError> for Error {
    fn from(error: IoError) -> Error {
        match error {
            IoError::Input(input) => Error::Input(input),
            other => Error::Io(other),
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
