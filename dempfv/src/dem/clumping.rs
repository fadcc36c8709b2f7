//! Spheres are bound to rigid clumps.

use super::clump::Clump;
use super::error::DemError;
use super::held::Held;
use super::system::Dem;
use crate::Vec3;

impl Dem {
    /// Makes a rigid body of the spheres of each group, by their numbers, where they are and as they move.
    /// They no longer touch each other, and go on with the momentum that they have. Mass and inertia are
    /// those of their union, what two of them share counted once, of the mean of their densities. Energy
    /// that is tracked ([`Dem::track_energy`]) is tracked anew.
    ///
    /// The mass of a member ([`Dem::mass`]) is from then on its share of the union's, such that a time
    /// step that is stable for the members alone is so for the clump.
    ///
    /// ```
    /// use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
    /// use dempfv::{Aabb, Vec3};
    ///
    /// let material = Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    /// let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// let ends = vec![Vec3::new(0.45, 0.5, 0.5), Vec3::new(0.55, 0.5, 0.5)];
    /// let spheres = Particles::new(ends, vec![0.1, 0.1], material.density);
    /// let mut dem = Dem::new(spheres, unit, material, walls, DemOptions::default())?;
    /// dem.bind(&[vec![0, 1]])?;
    /// dem.set_clump_motion(0, Vec3::zeros(), Vec3::new(0.0, 0.0, 3.0))?;
    /// dem.step(1e-3)?;
    /// assert_eq!(dem.contacts().count(), 0);
    /// assert!((dem.velocity(1).y - 0.15).abs() < 1e-5);
    /// # Ok::<(), dempfv::dem::DemError>(())
    /// ```
    ///
    /// # Errors
    /// [`DemError::Clump`] for a group of fewer than two spheres, with two of one centre or three that
    /// overlap each other, for a sphere in two clumps or with a motion of its own, and where spheres do
    /// not rotate; [`DemError::NoSuchSphere`]; [`DemError::InCell`] in a periodic cell. As
    /// [`Dem::compute_contacts`].
    pub fn bind(&mut self, groups: &[Vec<u32>]) -> Result<(), DemError> {
        if self.cell.is_some() {
            return Err(DemError::InCell { what: "a clump", remedy: "put walls around" });
        }
        let bodies = self.bodies_of(groups)?;
        for (body, members) in bodies.iter().zip(groups) {
            let places: Vec<usize> =
                members.iter().map(|&n| self.storage_index(n as usize)).collect();
            let share = body.share(&self.particles, &places);
            places.into_iter().for_each(|k| self.particles.mass[k] *= share);
        }
        let Held { motions, clumps, .. } = std::mem::take(&mut self.held);
        let all = clumps.into_bodies().into_iter().chain(bodies).collect();
        self.held = Held::new(motions, all, &self.place);
        self.rebuild()?;
        if self.tracks_energy() {
            self.track_energy(true);
        }
        Ok(())
    }

    /// The bodies that these groups make.
    fn bodies_of(&self, groups: &[Vec<u32>]) -> Result<Vec<Clump>, DemError> {
        let first = self.clumps().count();
        let mut taken = vec![false; self.len()];
        let mut bodies = Vec::with_capacity(groups.len());
        for (clump, members) in (first..).zip(groups) {
            let wrong = |reason| DemError::Clump { clump, reason };
            self.check_numbers(members)?;
            if !self.options.rotation {
                return Err(wrong("cannot be, where spheres do not rotate; let them"));
            }
            for &number in members {
                let again = std::mem::replace(&mut taken[number as usize], true);
                if again || self.clump_of(number as usize).is_some() {
                    return Err(wrong("has a sphere that is in a clump already; name it once"));
                }
                if self.held.motions.of(number).is_some() {
                    return Err(wrong(
                        "has a sphere whose motion is given; give the clump the motion",
                    ));
                }
            }
            let places: Vec<usize> =
                members.iter().map(|&number| self.storage_index(number as usize)).collect();
            bodies.push(Clump::bind(members, &places, &self.particles).map_err(wrong)?);
        }
        Ok(bodies)
    }

    /// The clumps, in the order in which they were bound.
    pub fn clumps(&self) -> impl Iterator<Item = &Clump> {
        self.held.clumps.each()
    }

    /// The place in [`Dem::clumps`] of the clump of the sphere with this number; `None` of a single
    /// sphere.
    ///
    /// # Panics
    /// Where no sphere has the number.
    pub fn clump_of(&self, number: usize) -> Option<usize> {
        self.held.clumps.of(self.storage_index(number)).map(|index| index as usize)
    }

    /// Gives a clump, by its place in [`Dem::clumps`], another velocity of its centre (m/s) and another
    /// angular velocity (rad/s). What is set for a member alone ([`Dem::set_velocity`]) is lost in the
    /// next step.
    ///
    /// # Errors
    /// [`DemError::Clump`] where there is none, or for numbers that are not finite.
    pub fn set_clump_motion(
        &mut self,
        clump: usize,
        velocity: Vec3,
        spin: Vec3,
    ) -> Result<(), DemError> {
        if !velocity.iter().chain(spin.iter()).all(|x| x.is_finite()) {
            return Err(DemError::Clump { clump, reason: "is given a motion that is not finite" });
        }
        let Dem { held, particles, place, .. } = self;
        let Some(body) = held.clumps.get_mut(clump) else {
            return Err(DemError::Clump { clump, reason: "is none; count from 0" });
        };
        body.velocity = velocity;
        body.set_spin(&spin);
        for (&number, at) in body.members.iter().zip(body.places.iter()) {
            let k = place[number as usize] as usize;
            particles.velocity[k] = velocity + spin.cross(&body.orientation.transform_vector(at));
            particles.spin[k] = spin;
        }
        Ok(())
    }
}
