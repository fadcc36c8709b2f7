//! What can be measured: energy, momentum, stress, contact numbers.

use super::clump::Clump;
use super::error::{DemError, require_length};
use super::system::Dem;
use crate::{Tensor, Vec3, WallId};

impl Dem {
    /// Kinetic energy of translation and rotation (J), of the velocities half
    /// a time step before the positions; in a periodic cell relative to its mean field.
    pub fn kinetic_energy(&self) -> f64 {
        let p = &self.particles;
        let spheres = self.single_places().map(|i| {
            let inertia = 0.4 * p.mass[i] * p.radius[i].powi(2);
            0.5 * (p.mass[i] * p.velocity[i].norm_squared() + inertia * p.spin[i].norm_squared())
        });
        let of_clump = |clump: &Clump| clump.kinetic_energy().iter().sum();
        spheres.chain(self.clumps().map(of_clump)).sum()
    }

    /// Places in storage of the spheres that are in no clump.
    fn single_places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.particles.len()).filter(|&i| self.held.clumps.of(i).is_none())
    }

    /// Kinetic energy of translation (J), likewise: ½ m v².
    pub fn translational_energy(&self) -> f64 {
        let p = &self.particles;
        let of_sphere = |i: usize| 0.5 * (p.mass[i] * p.velocity[i].norm_squared());
        let clumps = self.clumps().map(|clump| clump.kinetic_energy()[0]);
        self.single_places().map(of_sphere).chain(clumps).sum()
    }

    /// Kinetic energy of rotation (J), likewise: ½ I ω² with I = 2/5 m r², and ½ L·ω of a clump.
    pub fn rotational_energy(&self) -> f64 {
        let p = &self.particles;
        let of_sphere =
            |i: usize| 0.5 * (0.4 * p.mass[i] * p.radius[i].powi(2) * p.spin[i].norm_squared());
        let clumps = self.clumps().map(|clump| clump.kinetic_energy()[1]);
        self.single_places().map(of_sphere).chain(clumps).sum()
    }

    /// Elastic energy of all contacts (J), by the contact law; of the linear
    /// one F_n² / 2k_n + F_s² / 2k_s.
    pub fn elastic_energy(&self) -> f64 {
        self.places().map(|c| self.law.elastic_energy(&c.touch, c.history)).sum()
    }

    /// Momentum of the spheres (kg m/s).
    pub fn momentum(&self) -> Vec3 {
        let of_sphere = |i: usize| self.particles.mass[i] * self.particles.velocity[i];
        let clumps = self.clumps().map(|clump| clump.mass * clump.velocity);
        self.single_places().map(of_sphere).chain(clumps).sum()
    }

    /// Mean number of contacts per sphere, those with walls included: a
    /// contact of two spheres counts for both.
    pub fn coordination_number(&self) -> f64 {
        let ends = 2 * self.sphere_contact_count() + self.wall_contact_count();
        ends as f64 / self.particles.len().max(1) as f64
    }

    /// Volume of the box, or of the periodic cell (m³).
    pub fn volume(&self) -> f64 {
        self.cell.as_ref().map_or_else(|| self.box_().volume(), |cell| cell.cell().volume())
    }

    /// Share of the box, or of the periodic cell, that no sphere fills; overlaps count twice as
    /// solid, but for those within clumps.
    pub fn porosity(&self) -> f64 {
        let excess = self.held.clumps.excess_volume(&self.particles.radius);
        1.0 - (self.particles.solid_volume() + excess) / self.volume()
    }

    /// Mean force left on a sphere over mean contact force: how far the
    /// packing is from rest. Counts gravity and, where given, the fluid's
    /// force on each sphere (N), in storage order; not what
    /// [`Dem::add_force`] adds. A clump counts once, and what is given its motion
    /// ([`Dem::prescribe`]) does not. Zero without contacts.
    ///
    /// # Errors
    /// [`DemError::Length`] for a fluid force that is not one per sphere, and
    /// [`DemError::NotFinite`].
    pub fn unbalanced_force(&self, fluid_force: Option<&[Vec3]>) -> Result<f64, DemError> {
        if let Some(force) = fluid_force {
            require_length("fluid_force", force.len(), self.len())?;
            if let Some(k) = force.iter().position(|f| !f.iter().all(|c| c.is_finite())) {
                let particle = self.particles.id[k];
                return Err(DemError::NotFinite { particle, quantity: "fluid_force" });
            }
        }
        Ok(self.force_ratio(fluid_force))
    }

    /// [`Dem::unbalanced_force`] for a fluid force that is known to be right.
    pub(crate) fn force_ratio(&self, fluid_force: Option<&[Vec3]>) -> f64 {
        let (sum, count) =
            self.contacts().fold((0.0, 0usize), |(s, n), c| (s + c.force().norm(), n + 1));
        if count == 0 || sum == 0.0 {
            return 0.0;
        }
        let gravity = self.options.gravity.unwrap_or_default();
        let fluid = fluid_force.unwrap_or(&[]);
        let force = self.storage_forces();
        let loaded = |i: usize| force[i] + fluid.get(i).copied().unwrap_or_default();
        let of_sphere = |i: usize| {
            (force[i]
                + self.particles.mass[i] * gravity
                + fluid.get(i).copied().unwrap_or_default())
            .norm()
        };
        let free = self.single_places().filter(|&i| !self.held.is_driven(i));
        let clumps = self.held.clumps.net_forces(loaded, gravity).map(|f| f.norm());
        let (left, bodies) =
            free.map(of_sphere).chain(clumps).fold((0.0, 0usize), |(s, n), f| (s + f, n + 1));
        (left / bodies.max(1) as f64) / (sum / count as f64)
    }

    /// Stress of the contacts on a wall (Pa, positive in compression), from
    /// the last [`Dem::compute_contacts`]; 0 in a periodic cell, which has none.
    pub fn wall_stress(&self, wall: WallId) -> f64 {
        let force = self.wall_sums[wall].force[wall.axis()];
        -wall.inward() * force / self.box_().wall_area(wall)
    }

    /// Mean stress of the contacts (Pa): of the six walls, or in a periodic cell of the three
    /// normal stresses.
    pub fn mean_stress(&self) -> f64 {
        match self.cell {
            None => self.mean_wall_stress(),
            Some(_) => self.stress_in_cell().trace() / 3.0,
        }
    }

    /// Mean of the six wall stresses (Pa).
    pub fn mean_wall_stress(&self) -> f64 {
        WallId::ALL.map(|w| self.wall_stress(w)).iter().sum::<f64>() / 6.0
    }

    /// Mean stress tensor of the packing (Pa, positive in compression):
    /// σ = Σ F ⊗ l / V over the contacts, F the force on the partner and l
    /// the way to it.
    pub fn stress(&self) -> Tensor {
        let sum: Tensor =
            self.contacts().map(|c| c.force() * (c.distance * c.normal).transpose()).sum();
        sum / self.volume()
    }

    /// Stress tensor of the contacts in a periodic cell, as the last [`Dem::compute_contacts`]
    /// found it: that of [`Dem::stress`], with what velocities add to the forces, and without
    /// another look at the contacts. Zero between walls.
    pub fn stress_in_cell(&self) -> Tensor {
        Tensor::from_row_slice(&self.cell_sum.moment) / self.volume()
    }

    /// Stress by the motion of the spheres (Pa, positive in compression): Σ m c ⊗ c / V, with
    /// velocities c relative to the mean field of a periodic cell, half a time step before the
    /// positions. What a cell's servo holds is the sum of this and [`Dem::stress_in_cell`].
    pub fn kinetic_stress(&self) -> Tensor {
        let p = &self.particles;
        let sum: Tensor = p.mass.iter().zip(&p.velocity).map(|(&m, c)| m * c * c.transpose()).sum();
        sum / self.volume()
    }
}
