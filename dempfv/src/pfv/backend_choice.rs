//! Which solver a flow is solved by.

use std::fmt;
use std::sync::Arc;

use crate::solver::{Backend, SolverError, SolverKind, Symbolic, SymmetricCsc};

/// A solver of the library by its kind, or any other.
///
/// ```
/// use std::sync::Arc;
/// use dempfv::pfv::BackendChoice;
/// use dempfv::solver::{Cholmod, SolverKind};
/// let own: BackendChoice = Arc::new(Cholmod).into();
/// assert!(own != BackendChoice::from(SolverKind::Cholmod) && own == own.clone());
/// ```
#[derive(Clone)]
pub enum BackendChoice {
    /// One of the library's.
    Kind(SolverKind),
    /// Any.
    Backend(Arc<dyn Backend>),
}

impl BackendChoice {
    /// The solver's name.
    pub fn name(&self) -> &'static str {
        match self {
            BackendChoice::Kind(kind) => kind.name(),
            BackendChoice::Backend(backend) => backend.name(),
        }
    }

    /// Orders and analyzes a matrix whose unknowns lie at `points`.
    pub(super) fn analyze(
        &self,
        matrix: &SymmetricCsc,
        points: &[[f64; 3]],
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        match self {
            BackendChoice::Kind(kind) => kind.backend().analyze(matrix, Some(points)),
            BackendChoice::Backend(backend) => backend.analyze(matrix, Some(points)),
        }
    }
}

/// Two are the same if what one has analyzed serves the other.
impl PartialEq for BackendChoice {
    fn eq(&self, other: &BackendChoice) -> bool {
        match (self, other) {
            (BackendChoice::Kind(a), BackendChoice::Kind(b)) => a == b,
            (BackendChoice::Backend(a), BackendChoice::Backend(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl fmt::Debug for BackendChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("BackendChoice").field(&self.name()).finish()
    }
}

impl From<SolverKind> for BackendChoice {
    fn from(kind: SolverKind) -> BackendChoice {
        BackendChoice::Kind(kind)
    }
}

impl From<Arc<dyn Backend>> for BackendChoice {
    fn from(backend: Arc<dyn Backend>) -> BackendChoice {
        BackendChoice::Backend(backend)
    }
}

impl<B: Backend + 'static> From<Arc<B>> for BackendChoice {
    fn from(backend: Arc<B>) -> BackendChoice {
        BackendChoice::Backend(backend)
    }
}
