//! What a run says about its remeshes.

use std::collections::BTreeMap;

use dempfv::coupling::Coupled;
use dempfv::scene::RemeshMode;
use serde::Serialize;

use crate::commands::format::count;

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
        }
    }

    /// What is worth a line: only what happened in the background, or failed.
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
        if self.failures > 0 {
            parts.push(format!("{} failed", count(self.failures)));
        }
        (!parts.is_empty()).then(|| format!("networks: {}", parts.join(", ")))
    }
}
