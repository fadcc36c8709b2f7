//! The remesh interval from measured times (eq. 15 of Caulk 2020).

use std::time::Duration;

/// Room above the bound, so that a step that is a little faster than the last
/// ones does not have to wait.
const MARGIN: f64 = 1.1;

/// Chooses λ_rm ≥ 2 t_bg v_iter: half an interval of steps takes as long as a
/// network in the background.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AutoInterval {
    /// What the last network took to build (s).
    background: f64,
    /// Time of the steps that count (s), and their number. Both are halved at
    /// each swap, so that the last interval counts most.
    spent: f64,
    steps: f64,
}

impl AutoInterval {
    /// Books what a network took to build.
    pub fn built(&mut self, took: Duration) {
        self.background = took.as_secs_f64();
    }

    /// Books a step, without what it waited or built itself.
    pub fn stepped(&mut self, took: Duration) {
        self.spent += took.as_secs_f64();
        self.steps += 1.0;
    }

    /// A new interval begins.
    pub fn swapped(&mut self) {
        self.spent *= 0.5;
        self.steps *= 0.5;
    }

    /// The interval (steps); `None` before the first step.
    pub fn interval(&self) -> Option<u64> {
        let steps = MARGIN * 2.0 * self.background * self.steps_per_s()?;
        Some((steps.ceil() as u64).max(2))
    }

    /// Time of the last network (s).
    pub fn background_s(&self) -> f64 {
        self.background
    }

    /// Steps per second, v_iter; `None` before the first.
    pub fn steps_per_s(&self) -> Option<f64> {
        (self.spent > 0.0).then(|| self.steps / self.spent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A network of 3 s beside steps of 50 ms: eq. 15 asks for 2 · 3 · 20 = 120
    /// steps, and a tenth is added.
    #[test]
    fn the_interval_follows_eq_15() {
        let mut auto = AutoInterval::default();
        auto.built(Duration::from_secs(3));
        assert_eq!(auto.interval(), None);
        for _ in 0..40 {
            auto.stepped(Duration::from_millis(50));
        }
        assert_eq!(auto.interval(), Some(132));
        auto.built(Duration::from_millis(1));
        assert_eq!(auto.interval(), Some(2), "a snapshot comes before a swap");
    }

    /// Steps become four times slower: after four intervals of 40 steps the
    /// old ones count 2⁻⁴ each, and the interval is within 5 % of its new bound.
    #[test]
    fn the_last_intervals_count_most() {
        let mut auto = AutoInterval::default();
        auto.built(Duration::from_secs(30));
        let mut run = |ms: u64| {
            for _ in 0..40 {
                auto.stepped(Duration::from_millis(ms));
            }
            let found = auto.interval().unwrap();
            auto.swapped();
            found
        };
        assert_eq!(run(10), 6600);
        let after: Vec<u64> = (0..4).map(|_| run(40)).collect();
        assert!(after.is_sorted_by(|a, b| a > b), "{after:?}");
        assert!((1650..1750).contains(&after[3]), "{after:?}");
    }
}
