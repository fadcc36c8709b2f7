//! When a network is due, what is kept of one, and what was counted.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::viscous_bound::FastestMode;
use crate::dem::Dem;
use crate::pfv::{BuildTimes, Extrapolation, Iterations};
use crate::{Aabb, Vec3};

/// When the pore network is built anew: whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RemeshRule {
    /// After so many steps (λ_rm).
    pub interval: Option<u64>,
    /// When a pore's volume has changed by this share (eq. 14 of Caulk 2020).
    pub strain: Option<f64>,
}

/// The positions that a network is built from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Snapshot {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// The box (m).
    pub bounds: Aabb,
    /// Steps done before.
    pub step: u64,
}

impl Snapshot {
    pub fn of(dem: &Dem, step: u64) -> Snapshot {
        Snapshot { position: dem.storage().position.clone(), bounds: dem.box_(), step }
    }
}

/// What a checkpoint must hold to go on with the same networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluidState {
    /// Steps done when the state was taken.
    pub(super) step: u64,
    /// What the network in use was built from.
    pub(super) snapshot: Snapshot,
    /// Steps since it came into use, or since a remesh failed.
    pub(super) since: u64,
    /// Change of each pore's volume since the snapshot (m³); empty without the
    /// strain rule.
    pub(super) volume_change: Vec<f64>,
    /// The fluid's resistance to each wall that a servo held (N·s/m), once it
    /// is known for this network.
    pub(super) resistance: [Option<f64>; 6],
    /// The network cannot follow the spheres any further.
    pub(super) worn: bool,
    /// The pressures that the next solve goes on from.
    pub(super) extrapolation: Extrapolation,
    /// What the next network is being built from.
    pub(super) pending: Option<Snapshot>,
    /// What bounds the automatic time step, as far as it is known.
    pub(super) fastest: FastestMode,
}

impl FluidState {
    /// Steps done when the state was taken.
    pub fn step(&self) -> u64 {
        self.step
    }
}

/// What happened at remeshes, since the simulation began or was restarted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemeshCounts {
    /// Remesher that came into use.
    pub networks: u64,
    /// Orderings and symbolic analyses; the other networks had the pattern of
    /// an earlier one.
    pub analyses: u64,
    /// Remesher that could not be built, where the old one stayed in use.
    pub failures: u64,
    /// How often the time loop had to wait for the background.
    pub waits: u64,
    /// How long it waited.
    pub waited: Duration,
    /// Remesher that were replaced by another.
    pub swaps: u64,
    /// The largest age of a network when it was replaced: steps since the
    /// positions that it was built from.
    pub largest_age: u64,
    /// The sum of these ages.
    pub total_age: u64,
    /// What the background built, beside the time loop.
    pub background: BuildTimes,
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
    /// Remesher that were worn out before a remesh was due.
    pub worn_out: u64,
}

impl UpdateCounts {
    pub(super) fn add(&mut self, went: Iterations, worn: bool) {
        self.solves += 1;
        self.applications += u64::from(went.applications);
        self.most_applications = self.most_applications.max(went.applications);
        self.last_error = went.error;
        self.largest_error = self.largest_error.max(went.error);
        self.worn_out += u64::from(worn);
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
