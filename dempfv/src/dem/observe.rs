//! What can be measured: energy, momentum, stress, contact numbers, and the
//! largest stable time step.

use super::contacts::{Contact, Partner};
use super::system::Dem;
use crate::{Vec3, WallId};

/// A symmetric or full 3 × 3 tensor.
type Tensor = nalgebra::Matrix3<f64>;

impl Dem {
    /// Kinetic energy of translation and rotation (J), of the velocities half
    /// a time step before the positions.
    pub fn kinetic_energy(&self) -> f64 {
        let p = &self.particles;
        (0..p.len())
            .map(|i| {
                let inertia = 0.4 * p.mass[i] * p.radius[i].powi(2);
                0.5 * (p.mass[i] * p.velocity[i].norm_squared()
                    + inertia * p.spin[i].norm_squared())
            })
            .sum()
    }

    /// Elastic energy of all contacts (J): F_n² / 2k_n + F_s² / 2k_s.
    pub fn elastic_energy(&self) -> f64 {
        self.contacts()
            .map(|c| {
                let shear = c.shear.norm_squared();
                let tangential =
                    if shear > 0.0 { shear / (self.law.ratio * c.stiffness) } else { 0.0 };
                0.5 * (c.normal_force.powi(2) / c.stiffness + tangential)
            })
            .sum()
    }

    /// Momentum of the spheres (kg m/s).
    pub fn momentum(&self) -> Vec3 {
        self.particles.mass.iter().zip(&self.particles.velocity).map(|(&m, v)| m * v).sum()
    }

    /// Mean number of contacts per sphere, those with walls included: a
    /// contact of two spheres counts for both.
    pub fn coordination_number(&self) -> f64 {
        let ends = 2 * self.sphere_contact_count() + self.wall_contact_count();
        ends as f64 / self.particles.len().max(1) as f64
    }

    /// Share of the box that no sphere fills; overlaps count twice as solid.
    pub fn porosity(&self) -> f64 {
        1.0 - self.particles.solid_volume() / self.box_().volume()
    }

    /// Mean force left on a sphere over mean contact force: how far the
    /// packing is from rest. Counts gravity and, where given, the fluid's
    /// force on each sphere (N). Zero without contacts.
    pub fn unbalanced_force(&self, fluid_force: Option<&[Vec3]>) -> f64 {
        let (sum, count) =
            self.contacts().fold((0.0, 0usize), |(s, n), c| (s + c.force().norm(), n + 1));
        if count == 0 || sum == 0.0 {
            return 0.0;
        }
        let gravity = self.options.gravity.unwrap_or_default();
        let fluid = fluid_force.unwrap_or(&[]);
        let forces = self.forces().iter().zip(&self.particles.mass).enumerate();
        let left: f64 = forces
            .map(|(i, (f, &m))| {
                (f + m * gravity + fluid.get(i).copied().unwrap_or_default()).norm()
            })
            .sum();
        (left / self.particles.len() as f64) / (sum / count as f64)
    }

    /// Stress of the contacts on a wall (Pa, positive in compression), from
    /// the last [`Dem::compute_contacts`].
    pub fn wall_stress(&self, wall: WallId) -> f64 {
        let force = self.wall_sums[wall.index()].force[wall.axis()];
        -wall.inward() * force / self.box_().wall_area(wall)
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
        sum / self.box_().volume()
    }

    /// The largest time step (s) at which the contacts are stable, times
    /// `safety`: √2 min over spheres and axes of √(m/k) and √(I/k_r), with k
    /// the sum over the sphere's contacts of the diagonal of
    /// k_s 1 + (k_n − k_s) n⊗n, and k_r that of k_s r² (1 − n⊗n). `None`
    /// without contacts. One pass over the contacts; allocates in the first
    /// call only.
    pub fn contact_time_step(&mut self, safety: f64) -> Option<f64> {
        let mut sums = std::mem::take(&mut self.stiffness);
        sums.resize(self.particles.len(), [Vec3::zeros(); 2]);
        sums.fill([Vec3::zeros(); 2]);
        for c in self.contacts() {
            self.add_stiffness(&mut sums[c.i as usize], &c);
            if let Partner::Sphere(j) = c.partner {
                self.add_stiffness(&mut sums[j as usize], &c);
            }
        }
        let p = &self.particles;
        // Largest k/m over spheres and axes.
        let mut fastest = 0.0f64;
        for (i, [k, k_r]) in sums.iter().enumerate() {
            fastest = fastest.max(k.max() / p.mass[i]);
            if self.options.rotation {
                // I = 2/5 m r², and both k_r and I have the factor r².
                fastest = fastest.max(k_r.max() / (0.4 * p.mass[i]));
            }
        }
        self.stiffness = sums;
        (fastest > 0.0).then(|| safety * (2.0 / fastest).sqrt())
    }

    /// The time step (s) that holds until contacts form anew, times `safety`:
    /// [`Dem::contact_time_step`], or that of the lightest sphere with a
    /// single contact where it is less: a sphere that touches nothing may
    /// touch something before the next look.
    pub fn safe_time_step(&mut self, safety: f64) -> f64 {
        let p = self.particles();
        let frequency2 = (p.radius.iter().zip(&p.mass))
            .map(|(&r, m)| self.law.pair_stiffness(r, r) / m)
            .fold(0.0, f64::max);
        let lone = safety * (2.0 / frequency2).sqrt();
        self.contact_time_step(safety).map_or(lone, |dt| dt.min(lone))
    }

    /// Adds a contact's share to the sums of one of its spheres: the diagonal
    /// of the stiffness, and that of the rotational stiffness over r².
    fn add_stiffness(&self, [k, k_r]: &mut [Vec3; 2], c: &Contact) {
        let sliding = match c.partner {
            Partner::Sphere(_) => self.law.friction > 0.0,
            Partner::Wall(_) => self.law.wall_friction > 0.0,
        };
        let k_s = if sliding { self.law.ratio * c.stiffness } else { 0.0 };
        let n2 = c.normal.component_mul(&c.normal);
        *k += (c.stiffness - k_s) * n2 + Vec3::repeat(k_s);
        *k_r += k_s * (Vec3::repeat(1.0) - n2);
    }
}
