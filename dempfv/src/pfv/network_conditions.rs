//! What is asked of a network beside the constant pressures of walls.

use serde::{Deserialize, Serialize};

use super::frame::Frame;
use super::terms::{PoreSource, Sources};
use super::{
    ConductanceRules, Fluid, ImposedPressure, Network, PfvError, PoreConditions, PressureProfile,
};
use crate::{Aabb, PerWall, Vec3};

/// Conditions beside constant pressures of walls, and how throats conduct. Default: none, and as
/// their geometry says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkConditions {
    /// Pressures along walls with an imposed pressure, which adds to them.
    pub profiles: PerWall<Option<PressureProfile>>,
    /// Pressures imposed on pores of choice.
    pub imposed: Vec<ImposedPressure>,
    /// How throats conduct.
    pub conductances: ConductanceRules,
}

impl NetworkConditions {
    /// Refuses conditions and sources that contradict each other, or select nothing, in the network
    /// of these spheres: centres and radii, and the box (m). As building a flow does, without a
    /// factorization.
    ///
    /// # Errors
    /// As [`Assembled::with_conditions`](super::Assembled::with_conditions) and
    /// [`Flow::set_sources`](super::Flow::set_sources).
    pub fn check(
        &self,
        position: &[Vec3],
        radius: &[f64],
        bounds: Aabb,
        fluid: &Fluid,
        sources: &[PoreSource],
    ) -> Result<(), PfvError> {
        let (mut network, _) = Network::new(position, radius, bounds, fluid)?;
        let conditions = self.apply(&mut network, position, radius, fluid)?;
        Sources::new(&network, &conditions, position, sources).map(drop)
    }

    /// Changes the conductances of a network that has just been built, and gives each of its pores
    /// its condition.
    pub(super) fn apply(
        &self,
        network: &mut Network,
        position: &[Vec3],
        radius: &[f64],
        fluid: &Fluid,
    ) -> Result<PoreConditions, PfvError> {
        let frame = Frame::new(position, radius, &network.bounds);
        network.change_conductances(&frame, position, &self.conductances)?;
        let mut conditions = PoreConditions::of_walls(network, &fluid.boundary);
        for imposed in &self.imposed {
            conditions.impose(network, position, imposed)?;
        }
        conditions.set_profiles(network, &self.profiles)?;
        Ok(conditions)
    }
}
