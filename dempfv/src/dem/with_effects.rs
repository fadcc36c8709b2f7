//! Spheres in contact by the granular law, which is compiled here once for all users of the library.

use super::error::DemError;
use super::law::{Granular, GranularEffects};
use super::material::{Material, WallMaterial};
use super::particles::Particles;
use super::state::DemState;
use super::system::{Dem, DemOptions};
use crate::Aabb;

impl Dem {
    /// Spheres whose contacts have these effects: the [`Granular`] law, compiled in the library.
    ///
    /// # Errors
    /// As [`Dem::with_law`] and [`Granular::new`].
    pub fn with_effects(
        effects: GranularEffects,
        particles: Particles,
        box_: Aabb,
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let law = Granular::new(effects)?;
        Dem::with_law(law, particles, box_, materials, wall_material, options)
    }

    /// Goes on from the state of contacts with these effects.
    ///
    /// # Errors
    /// As [`Dem::from_state`] and [`Granular::new`].
    pub fn with_effects_from_state(
        effects: GranularEffects,
        state: DemState,
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let law = Granular::new(effects)?;
        Dem::with_law_from_state(law, state, materials, wall_material, options)
    }
}
