//! The spheres.

use serde::{Deserialize, Serialize};

use super::error::{DemError, require_length};
use super::hilbert::spatial_order;
use super::material::Material;
use crate::{Aabb, Vec3};

/// The spheres: one entry per sphere in every array.
///
/// What a user gives to [`Dem::new`](super::Dem::new) is in the user's order;
/// a [`Dem`](super::Dem) stores the spheres in an order of its own, in space,
/// and keeps the user's number of each in `id`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particles {
    /// The user's number of each sphere (its place in the user's list).
    pub id: Vec<u32>,
    /// Centre (m).
    pub position: Vec<Vec3>,
    /// Velocity (m/s), half a time step behind the position.
    pub velocity: Vec<Vec3>,
    /// Angular velocity (rad/s), half a time step behind the position.
    pub spin: Vec<Vec3>,
    /// Radius (m).
    pub radius: Vec<f64>,
    /// Mass (kg).
    pub mass: Vec<f64>,
    /// Index of each sphere's material in the list that the
    /// [`Dem`](super::Dem) is given; empty where all are of the first.
    pub material: Vec<u16>,
}

impl Particles {
    /// Spheres at rest, numbered in the order given, with the mass that their
    /// `radius` (m) and `density` (kg/m³) give. Lengths and values are checked
    /// when a [`super::Dem`] is made of them.
    pub fn new(position: Vec<Vec3>, radius: Vec<f64>, density: f64) -> Particles {
        let n = position.len();
        Particles {
            id: (0..n as u32).collect(),
            velocity: vec![Vec3::zeros(); n],
            spin: vec![Vec3::zeros(); n],
            mass: radius.iter().map(|r| density * volume(*r)).collect(),
            position,
            radius,
            material: vec![],
        }
    }

    /// The same with a material for each sphere, by its index in `materials`: masses follow from
    /// their densities.
    ///
    /// # Errors
    /// [`DemError::Length`] for arrays of different lengths, [`DemError::NoSuchMaterial`],
    /// [`DemError::Parameter`] for a material that none is.
    pub fn of_materials(
        position: Vec<Vec3>,
        radius: Vec<f64>,
        material: Vec<u16>,
        materials: &[Material],
    ) -> Result<Particles, DemError> {
        require_length("radius", radius.len(), position.len())?;
        require_length("material", material.len(), position.len())?;
        materials.iter().try_for_each(Material::check)?;
        let mut particles = Particles::new(position, radius, 1.0);
        particles.material = material;
        particles.check_materials(materials.len())?;
        for (mass, &m) in particles.mass.iter_mut().zip(&particles.material) {
            *mass *= materials[usize::from(m)].density;
        }
        Ok(particles)
    }

    /// Index of the material of the sphere at place `i`.
    pub(crate) fn material_of(&self, i: usize) -> u16 {
        self.material.get(i).copied().unwrap_or(0)
    }

    /// Checks that each sphere is of one of `count` materials.
    pub(super) fn check_materials(&self, count: usize) -> Result<(), DemError> {
        let (expected, found) = (self.len(), self.material.len());
        if !self.material.is_empty() && found != expected {
            return Err(DemError::Length { what: "material", found, expected });
        }
        match self.material.iter().position(|&m| usize::from(m) >= count) {
            Some(i) => {
                let (particle, index) = (self.id[i], self.material[i]);
                Err(DemError::NoSuchMaterial { particle, index, count })
            }
            None => Ok(()),
        }
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True when there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Volume of all spheres (m³), overlaps counted twice.
    pub fn solid_volume(&self) -> f64 {
        self.radius.iter().map(|&r| volume(r)).sum()
    }

    /// Puts the spheres in an order in which neighbours in space are near in
    /// memory (a Hilbert curve). Returns where each came from: entry k is the
    /// former index of the sphere that is now k-th. `id` follows.
    ///
    /// # Errors
    /// As [`Dem::new`](super::Dem::new) for spheres that no `Dem` can be made of.
    pub fn sort_spatially(&mut self) -> Result<Vec<u32>, DemError> {
        self.check()?;
        Ok(self.put_in_order())
    }

    /// [`Particles::sort_spatially`] for spheres that have been checked.
    pub(super) fn put_in_order(&mut self) -> Vec<u32> {
        let from = spatial_order(&self.position);
        permute(&mut self.id, &from);
        permute(&mut self.position, &from);
        permute(&mut self.velocity, &from);
        permute(&mut self.spin, &from);
        permute(&mut self.radius, &from);
        permute(&mut self.mass, &from);
        if !self.material.is_empty() {
            permute(&mut self.material, &from);
        }
        from
    }

    /// Goes on in the memory of arrays of as many spheres, which are of no use any more.
    pub(super) fn move_into(&mut self, memory: Particles) {
        let Particles { id, position, velocity, spin, radius, mass, material } = self;
        reuse(id, memory.id);
        for (values, memory) in
            [(position, memory.position), (velocity, memory.velocity), (spin, memory.spin)]
        {
            reuse(values, memory);
        }
        reuse(radius, memory.radius);
        reuse(mass, memory.mass);
        reuse(material, memory.material);
    }

    /// Checks lengths, signs and finiteness.
    pub(super) fn check(&self) -> Result<(), DemError> {
        let expected = self.len();
        for (what, found) in [
            ("id", self.id.len()),
            ("velocity", self.velocity.len()),
            ("spin", self.spin.len()),
            ("radius", self.radius.len()),
            ("mass", self.mass.len()),
        ] {
            require_length(what, found, expected)?;
        }
        let mut seen = vec![false; expected];
        for &number in &self.id {
            match seen.get_mut(number as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(DemError::Numbers { number, count: expected }),
            }
        }
        for i in 0..expected {
            let particle = self.id[i];
            for (quantity, value) in [("radius", self.radius[i]), ("mass", self.mass[i])] {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(DemError::BadParticle { particle, quantity, value });
                }
            }
            for (quantity, v) in [
                ("position", self.position[i]),
                ("velocity", self.velocity[i]),
                ("spin", self.spin[i]),
            ] {
                if !v.iter().all(|c| c.is_finite()) {
                    return Err(DemError::NotFinite { particle, quantity });
                }
            }
        }
        Ok(())
    }

    /// Refuses a box whose coordinates have no digits left for the contacts of the smallest
    /// sphere.
    pub(super) fn check_digits(&self, box_: &Aabb) -> Result<(), DemError> {
        let spacing = box_.spacing();
        match self.radius.iter().position(|r| spacing > SPACING_PER_RADIUS * r) {
            None => Ok(()),
            Some(i) => {
                let (particle, radius) = (self.id[i], self.radius[i]);
                Err(DemError::LostDigits { particle, radius, spacing })
            }
        }
    }
}

/// Overlaps are a ten thousandth of a radius and less, of which this leaves three digits.
const SPACING_PER_RADIUS: f64 = 1e-7;

/// Volume of a sphere (m³).
fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
}

/// Puts values into memory that has as much room as they need.
pub(super) fn reuse<T: Copy>(values: &mut Vec<T>, mut memory: Vec<T>) {
    memory.copy_from_slice(values);
    *values = memory;
}

fn permute<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
    *values = from.iter().map(|&i| values[i as usize]).collect();
}
