//! Rigid bodies of spheres: clumps.

use nalgebra::{Rotation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use super::clump_shape::{Ball, union};
use super::error::DemError;
use super::material::{finite, positive};
use super::particles::Particles;
use crate::{Effect, EffectKey, Family};
use crate::{Tensor, Vec3};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "rigid clumps",
    family: Family::Bodies,
    equation: "dP/dt = Σ F, dL/dt = Σ (M + r × F), L kept as it is while the body turns by ω = I⁻¹ L about its \
               principal axes in turns; mass and inertia of the union of the members, of which no three overlap",
    source: "A. Dullweber, B. Leimkuhler, R. McLachlan: J. Chem. Phys. 107 (1997); the union: spheres less the \
             lenses that two share",
    keys: &[EffectKey {
        key: "clump in [particles]",
        unit: "radius of the sphere",
        default: "single spheres",
    }],
    needs: "rotation",
    test: "dempfv/tests/dem_clumps.rs",
};

/// A rigid body of spheres, by the user's numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clump {
    /// The user's numbers of its spheres.
    pub members: Vec<u32>,
    /// Places of their centres in the frame of the principal axes (m).
    pub(super) places: Vec<Vec3>,
    /// Mass (kg).
    pub mass: f64,
    /// Principal moments of inertia (kg m²).
    pub moments: Vec3,
    /// Volume, what two spheres share counted once (m³).
    pub volume: f64,
    /// Centre of mass (m).
    pub centre: Vec3,
    /// Velocity of the centre (m/s), half a time step behind it.
    pub velocity: Vec3,
    /// From the frame of the principal axes to that of the coordinates.
    pub orientation: UnitQuaternion<f64>,
    /// Angular momentum about the centre (kg m²/s), half a time step behind it.
    pub angular_momentum: Vec3,
}

impl Clump {
    /// The body that these members make, of spheres that move as they do.
    pub(super) fn bind(
        members: &[u32],
        places: &[usize],
        particles: &Particles,
    ) -> Result<Clump, &'static str> {
        let p = particles;
        let ball =
            |&k: &usize| Ball { centre: p.position[k], radius: p.radius[k], mass: p.mass[k] };
        let balls: Vec<Ball> = places.iter().map(ball).collect();
        let coincide = |(i, a): (usize, &Ball)| balls[..i].iter().any(|b| a.centre == b.centre);
        if balls.len() < 2 {
            return Err("has fewer than two spheres; leave single spheres as they are");
        }
        if balls.iter().enumerate().any(coincide) {
            return Err("has two spheres with one centre; keep one of them");
        }
        let shape = union(&balls)
            .ok_or("has three spheres that overlap each other; take some of which no three do")?;
        let eigen = shape.inertia.symmetric_eigen();
        let mut axes = eigen.eigenvectors;
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        let orientation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let moments = eigen.eigenvalues;
        let sound = shape.mass > 0.0 && moments.iter().all(|m| m.is_normal() && *m > 0.0);
        if !sound {
            return Err("has a mass or an inertia that double precision cannot hold");
        }
        // The momenta of the spheres, by the share of their masses that the union has.
        let total: f64 = balls.iter().map(|b| b.mass).sum();
        let sum = |of: &dyn Fn(usize) -> Vec3| places.iter().map(|&k| of(k)).sum::<Vec3>() / total;
        let velocity = sum(&|k| p.mass[k] * p.velocity[k]);
        let spin = |k: usize| 0.4 * p.mass[k] * p.radius[k].powi(2) * p.spin[k];
        let orbit = |k: usize| {
            p.mass[k] * (p.position[k] - shape.centre).cross(&(p.velocity[k] - velocity))
        };
        let from_centre =
            |b: &Ball| orientation.inverse_transform_vector(&(b.centre - shape.centre));
        Ok(Clump {
            members: members.to_vec(),
            places: balls.iter().map(from_centre).collect(),
            mass: shape.mass,
            moments,
            volume: shape.volume,
            centre: shape.centre,
            velocity,
            orientation,
            angular_momentum: shape.mass * sum(&|k| orbit(k) + spin(k)),
        })
    }

    /// Refuses what no step leaves.
    pub(super) fn check(&self) -> Result<(), DemError> {
        positive("mass of a clump", self.mass)?;
        positive("volume of a clump", self.volume)?;
        self.moments.iter().try_for_each(|&m| positive("moment of inertia of a clump", m))?;
        let vectors = [self.centre, self.velocity, self.angular_momentum];
        let numbers = vectors.iter().chain(&self.places).flat_map(|v| v.iter());
        let turn = self.orientation.coords.iter();
        numbers.chain(turn).try_for_each(|&x| finite("state of a clump", x))?;
        let (found, expected) = (self.places.len(), self.members.len());
        if found == expected && expected > 1 {
            return Ok(());
        }
        Err(DemError::Length { what: "places of a clump", found, expected })
    }

    /// Angular velocity (rad/s).
    pub fn spin(&self) -> Vec3 {
        self.per_moment(&self.angular_momentum)
    }

    /// I⁻¹ times a vector.
    pub(super) fn per_moment(&self, v: &Vec3) -> Vec3 {
        let own = self.orientation.inverse_transform_vector(v).component_div(&self.moments);
        self.orientation.transform_vector(&own)
    }

    /// I times a vector.
    fn times_moment(&self, v: &Vec3) -> Vec3 {
        let own = self.orientation.inverse_transform_vector(v).component_mul(&self.moments);
        self.orientation.transform_vector(&own)
    }

    /// Gives it another mass, with the same shape.
    pub(crate) fn scale_mass(&mut self, factor: f64) {
        self.mass *= factor;
        self.moments *= factor;
        self.angular_momentum *= factor;
    }

    /// Makes it larger by a factor; its spin stays.
    pub(super) fn scale(&mut self, factor: f64) {
        self.places.iter_mut().for_each(|place| *place *= factor);
        self.mass *= factor.powi(3);
        self.volume *= factor.powi(3);
        self.moments *= factor.powi(5);
        self.angular_momentum *= factor.powi(5);
    }

    /// Gives it another angular velocity (rad/s).
    pub(super) fn set_spin(&mut self, spin: &Vec3) {
        self.angular_momentum = self.times_moment(spin);
    }

    /// Kinetic energy of the centre and of the rotation (J).
    pub fn kinetic_energy(&self) -> [f64; 2] {
        let rotation = 0.5 * self.angular_momentum.dot(&self.spin());
        [0.5 * self.mass * self.velocity.norm_squared(), rotation]
    }

    /// The least that mass and inertia of the union are of those of its members as spheres: by so much
    /// faster than they may it swing.
    pub(super) fn share(&self, particles: &Particles, places: &[usize]) -> f64 {
        let (mut mass, mut inertia) = (0.0, Tensor::zeros());
        for (&k, at) in places.iter().zip(&self.places) {
            let (m, r) = (particles.mass[k], particles.radius[k]);
            let steiner = at.norm_squared() * Tensor::identity() - at * at.transpose();
            mass += m;
            inertia += m * (0.4 * r * r * Tensor::identity() + steiner);
        }
        // Along the axes in which the union's inertia is 1.
        let scale = self.moments.map(|m| 1.0 / m.sqrt());
        let scaled = Tensor::from_diagonal(&scale) * inertia * Tensor::from_diagonal(&scale);
        let most = scaled.symmetric_eigenvalues().max();
        (self.mass / mass).min(1.0 / most).min(1.0)
    }
}
