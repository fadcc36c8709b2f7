//! The largest stable time step.

use super::compiled::{Surfaces, Touch};
use super::contacts::{Other, Place};
use super::error::DemError;
use super::law::TwoSpheres;
use super::system::Dem;
use crate::Vec3;

/// Overlap, as a share of the radius, at which the stiffness of a contact that
/// does not exist yet is taken; the linear law's does not depend on it.
const EXPECTED_OVERLAP_SHARE: f64 = 0.01;

impl Dem {
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
        for place in self.places() {
            self.add_stiffness(&mut sums[place.i], &place);
            if let Other::Sphere(j) = place.other {
                self.add_stiffness(&mut sums[j], &place);
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

    /// [`Dem::contact_time_step`], or that of the lightest sphere with a
    /// single contact where it is less (s), times `safety`; infinite where
    /// there is no sphere.
    ///
    /// It knows the contacts of the last [`Dem::compute_contacts`] only, of
    /// which a new `Dem` has none. A sphere that comes to be held by several
    /// others needs a shorter step: ask again as contacts form, or let
    /// [`Dem::step_auto`] do so. A step taken once, before the packing is
    /// dense, may make an unstable run that no error reports.
    pub fn safe_time_step(&mut self, safety: f64) -> f64 {
        let p = &self.particles;
        let frequency2 = (p.radius.iter().zip(&p.mass))
            .map(|(&r, m)| {
                let surfaces = Surfaces::Spheres(TwoSpheres(r, r));
                let touch = Touch { surfaces, overlap: EXPECTED_OVERLAP_SHARE * r };
                self.law.stiffness(&touch).normal / m
            })
            .fold(0.0, f64::max);
        let lone = safety * (2.0 / frequency2).sqrt();
        self.contact_time_step(safety).map_or(lone, |dt| dt.min(lone))
    }

    /// One dry step of [`Dem::safe_time_step`] at the contacts that it finds:
    /// stable from the first step on, while contacts form. Returns the time
    /// step (s). Costs one more look at the contacts than [`Dem::step`].
    ///
    /// ```
    /// # use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
    /// # use dempfv::{Aabb, Vec3};
    /// # let material = Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// # let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    /// # let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// # let spheres = Particles::new(vec![Vec3::repeat(0.5)], vec![0.1], 2600.0);
    /// # let mut dem = Dem::new(spheres, unit, material, walls, DemOptions::default())?;
    /// let mut time = 0.0;
    /// while time < 0.01 {
    ///     time += dem.step_auto(0.5)?;
    /// }
    /// # Ok::<(), dempfv::dem::DemError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Dem::step`]; [`DemError::Parameter`] where `safety` is not
    /// positive or there is no sphere to take a time step from.
    pub fn step_auto(&mut self, safety: f64) -> Result<f64, DemError> {
        self.compute_contacts()?;
        let dt = self.safe_time_step(safety);
        self.integrate(dt, None, None)?;
        Ok(dt)
    }

    /// Adds a contact's share to the sums of one of its spheres: the diagonal
    /// of the stiffness, and that of the rotational stiffness over r².
    fn add_stiffness(&self, [k, k_r]: &mut [Vec3; 2], place: &Place<'_>) {
        let stiffness = self.law.stiffness(&place.touch);
        let k_s = stiffness.shear;
        let n2 = place.normal.component_mul(&place.normal);
        *k += (stiffness.normal - k_s) * n2 + Vec3::repeat(k_s);
        *k_r += k_s * (Vec3::repeat(1.0) - n2);
    }
}
