//! When a network is to be renewed.

use super::active_network::ActiveNetwork;
use super::saturation::RemeshRule;

/// What is due at a network's age.
pub(super) struct Due {
    /// Half of the interval or of the strain has gone by.
    pub half: bool,
    /// The whole of one has.
    pub whole: bool,
    /// The whole of the strain has.
    pub strained: bool,
}

impl Due {
    pub fn of(network: &ActiveNetwork, rule: &RemeshRule, interval: Option<u64>) -> Due {
        let since = network.state.since;
        // An interval of no steps would be one of every step.
        let old = |halves: u64| interval.is_some_and(|n| since >= n.max(1) * halves / 2);
        let strain = network.strain(rule);
        let strained = strain > 1.0 || network.state.exhausted;
        Due { half: old(1) || strain > 0.5 || strained, whole: old(2) || strained, strained }
    }
}
