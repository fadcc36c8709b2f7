//! The spheres as the outside world knows them: by the user's numbers.
//!
//! A [`Dem`] stores its spheres in an order of its own. Everything here takes
//! and gives the user's numbers, the places in the list that the `Dem` was
//! made of; see [`Dem::storage`] for the arrays as they are stored.

use super::error::{DemError, require_length};
use super::system::Dem;
use crate::Vec3;

/// # Spheres by the user's numbers
///
/// # Panics
/// All that take a `number` panic where no sphere has it, as an index beyond a slice does. What
/// is set or added and is not finite, is refused by the next step, which names the sphere.
impl Dem {
    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// True when there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty()
    }

    /// Place of the sphere `number` in the arrays of [`Dem::storage`].
    pub fn storage_index(&self, number: usize) -> usize {
        self.place[number] as usize
    }

    /// Centre of a sphere (m).
    pub fn position(&self, number: usize) -> Vec3 {
        self.particles.position[self.storage_index(number)]
    }

    /// Velocity of a sphere (m/s), half a time step behind its position.
    pub fn velocity(&self, number: usize) -> Vec3 {
        self.particles.velocity[self.storage_index(number)]
    }

    /// Angular velocity of a sphere (rad/s), likewise.
    pub fn spin(&self, number: usize) -> Vec3 {
        self.particles.spin[self.storage_index(number)]
    }

    /// Radius of a sphere (m).
    pub fn radius(&self, number: usize) -> f64 {
        self.particles.radius[self.storage_index(number)]
    }

    /// Mass of a sphere (kg).
    pub fn mass(&self, number: usize) -> f64 {
        self.particles.mass[self.storage_index(number)]
    }

    /// Force of the contacts on a sphere (N), from the last
    /// [`Dem::compute_contacts`].
    pub fn force(&self, number: usize) -> Vec3 {
        self.storage_forces()[self.storage_index(number)]
    }

    /// Torque of the contacts on a sphere (N m), likewise.
    pub fn torque(&self, number: usize) -> Vec3 {
        self.storage_torques()[self.storage_index(number)]
    }

    /// Centres of all spheres (m).
    pub fn positions(&self) -> Vec<Vec3> {
        self.numbered(&self.particles.position)
    }

    /// Velocities of all spheres (m/s), half a time step behind the positions.
    pub fn velocities(&self) -> Vec<Vec3> {
        self.numbered(&self.particles.velocity)
    }

    /// Angular velocities of all spheres (rad/s), likewise.
    pub fn spins(&self) -> Vec<Vec3> {
        self.numbered(&self.particles.spin)
    }

    /// Radii of all spheres (m).
    pub fn radii(&self) -> Vec<f64> {
        self.numbered(&self.particles.radius)
    }

    /// Masses of all spheres (kg).
    pub fn masses(&self) -> Vec<f64> {
        self.numbered(&self.particles.mass)
    }

    /// Forces of the contacts on all spheres (N), from the last
    /// [`Dem::compute_contacts`].
    pub fn forces(&self) -> Vec<Vec3> {
        self.numbered(self.storage_forces())
    }

    /// Torques of the contacts on all spheres (N m), likewise.
    pub fn torques(&self) -> Vec<Vec3> {
        self.numbered(self.storage_torques())
    }

    /// Values of all spheres, one each in storage order, by the user's
    /// numbers.
    ///
    /// # Errors
    /// [`DemError::Length`] when there is not one value per sphere.
    pub fn by_number<T: Copy>(&self, in_storage_order: &[T]) -> Result<Vec<T>, DemError> {
        require_length("in_storage_order", in_storage_order.len(), self.len())?;
        Ok(self.numbered(in_storage_order))
    }

    /// [`Dem::by_number`] for arrays of the right length.
    pub(crate) fn numbered<T: Copy>(&self, in_storage_order: &[T]) -> Vec<T> {
        self.place.iter().map(|&k| in_storage_order[k as usize]).collect()
    }

    /// Changes the velocity of a sphere (m/s).
    pub fn set_velocity(&mut self, number: usize, velocity: Vec3) {
        let k = self.storage_index(number);
        self.particles.velocity[k] = velocity;
    }

    /// Changes the angular velocity of a sphere (rad/s).
    pub fn set_spin(&mut self, number: usize, spin: Vec3) {
        let k = self.storage_index(number);
        self.particles.spin[k] = spin;
    }

    /// Adds a force (N) at the centre of a sphere, in the next
    /// [`Dem::integrate`] only: what is to act longer is added before each
    /// step. Forces added to one sphere sum up; they are no part of
    /// [`Dem::state`], and not in [`Dem::forces`].
    ///
    /// Local damping λ acts on the whole acceleration, that by added forces,
    /// gravity and fluid as well: a component that drives the motion counts
    /// times 1 − λ, one that brakes it times 1 + λ. A sphere pulled by F alone
    /// is accelerated by (1 − λ) F/m. In equilibrium damping takes nothing.
    ///
    /// ```
    /// # use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
    /// # use dempfv::{Aabb, Vec3};
    /// # let material = Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// # let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    /// # let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// # let spheres = Particles::new(vec![Vec3::repeat(0.5)], vec![0.1], 2600.0);
    /// # let mut dem = Dem::new(spheres, unit, material, walls, DemOptions::default())?;
    /// dem.compute_contacts()?;
    /// let drag = -0.1 * dem.velocity(0);
    /// dem.add_force(0, drag);
    /// dem.integrate(1e-4, None, None)?;
    /// # Ok::<(), dempfv::dem::DemError>(())
    /// ```
    pub fn add_force(&mut self, number: usize, force: Vec3) {
        let k = self.storage_index(number);
        self.external.add(k, self.particles.len(), force, Vec3::zeros());
    }

    /// Adds a torque (N m) to a sphere, likewise. Where
    /// [`DemOptions::rotation`](super::DemOptions::rotation) is off, no sphere
    /// turns.
    pub fn add_torque(&mut self, number: usize, torque: Vec3) {
        let k = self.storage_index(number);
        self.external.add(k, self.particles.len(), Vec3::zeros(), torque);
    }
}
