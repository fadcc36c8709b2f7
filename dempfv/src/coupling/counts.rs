//! What was counted while networks came and went.

use std::time::Duration;

use crate::pfv::{BuildTimes, Iterations, NetworkRemarks};

/// What happened at remeshes, since the simulation began or was restarted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemeshCounts {
    /// Networks that came into use.
    pub networks: u64,
    /// Orderings and symbolic analyses; the other networks had the pattern of
    /// an earlier one.
    pub analyses: u64,
    /// Networks that could not be built, where the old one stayed in use.
    pub failures: u64,
    /// How often the time loop had to wait for the background.
    pub waits: u64,
    /// How long it waited.
    pub waited: Duration,
    /// Networks that were replaced by another.
    pub swaps: u64,
    /// The largest age of a network when it was replaced: steps since the
    /// positions that it was built from.
    pub largest_age: u64,
    /// The sum of these ages.
    pub total_age: u64,
    /// What the background built, beside the time loop.
    pub background: BuildTimes,
    /// The most of what was out of the ordinary in any of the networks.
    pub remarks: NetworkRemarks,
}

impl RemeshCounts {
    /// Mean age of a network when it was replaced (steps); `None` before.
    pub fn mean_age(&self) -> Option<f64> {
        (self.swaps > 0).then(|| self.total_age as f64 / self.swaps as f64)
    }

    pub(super) fn replaced(&mut self, age: u64) {
        self.swaps += 1;
        self.largest_age = self.largest_age.max(age);
        self.total_age += age;
    }
}

/// What following the spheres between remeshes took, since the simulation
/// began or was restarted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateCounts {
    /// Solves that were iterated.
    pub solves: u64,
    /// Applications of the factors in them.
    pub applications: u64,
    /// Most applications in one solve.
    pub most_applications: u32,
    /// Estimated error of the last pressures ([`Iterations::error`]).
    pub last_error: f64,
    /// The largest estimated error of any step.
    pub largest_error: f64,
    /// Networks that could not follow the spheres until a remesh was due.
    pub exhausted: u64,
}

impl UpdateCounts {
    pub(super) fn add(&mut self, solve: Iterations, exhausted: bool) {
        self.solves += 1;
        self.applications += u64::from(solve.applications);
        self.most_applications = self.most_applications.max(solve.applications);
        self.last_error = solve.error;
        self.largest_error = self.largest_error.max(solve.error);
        self.exhausted += u64::from(exhausted);
    }
}

/// Solves that left more than the tolerance after all their refinements, since the simulation
/// began or was restarted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnmetTolerance {
    /// How many.
    pub steps: u64,
    /// Step of the first.
    pub first: u64,
    /// The most that one left: estimated error of the pressures or imbalance of fluid mass (1).
    pub worst: f64,
}

impl UnmetTolerance {
    pub(super) fn add(&mut self, step: u64, left: f64) {
        if self.steps == 0 {
            self.first = step;
        }
        self.steps += 1;
        self.worst = self.worst.max(left);
    }
}

/// What the remesh interval is, and follows from (eq. 15 of Caulk 2020).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntervalTrail {
    /// The interval in force (steps); `None` where there is none (yet).
    pub interval: Option<u64>,
    /// What the last network took in the background (s); 0 unless measured.
    pub background_s: f64,
    /// Steps per second; 0 unless measured.
    pub steps_per_s: f64,
}
