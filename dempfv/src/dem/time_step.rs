//! The largest stable time step.

use std::f64::consts::PI;

use super::cell_pass::CellPass;
use super::contacts::Other;
use super::error::DemError;
use super::material::positive;
use super::stiffness_pass::StiffnessInput;
use super::system::Dem;
use crate::Vec3;

/// Approach of two surfaces between two looks, as a share of the smallest radius.
const LOOK_SHARE: f64 = 0.005;
/// Most steps between two looks at an automatic time step.
const MOST_STEPS_BETWEEN_LOOKS: u64 = 50;
/// Steps that a collision takes at least, where nothing damps it.
const STEPS_PER_COLLISION: f64 = 16.0;

/// A share that makes sense; of others nothing may pass for a time step.
fn share(safety: f64) -> f64 {
    if safety > 0.0 { safety } else { f64::NAN }
}

impl Dem {
    /// The largest time step (s) at which the contacts are stable, times
    /// `safety`: √2 min over spheres of √(m/k) and √(I/k_r), with k
    /// the largest eigenvalue of the sum over the sphere's contacts of
    /// k_s 1 + (k_n − k_s) n⊗n, and k_r that of k_s r² (1 − n⊗n). `None`
    /// without contacts; not a number where `safety` is not positive. One pass over the
    /// contacts; allocates in the first call only.
    pub fn contact_time_step(&mut self, safety: f64) -> Option<f64> {
        let pass = self.cell.as_ref().map(CellPass::new);
        let p = &self.particles;
        let input = StiffnessInput {
            list: &self.list,
            centre: &self.centre,
            mass: &p.mass,
            material: &p.material,
            walls: &self.walls,
            cell: pass.as_ref(),
            rotation: self.options.rotation,
        };
        let fastest = self.law.fastest_held(input, &mut self.stiffness);
        (fastest > 0.0).then(|| share(safety) * (2.0 / fastest).sqrt())
    }

    /// [`Dem::contact_time_step`], or that of the lightest sphere with a
    /// single contact where it is less (s), times `safety`; infinite where
    /// there is no sphere, and not a number where `safety` is not positive.
    ///
    /// It knows the contacts of the last [`Dem::compute_contacts`] only, of
    /// which a new `Dem` has none. A sphere that comes to be held by several
    /// others needs a shorter step: ask again as contacts form, or let
    /// [`Dem::step_auto`] do so. A step taken once, before the packing is
    /// dense, may make an unstable run that no error reports.
    pub fn safe_time_step(&mut self, safety: f64) -> f64 {
        let lone = share(safety) * (2.0 / self.lone_frequency2()).sqrt();
        self.contact_time_step(safety).map_or(lone, |dt| dt.min(lone))
    }

    /// The largest k_n / m (1/s²) of a sphere in one contact with another of its size, of any
    /// material, struck as fast as any may be.
    fn lone_frequency2(&self) -> f64 {
        let impact2 = if self.law.stiffens() { self.fastest_impact2() } else { 0.0 };
        self.law.fastest_lone(&self.particles, impact2)
    }

    /// One dry step of [`Dem::safe_time_step`] at the contacts that it finds, without damping no
    /// longer than [`Dem::collision_time_step`]:
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
        positive("safety", safety)?;
        self.compute_contacts()?;
        let dt = match self.options.damping {
            0.0 => self.safe_time_step(safety).min(self.collision_time_step()),
            _ => self.safe_time_step(safety),
        };
        self.integrate(dt, None, None)?;
        Ok(dt)
    }

    /// Steps of length `dt` (s) in which no two surfaces come nearer by more than half a percent of
    /// the smallest radius: contacts that begin are slight when the time step is looked at next.
    /// None where `dt` is not positive.
    pub fn steps_between_looks(&self, dt: f64) -> u64 {
        let smallest = self.particles.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let steps = LOOK_SHARE * smallest / (self.fastest_approach() * dt);
        // As a cast has it, too many are the most and what is no number is none.
        (steps as u64).min(MOST_STEPS_BETWEEN_LOOKS)
    }

    /// The most that two surfaces can come towards each other (m/s).
    fn fastest_approach(&self) -> f64 {
        let all = self.particles.velocity.iter().map(Vec3::norm_squared);
        let spheres = all.fold(0.0, f64::max).sqrt();
        let walls = self.walls.values().map(|w| w.velocity.abs()).fold(0.0, f64::max);
        // Across the largest pair the mean field of a cell brings them together at this speed.
        let largest = || self.particles.radius.iter().copied().fold(0.0, f64::max);
        let field = self.cell().map_or(0.0, |c| c.velocity_gradient().norm() * 2.0 * largest());
        spheres + spheres.max(walls) + field
    }

    /// Square of the fastest impact (m²/s²): of the motion there is, and of what the contacts hold. A
    /// collision does not change it, so that its time step stays.
    fn fastest_impact2(&self) -> f64 {
        let mass = |i: usize| self.particles.mass[i];
        let held = self.places().map(|place| {
            let inverse_mass = match place.other {
                Other::Sphere(j) => 1.0 / mass(place.i) + 1.0 / mass(j),
                Other::Wall(_) => 1.0 / mass(place.i),
            };
            2.0 * self.law.elastic_energy(&place.touch, place.history) * inverse_mass
        });
        held.fold(0.0, f64::max) + self.fastest_approach().powi(2)
    }

    /// The longest time step (s) at which a collision of two spheres of this packing, which lasts
    /// π √(m / 2 k_n) for two of equal mass, takes 16 steps. Without damping
    /// the contacts gain or lose energy where they begin and end between two steps: by 3e-7 of it
    /// on average and 1e-3 at most in each collision, and by the sixth power of the step. Infinite
    /// where there is no sphere.
    pub fn collision_time_step(&self) -> f64 {
        let shortest = PI / (2.0 * self.lone_frequency2()).sqrt();
        shortest / STEPS_PER_COLLISION
    }
}
