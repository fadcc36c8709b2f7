//! The solvers by name.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    Auto, Backend, Cholmod, CholmodGpu, Cost, Frontal, GpuOptions, SolverError, Symbolic,
    SymmetricCsc, SystemSize, cost,
};

/// A solver by its name.
///
/// ```
/// use dempfv::solver::SolverKind;
/// assert_eq!("cholmod".parse(), Ok(SolverKind::Cholmod));
/// let error = "colmod".parse::<SolverKind>().unwrap_err();
/// assert_eq!(error.to_string(), "unknown solver `colmod`; the solvers are: auto, cholmod, frontal, cholmod-gpu");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// By the number of unknowns: CHOLMOD below
    /// [`FRONTAL_FROM`](super::FRONTAL_FROM), else the frontal solver; CHOLMOD too where that
    /// refuses the matrix.
    #[default]
    Auto,
    /// Supernodal Cholesky factorization by SuiteSparse's CHOLMOD.
    Cholmod,
    /// Multifrontal factorization in single precision without cancellation,
    /// for the matrices of networks, on all threads.
    Frontal,
    /// CHOLMOD with its largest parts on an NVIDIA GPU, as far as there is one
    /// and this build has the feature `cuda`; else on the CPU.
    CholmodGpu(GpuOptions),
}

impl SolverKind {
    /// Every solver with code of its own.
    pub const ALL: &'static [SolverKind] = &[
        SolverKind::Cholmod,
        SolverKind::Frontal,
        SolverKind::CholmodGpu(GpuOptions { device: 0, memory: None }),
    ];

    /// All that can be asked for by name.
    pub const CHOICES: &'static [SolverKind] = &[
        SolverKind::Auto,
        SolverKind::Cholmod,
        SolverKind::Frontal,
        SolverKind::CholmodGpu(GpuOptions { device: 0, memory: None }),
    ];

    /// The solver's name in scenes and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            SolverKind::Auto => "auto",
            SolverKind::Cholmod => "cholmod",
            SolverKind::Frontal => "frontal",
            SolverKind::CholmodGpu(_) => "cholmod-gpu",
        }
    }

    /// True where this build has all that the solver is made of. One that it
    /// lacks works too, by falling back on another.
    pub const fn is_built(self) -> bool {
        match self {
            SolverKind::Auto | SolverKind::Cholmod | SolverKind::Frontal => true,
            SolverKind::CholmodGpu(_) => cfg!(feature = "cuda"),
        }
    }

    /// The solver itself.
    pub fn backend(self) -> Box<dyn Backend> {
        match self {
            SolverKind::Auto => Box::new(Auto),
            SolverKind::Cholmod => Box::new(Cholmod),
            SolverKind::Frontal => Box::new(Frontal),
            SolverKind::CholmodGpu(options) => Box::new(CholmodGpu(options)),
        }
    }

    /// What a system of this size can be expected to take.
    pub fn cost(self, size: &SystemSize) -> Cost {
        match self {
            SolverKind::Auto => cost::auto(size.unknowns),
            SolverKind::Cholmod | SolverKind::CholmodGpu(_) => cost::CHOLMOD,
            SolverKind::Frontal => cost::FRONTAL,
        }
        .cost(size)
    }
}

/// The kind's own backend.
impl Backend for SolverKind {
    fn name(&self) -> &'static str {
        SolverKind::name(*self)
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        self.backend().analyze(a, coordinates)
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Some(SolverKind::cost(*self, size))
    }
}

/// A solver to be used: one by its name, or any backend.
///
/// Two are equal if they are the same kind, or the same object: two backends of one type may
/// have other parameters.
///
/// ```
/// use std::sync::Arc;
/// use dempfv::solver::{Backend, Frontal, Solver, SolverKind};
/// let named = Solver::from(SolverKind::Frontal);
/// let custom = Solver::from(Arc::new(Frontal) as Arc<dyn Backend>);
/// assert_eq!(named.name(), custom.name());
/// assert_eq!((named.kind(), custom.kind()), (Some(SolverKind::Frontal), None));
/// assert!(custom == custom.clone() && custom != named);
/// ```
#[derive(Clone, Debug)]
pub enum Solver {
    /// One of this library's.
    Kind(SolverKind),
    /// Any other.
    Custom(Arc<dyn Backend>),
}

impl Solver {
    /// The kind, if it is one of this library's.
    pub fn kind(&self) -> Option<SolverKind> {
        match self {
            Solver::Kind(kind) => Some(*kind),
            Solver::Custom(_) => None,
        }
    }

    fn backend(&self) -> &dyn Backend {
        match self {
            Solver::Kind(kind) => kind,
            Solver::Custom(backend) => &**backend,
        }
    }
}

impl Backend for Solver {
    fn name(&self) -> &'static str {
        self.backend().name()
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        self.backend().analyze(a, coordinates)
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        self.backend().cost(size)
    }
}

impl Default for Solver {
    fn default() -> Solver {
        Solver::Kind(SolverKind::default())
    }
}

impl PartialEq for Solver {
    fn eq(&self, other: &Solver) -> bool {
        match (self, other) {
            (Solver::Kind(a), Solver::Kind(b)) => a == b,
            (Solver::Custom(a), Solver::Custom(b)) => {
                std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b))
            }
            _ => false,
        }
    }
}

impl From<SolverKind> for Solver {
    fn from(kind: SolverKind) -> Solver {
        Solver::Kind(kind)
    }
}

impl From<Arc<dyn Backend>> for Solver {
    fn from(backend: Arc<dyn Backend>) -> Solver {
        Solver::Custom(backend)
    }
}

impl fmt::Display for SolverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no solver has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown solver `{0}`; the solvers are: {names}", names = names())]
pub struct UnknownSolver(pub String);

fn names() -> String {
    SolverKind::CHOICES.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
}

impl FromStr for SolverKind {
    type Err = UnknownSolver;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        SolverKind::CHOICES
            .iter()
            .copied()
            .find(|kind| kind.name() == s)
            .ok_or_else(|| UnknownSolver(s.to_owned()))
    }
}
