//! Where the time goes.

use std::time::{Duration, Instant};

use crate::pfv::BuildTimes;

/// A part of the time loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Neighbour list and contact forces.
    Contacts,
    /// Servo walls, damping, leapfrog.
    Integration,
    /// Volumes, conductances and operators of the moment.
    Update,
    /// `V̇ = E v`.
    VolumeRates,
    /// `G p = -V̇ + Q`.
    Solve,
    /// `f = F p`.
    FluidForces,
    /// Triangulation, throats and operators of a remesh.
    Network,
    /// Ordering and symbolic analysis of a remesh.
    Analyze,
    /// Numeric factorization of a remesh.
    Factor,
    /// Taking a new network into use: pressures carried over, the old one freed.
    Swap,
    /// Waiting for a network from the background.
    Wait,
    /// The viscous bound of the automatic time step.
    TimeStep,
}

impl Phase {
    /// All phases.
    pub const ALL: [Phase; 12] = [
        Phase::Contacts,
        Phase::Integration,
        Phase::Update,
        Phase::VolumeRates,
        Phase::Solve,
        Phase::FluidForces,
        Phase::Network,
        Phase::Analyze,
        Phase::Factor,
        Phase::Swap,
        Phase::Wait,
        Phase::TimeStep,
    ];

    /// The phase's name in summaries.
    pub const fn name(self) -> &'static str {
        [
            "contacts",
            "integration",
            "update",
            "volume_rates",
            "solve",
            "fluid_forces",
            "network",
            "analyze",
            "factor",
            "swap",
            "wait",
            "time_step",
        ][self as usize]
    }
}

/// Wall-clock time of the time loop in each phase. Phases that ran beside each
/// other count in full; what the background built does not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases {
    total: [Duration; Phase::ALL.len()],
}

impl Phases {
    /// Runs a function and books its time.
    pub fn time<T>(&mut self, phase: Phase, run: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let out = run();
        self.add(phase, start.elapsed());
        out
    }

    /// Books time that was measured elsewhere.
    pub fn add(&mut self, phase: Phase, spent: Duration) {
        self.total[phase as usize] += spent;
    }

    /// Books what building a network took.
    pub(super) fn book_build(&mut self, times: BuildTimes) {
        self.add(Phase::Network, times.network);
        self.add(Phase::Analyze, times.analyze);
        self.add(Phase::Factor, times.factor);
    }

    /// Books what another thread has booked.
    pub(super) fn merge(&mut self, other: &Phases) {
        self.total.iter_mut().zip(other.total).for_each(|(t, o)| *t += o);
    }

    /// Time spent in a phase.
    pub fn spent(&self, phase: Phase) -> Duration {
        self.total[phase as usize]
    }

    /// Each phase's name and its total in milliseconds.
    pub fn in_ms(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        Phase::ALL.into_iter().map(|p| (p.name(), self.spent(p).as_secs_f64() * 1e3))
    }
}
