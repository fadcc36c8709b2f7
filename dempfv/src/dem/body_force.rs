//! Forces of a user's own on the spheres, as an effect of the simulation.

use rayon::prelude::*;

use super::error::DemError;
use super::external::ExternalLoads;
use super::particles::Particles;
use crate::Vec3;
use crate::parallel::BLOCK;

/// A sphere as a [`BodyForce`] sees it, with position and contacts at the begin of the step. Its
/// velocities are half a step behind, as everywhere in the leapfrog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereState {
    /// The user's number of the sphere.
    pub number: u32,
    /// Index of its material.
    pub material: u16,
    /// Centre (m).
    pub position: Vec3,
    /// Velocity (m/s).
    pub velocity: Vec3,
    /// Angular velocity (rad/s).
    pub spin: Vec3,
    /// Radius (m).
    pub radius: f64,
    /// Mass (kg).
    pub mass: f64,
}

/// Force at the centre of a sphere, and torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyLoad {
    /// Force (N).
    pub force: Vec3,
    /// Torque (N m). Where [`DemOptions::rotation`](super::DemOptions::rotation) is off, no sphere turns.
    pub torque: Vec3,
}

/// A force that acts on each sphere on its own: a magnet, an electric field, a rotating frame, a drag
/// law. Everything else, the contacts, the fluid, the energy ledger, goes on as it is:
/// `dempfv/examples/point_magnet.rs` shows one.
///
/// It acts in each step from [`Dem::add_body_force`](super::Dem::add_body_force) on, compaction by growth included, and its work is
/// part of [`EnergyBalance::external_work`](super::EnergyBalance::external_work). Members of a clump
/// hand it on to their body. The bound of the time step does not know it: a force that changes steeply
/// over space wants Δt ≪ √(m / |∂F/∂x|).
pub trait BodyForce: Send + Sync {
    /// Its name in messages.
    fn name(&self) -> &str;

    /// What acts on a sphere at a model time (s). Spheres are asked in any order and by several threads.
    fn load(&self, sphere: &SphereState, time: f64) -> BodyLoad;
}

/// The body forces that act. Takes no memory and costs nothing where there is none.
#[derive(Default)]
pub(super) struct BodyForces {
    pub each: Vec<Box<dyn BodyForce>>,
}

impl BodyForces {
    pub fn is_empty(&self) -> bool {
        self.each.is_empty()
    }

    /// Adds what acts on the spheres at this model time (s).
    pub fn act(
        &self,
        particles: &Particles,
        time: f64,
        loads: &mut ExternalLoads,
    ) -> Result<(), DemError> {
        for body_force in &self.each {
            let (force, torque) = loads.all(particles.len());
            let blocks = force.par_chunks_mut(BLOCK).zip(torque.par_chunks_mut(BLOCK)).enumerate();
            let act = |(block, (force, torque)): (usize, (&mut [Vec3], &mut [Vec3]))| {
                let mut turns = false;
                for (k, (force, torque)) in (block * BLOCK..).zip(force.iter_mut().zip(torque)) {
                    let load = body_force.load(&particles.sphere(k), time);
                    let finite = |v: &Vec3| v.iter().all(|x| x.is_finite());
                    if !(finite(&load.force) && finite(&load.torque)) {
                        return Err(particles.id[k]);
                    }
                    *force += load.force;
                    *torque += load.torque;
                    turns |= load.torque != Vec3::zeros();
                }
                Ok(turns)
            };
            // The smallest number of those that blocks name: the same for any number of threads.
            let turns = blocks.map(act).reduce(
                || Ok(false),
                |a, b| match (a, b) {
                    (Ok(a), Ok(b)) => Ok(a | b),
                    (Err(a), Err(b)) => Err(a.min(b)),
                    (Err(particle), _) | (_, Err(particle)) => Err(particle),
                },
            );
            let name = || body_force.name().to_owned();
            loads.turn(turns.map_err(|particle| DemError::BodyForce { name: name(), particle })?);
        }
        Ok(())
    }
}

impl Particles {
    /// The sphere at a place in storage.
    fn sphere(&self, k: usize) -> SphereState {
        SphereState {
            number: self.id[k],
            material: self.material_of(k),
            position: self.position[k],
            velocity: self.velocity[k],
            spin: self.spin[k],
            radius: self.radius[k],
            mass: self.mass[k],
        }
    }
}
