//! The solvers by name.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{Backend, Cholmod};

/// A solver that this build offers.
///
/// ```
/// use dempfv::solver::SolverKind;
/// assert_eq!("cholmod".parse(), Ok(SolverKind::Cholmod));
/// let error = "colmod".parse::<SolverKind>().unwrap_err();
/// assert_eq!(error.to_string(), "unknown solver `colmod`; the solvers are: cholmod");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// Supernodal Cholesky factorization by SuiteSparse's CHOLMOD.
    #[default]
    Cholmod,
}

impl SolverKind {
    /// Every solver of this build.
    pub const ALL: &'static [SolverKind] = &[SolverKind::Cholmod];

    /// The solver's name in scenes and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            SolverKind::Cholmod => "cholmod",
        }
    }

    /// The solver itself.
    pub fn backend(self) -> Box<dyn Backend> {
        match self {
            SolverKind::Cholmod => Box::new(Cholmod),
        }
    }
}

impl fmt::Display for SolverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A solver's name that none of this build has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown solver `{0}`; the solvers are: {names}", names = names())]
pub struct UnknownSolver(pub String);

fn names() -> String {
    SolverKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
}

impl FromStr for SolverKind {
    type Err = UnknownSolver;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        SolverKind::ALL
            .iter()
            .copied()
            .find(|kind| kind.name() == s)
            .ok_or_else(|| UnknownSolver(s.to_owned()))
    }
}
