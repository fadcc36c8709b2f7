//! How long a flow took to build.

use std::time::Duration;

/// How long the parts of [`Flow::new`](super::Flow::new) took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildTimes {
    /// Triangulation, pores, throats and operators.
    pub network: Duration,
    /// Ordering and symbolic analysis; next to nothing where that of an
    /// earlier network served again.
    pub analyze: Duration,
    /// Numeric factorization.
    pub factor: Duration,
}

impl BuildTimes {
    /// All parts together.
    pub fn total(&self) -> Duration {
        self.network + self.analyze + self.factor
    }
}

impl std::ops::AddAssign for BuildTimes {
    fn add_assign(&mut self, other: BuildTimes) {
        self.network += other.network;
        self.analyze += other.analyze;
        self.factor += other.factor;
    }
}
