//! What can go wrong in a step of spheres and fluid.

use crate::dem::DemError;
use crate::excerpt::Brief;
use crate::pfv::PfvError;

/// A coupled step, or a network for it, has failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CouplingError {
    /// The mechanics cannot go on.
    #[error(transparent)]
    Dem(#[from] DemError),
    /// The pore network cannot be built or used.
    #[error(transparent)]
    Pfv(#[from] PfvError),
    /// A parameter has a value that makes no sense. Nothing has changed.
    #[error("{name} = {}; it must be {expected}", Brief(*value))]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value it was given.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// A network cannot be built from the positions of an earlier step.
    #[error("the network of the positions at step {step}: {source}")]
    Snapshot {
        /// Step at which the positions were taken.
        step: u64,
        /// What failed.
        source: Box<CouplingError>,
    },
    /// A state is of another kind, or of another version of this kind.
    #[error(
        "a state of kind `{kind}`, version {version}; this library reads `{expected_kind}`, \
         version {expected_version}"
    )]
    ForeignState {
        /// The kind that the state says it is of.
        kind: String,
        /// Its version.
        version: u32,
        /// The kind that is read.
        expected_kind: &'static str,
        /// The version that is read.
        expected_version: u32,
    },
    /// The thread that builds networks cannot be started.
    #[error("the thread that builds networks cannot be started: {what}; use fewer threads")]
    WorkerNotStarted {
        /// What the system said.
        what: String,
    },
    /// Whatever builds networks has panicked.
    #[error("building the network panicked: {what}")]
    WorkerPanicked {
        /// What it said.
        what: String,
    },
    /// Whatever builds networks gave none and no reason.
    #[error("no network was built, though nobody cancelled it")]
    NoNetwork,
}

/// The result of a coupled step and its parts.
pub(super) type Result<T, E = CouplingError> = std::result::Result<T, E>;

/// Refuses what is not a positive finite number.
pub(super) fn positive(name: &'static str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(CouplingError::Parameter { name, value, expected: "positive and finite" })
    }
}

impl CouplingError {
    /// The same error where sphere `i` of the pore network has the number
    /// `number[i]`: the user's, where the mechanics keeps the spheres in
    /// another order. Errors of the mechanics have these numbers already.
    #[must_use]
    pub fn with_numbers(self, number: &[u32]) -> CouplingError {
        match self {
            CouplingError::Pfv(error) => CouplingError::Pfv(error.with_numbers(number)),
            CouplingError::Snapshot { step, source } => {
                CouplingError::Snapshot { step, source: Box::new(source.with_numbers(number)) }
            }
            other => other,
        }
    }

    /// The user's number of the sphere that the error is about, where it is about one.
    pub fn particle(&self) -> Option<u32> {
        match self {
            CouplingError::Dem(error) => error.particle(),
            CouplingError::Snapshot { source, .. } => source.particle(),
            _ => None,
        }
    }

    /// The pore that the error is about, where it is about one.
    pub fn pore(&self) -> Option<u32> {
        match self {
            CouplingError::Pfv(error) => error.pore(),
            CouplingError::Snapshot { source, .. } => source.pore(),
            _ => None,
        }
    }

    /// Whether the state after the failure is of no use to go on from: spheres
    /// where they cannot be, or numbers that are none. A solver that has used
    /// up the memory, or a growth its steps, leaves a sound one.
    pub fn spoils_state(&self) -> bool {
        match self {
            CouplingError::Dem(error) => !matches!(error, DemError::NotSettled { .. }),
            CouplingError::Pfv(error) => !matches!(error, PfvError::Solver(_)),
            CouplingError::Snapshot { source, .. } => source.spoils_state(),
            _ => false,
        }
    }
}
