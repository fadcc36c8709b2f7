//! What may be changed of the mechanics between two steps.

use super::coupled::Coupled;
use super::error::{CouplingError, Result};
use crate::dem::{BodyForce, CellControls, Dem, Material, MaterialPair, Motion, WallControl};
use crate::{Vec3, WallId};

/// The mechanics, as far as they may be changed between two steps while a
/// network is in use: spheres keep their places, radii and order. From
/// [`Coupled::controls`].
pub struct Controls<'a> {
    coupled: &'a mut Coupled,
}

impl Coupled {
    /// Changes the mechanics between two steps.
    ///
    /// ```
    /// use dempfv::coupling::Coupled;
    /// use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
    /// use dempfv::{Aabb, Vec3, WallId};
    ///
    /// let material =
    ///     Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// let sphere = Particles::new(vec![Vec3::repeat(0.5)], vec![0.4], material.density);
    /// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    /// let dem = Dem::new(sphere, bounds, material, walls, DemOptions::default())?;
    /// let mut coupled = Coupled::new(dem);
    /// coupled.controls().set_control(WallId::YMax, WallControl::Velocity(-0.1))?;
    /// coupled.step(1e-3)?;
    /// assert_eq!(coupled.dem().box_().size().y, 1.0 - 1e-4);
    /// # Ok::<(), dempfv::coupling::CouplingError>(())
    /// ```
    pub fn controls(&mut self) -> Controls<'_> {
        Controls { coupled: self }
    }
}

impl Controls<'_> {
    /// The mechanics, to be looked at.
    pub fn dem(&self) -> &Dem {
        &self.coupled.dem
    }

    /// Tells a wall what moves it from now on.
    ///
    /// # Errors
    /// As [`Dem::set_control`].
    pub fn set_control(&mut self, wall: WallId, control: WallControl) -> Result<()> {
        Ok(self.coupled.dem.set_control(wall, control)?)
    }

    /// Tells what moves the periodic cell from now on.
    ///
    /// # Errors
    /// As [`Dem::set_cell_controls`].
    pub fn set_cell_controls(&mut self, controls: CellControls) -> Result<()> {
        Ok(self.coupled.dem.set_cell_controls(controls)?)
    }

    /// Gives spheres a motion from now on, which is the model time (s): see [`Dem::prescribe`].
    ///
    /// # Errors
    /// As [`Dem::prescribe`] and [`Dem::set_time`].
    pub fn prescribe(&mut self, numbers: &[u32], motion: Motion, time: f64) -> Result<()> {
        self.coupled.dem.prescribe(numbers, motion)?;
        Ok(self.coupled.dem.set_time(time)?)
    }

    /// Lets spheres move freely again: see [`Dem::release`].
    ///
    /// # Errors
    /// As [`Dem::release`].
    pub fn release(&mut self, numbers: &[u32]) -> Result<()> {
        Ok(self.coupled.dem.release(numbers)?)
    }

    /// Gives a clump another motion: see [`Dem::set_clump_motion`].
    ///
    /// # Errors
    /// As [`Dem::set_clump_motion`].
    pub fn set_clump_motion(&mut self, clump: usize, velocity: Vec3, spin: Vec3) -> Result<()> {
        Ok(self.coupled.dem.set_clump_motion(clump, velocity, spin)?)
    }

    /// Bonds the spheres: see [`Dem::bond`]. An automatic time step is looked at anew.
    ///
    /// # Errors
    /// As [`Dem::bond`].
    pub fn bond(&mut self) -> Result<u64> {
        self.coupled.auto_time_step.refresh();
        Ok(self.coupled.dem.bond()?)
    }

    /// Changes the friction angle between spheres (rad). An automatic time step
    /// is looked at anew.
    ///
    /// # Errors
    /// As [`Dem::set_friction`].
    pub fn set_friction(&mut self, angle: f64) -> Result<()> {
        self.coupled.auto_time_step.refresh();
        Ok(self.coupled.dem.set_friction(angle)?)
    }

    /// Changes what the spheres are made of: see [`Dem::set_materials`]. An automatic time step is looked
    /// at anew.
    ///
    /// # Errors
    /// As [`Dem::set_materials`].
    pub fn set_materials(&mut self, materials: &[Material], pairs: &[MaterialPair]) -> Result<()> {
        self.coupled.auto_time_step.refresh();
        Ok(self.coupled.dem.set_materials(materials, pairs)?)
    }

    /// Changes the local damping (1). An automatic time step is looked at anew.
    ///
    /// # Errors
    /// As [`Dem::set_damping`].
    pub fn set_damping(&mut self, damping: f64) -> Result<()> {
        self.coupled.auto_time_step.refresh();
        Ok(self.coupled.dem.set_damping(damping)?)
    }

    /// Adds a force (N) to the sphere with this number, in the next step only; see
    /// [`Dem::add_force`].
    pub fn add_force(&mut self, number: usize, force: Vec3) {
        self.coupled.dem.add_force(number, force);
    }

    /// Adds a torque (N m) to the sphere with this number, in the next step only; see
    /// [`Dem::add_torque`].
    pub fn add_torque(&mut self, number: usize, torque: Vec3) {
        self.coupled.dem.add_torque(number, torque);
    }

    /// Lets a force of the caller's own act on the spheres from the next step on: see
    /// [`Dem::add_body_force`].
    pub fn add_body_force(&mut self, body_force: Box<dyn BodyForce>) {
        self.coupled.dem.add_body_force(body_force);
    }

    /// Ends all body forces, and gives them back.
    pub fn take_body_forces(&mut self) -> Vec<Box<dyn BodyForce>> {
        self.coupled.dem.take_body_forces()
    }

    /// Changes the pressure (Pa) that a wall imposes, in the steps to come: in the place of the one that
    /// the fluid or its effects have, through remeshes and stages. A step is refused where the wall
    /// imposes none then.
    ///
    /// # Errors
    /// [`CouplingError::Parameter`] for a pressure that is not finite.
    pub fn set_wall_pressure(&mut self, wall: WallId, pressure: f64) -> Result<()> {
        self.coupled.given.set_wall(wall, finite_pressure(pressure)?);
        Ok(())
    }

    /// Changes the pressure (Pa) of one of [`FluidEffects::imposed`](super::FluidEffects::imposed),
    /// by its place, likewise.
    ///
    /// # Errors
    /// As [`Controls::set_wall_pressure`].
    pub fn set_imposed_pressure(&mut self, number: usize, pressure: f64) -> Result<()> {
        self.coupled.given.set_region(number, finite_pressure(pressure)?);
        Ok(())
    }

    /// Begins to track energy by cause, or ends it; see [`Dem::track_energy`].
    pub fn track_energy(&mut self, on: bool) {
        self.coupled.dem.track_energy(on);
    }

    /// Makes what turning contacts lose a cause of its own, or not; see [`Dem::track_turning`].
    pub fn track_turning(&mut self, on: bool) {
        self.coupled.dem.track_turning(on);
    }

    /// Velocities (m/s) and spins (rad/s), in storage order.
    pub fn storage_velocities_mut(&mut self) -> (&mut [Vec3], &mut [Vec3]) {
        self.coupled.dem.storage_velocities_mut()
    }
}

fn finite_pressure(value: f64) -> Result<f64> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(CouplingError::Parameter { name: "pressure", value, expected: "finite" }),
    }
}
