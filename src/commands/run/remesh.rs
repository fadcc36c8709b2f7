//! What a run says about its remeshes.

use std::collections::BTreeMap;

use dempfv::coupling::{Coupled, UpdateCounts};
use dempfv::coupling::{RemeshMode, Update};
use dempfv_report::format::count;
use serde::Serialize;

/// What happened at the remeshes of a session.
#[derive(Serialize)]
pub struct Remesh {
    /// `at once`, `ahead` or `background`.
    mode: &'static str,
    /// `when due` or `when ready`.
    swap: &'static str,
    /// Orderings and symbolic analyses.
    analyses: u64,
    /// Networks that could not be built, where the old one stayed.
    failures: u64,
    /// How often the time loop waited for the background, and how long in all.
    waits: u64,
    waited_s: f64,
    /// Age of the networks when they were replaced, in steps since the
    /// positions that they were built from.
    largest_age: u64,
    mean_age: Option<f64>,
    /// The interval in force at the end (steps).
    interval: Option<u64>,
    /// What the background took (ms), beside the time loop.
    background_ms: BTreeMap<&'static str, f64>,
    /// `remesh` or `every step`.
    update: &'static str,
    /// What following the spheres took; `None` where networks do not.
    every_step: Option<EveryStep>,
}

/// What following the spheres between remeshes took.
#[derive(Serialize)]
struct EveryStep {
    solves: u64,
    /// Applications of the factors in a solve.
    mean_applications: f64,
    most_applications: u32,
    /// Estimated errors of the pressures.
    last_error: f64,
    largest_error: f64,
    /// Networks that were worn out before a remesh was due.
    worn_out: u64,
}

impl EveryStep {
    fn of(counts: &UpdateCounts) -> EveryStep {
        EveryStep {
            solves: counts.solves,
            mean_applications: counts.applications as f64 / counts.solves.max(1) as f64,
            most_applications: counts.most_applications,
            last_error: counts.last_error,
            largest_error: counts.largest_error,
            worn_out: counts.exhausted,
        }
    }
}

impl Remesh {
    /// Sums up what a simulation has counted.
    pub fn of(coupled: &Coupled) -> Remesh {
        let (acceleration, counts) = (coupled.acceleration(), coupled.remesh_counts());
        let background = counts.background;
        Remesh {
            mode: acceleration.remesh.name(),
            swap: acceleration.swap.name(),
            analyses: counts.analyses,
            failures: counts.failures,
            waits: counts.waits,
            waited_s: counts.waited.as_secs_f64(),
            largest_age: counts.largest_age,
            mean_age: counts.mean_age(),
            interval: coupled.interval_trail().interval,
            background_ms: [
                ("network", background.network),
                ("analyze", background.analyze),
                ("factor", background.factor),
            ]
            .map(|(name, spent)| (name, 1e3 * spent.as_secs_f64()))
            .into(),
            update: acceleration.update.name(),
            every_step: (acceleration.update == Update::EveryStep)
                .then(|| EveryStep::of(coupled.update_counts())),
        }
    }

    /// What is worth a line: only what happened in the background, failed, or
    /// followed the spheres.
    pub fn line(&self) -> Option<String> {
        let mut parts = vec![];
        if self.mode == RemeshMode::Background.name() {
            let spent: f64 = self.background_ms.values().sum();
            parts.push(format!("background {:.1} s", spent / 1e3));
            parts.push(format!("waited {:.1} s in {}", self.waited_s, count(self.waits)));
        }
        if let Some(mean) = self.mean_age.filter(|_| self.mode != RemeshMode::AtOnce.name()) {
            parts.push(format!(
                "replaced at an age of {mean:.0} steps, {} at most",
                count(self.largest_age)
            ));
        }
        if let Some(every_step) = self.every_step.as_ref().filter(|e| e.solves > 0) {
            parts.push(format!(
                "followed the spheres with {:.1} applications a step, error {:.0e} at most",
                every_step.mean_applications, every_step.largest_error
            ));
            if every_step.worn_out > 0 {
                parts.push(format!("{} worn out early", count(every_step.worn_out)));
            }
        }
        if self.failures > 0 {
            parts.push(format!("{} failed", count(self.failures)));
        }
        (!parts.is_empty()).then(|| format!("networks: {}", parts.join(", ")))
    }
}
