//! What a new network makes of the motion of the moment, beside the one that it replaces: the error that
//! the old one had come to.

use super::coupled::Coupled;
use super::error::Result;
use super::fluid_step::motion;
use super::given_pressures::Conditions;
use super::network_change::{Comparison, NetworkChange};
use super::network_source::RemeshContext;
use super::options::{RemeshMode, Update};
use super::phases::Phases;
use super::remesher::Remesher;
use super::saturation::RemeshRule;
use crate::pfv::Flow;

impl Remesher {
    /// Solves once more in the network that is about to be replaced, where networks are compared.
    ///
    /// # Errors
    /// As a step.
    pub(super) fn look_before_swap(
        &mut self,
        context: &RemeshContext,
        phases: &mut Phases,
    ) -> Result<()> {
        let follows = self.acceleration().update == Update::EveryStep;
        let Some(network) = self.current.as_mut().filter(|_| self.comparison.is_on && !follows)
        else {
            return Ok(());
        };
        let RemeshContext { dem, time, time_step, .. } = *context;
        let end = Conditions { time: time + time_step, ..context.conditions() };
        let motion = motion(dem, &dem.storage().velocity, time_step, end);
        network.advance(&motion, phases)?;
        let spheres = dem.storage().len();
        self.comparison.before = Some(determined(&network.flow, spheres));
        Ok(())
    }
}

impl Coupled {
    /// Compares each network with the one that it replaces, under the same motion, or ceases to.
    pub(crate) fn compare_networks(&mut self, is_on: bool) {
        self.remesher.comparison = Comparison { is_on, ..Comparison::default() };
    }

    /// The last such comparison, once.
    pub(crate) fn take_network_change(&mut self) -> Option<NetworkChange> {
        self.remesher.comparison.change.take()
    }

    /// Changes when networks are renewed; the one in use stays.
    pub(crate) fn set_remesh_rule(&mut self, rule: RemeshRule) {
        if let Some(saturation) = &mut self.saturation {
            saturation.remesh = rule;
        }
    }

    /// Age of a network when it comes into use, over that when it makes room.
    pub(crate) fn networks_begin_aged(&self) -> bool {
        self.acceleration().remesh != RemeshMode::AtOnce
    }

    /// How far the network in use has come towards the limit of its strain (1).
    pub(crate) fn network_strain(&self) -> f64 {
        let rule = self.saturation.map(|saturation| saturation.remesh);
        let network = self.remesher.current.as_ref();
        rule.zip(network).map_or(0.0, |(rule, network)| network.strain(&rule))
    }

    /// As [`Coupled::pressure_at_spheres`], less their mean where the fluid leaves that open: in a periodic
    /// cell.
    pub(crate) fn determined_pressures(&self) -> Vec<f64> {
        let spheres = self.dem().len();
        match self.storage_flow() {
            Some(flow) => self.dem().numbered(&determined(flow, spheres)),
            None => vec![0.0; spheres],
        }
    }

    /// Compares a network that has done its first step with the one before.
    pub(super) fn compare_with_replaced(&mut self) {
        let Some(before) = self.remesher.comparison.before.take() else { return };
        let Some(network) = &self.remesher.current else { return };
        let now = determined(&network.flow, before.len());
        let count = before.len().max(1) as f64;
        let mean = |sum: f64| (sum / count).sqrt();
        let difference = mean(now.iter().zip(&before).map(|(a, b)| (a - b).powi(2)).sum());
        let pressure = mean(now.iter().map(|p| p * p).sum());
        self.remesher.comparison.change = Some(NetworkChange { difference, pressure });
    }
}

/// Pressures at the spheres (Pa), in storage order; less their mean where an incompressible fluid leaves a
/// constant open.
fn determined(flow: &Flow, spheres: usize) -> Vec<f64> {
    let mut pressure = flow.pressure_at_spheres(spheres);
    if flow.network().periodic().is_some() && flow.time_step().is_none() {
        let mean = pressure.iter().sum::<f64>() / spheres.max(1) as f64;
        pressure.iter_mut().for_each(|p| *p -= mean);
    }
    pressure
}
