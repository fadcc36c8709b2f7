//! The granular law: a contact put together from the effects that are asked for.

use serde::Serialize;

use super::batch::{Batch, get, put};
use super::contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
use super::geometry::{Geometry, Radii};
use super::hertz::{self, Hertz};
use super::restitution::{self, Restitution};
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::{add_scaled, cross, scaled};
use super::{shear, springs};
use crate::Vec3;
use crate::dem::error::DemError;
use crate::dem::material::{Material, WallMaterial};

/// What the granular law is put together from. Without any of it, it is the linear law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct GranularEffects {
    /// Hertz's and Mindlin's contact in the place of linear springs.
    pub hertz: Option<Hertz>,
    /// Viscous damping.
    pub restitution: Option<Restitution>,
}

/// A law whose batches go through a loop for each effect that is on; which these are is asked once
/// a batch. Friction and shear stiffness are those of the materials.
#[derive(Clone, Copy, Debug)]
pub struct Granular {
    effects: GranularEffects,
}

impl Granular {
    /// The law with these effects.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a constant that makes no sense.
    pub fn new(effects: GranularEffects) -> Result<Granular, DemError> {
        effects.hertz.iter().try_for_each(Hertz::check)?;
        effects.restitution.iter().try_for_each(Restitution::check)?;
        Ok(Granular { effects })
    }

    /// What it is put together from.
    pub fn effects(&self) -> &GranularEffects {
        &self.effects
    }

    /// Factor on the damping ratio of the tangent spring: see [`restitution::resist`].
    fn shape(&self) -> f64 {
        if self.effects.hertz.is_some() { (5.0f64 / 6.0).sqrt() } else { 1.0 }
    }

    /// Tangent stiffness (N/m) and normal force (N) at rest.
    #[inline(always)]
    fn at_rest(&self, p: &GranularParameters, radii: impl Radii, overlap: f64) -> (f64, f64) {
        if self.effects.hertz.is_some() {
            let stiffness = hertz::stiffness(p.modulus, radii.reduced(1.0), overlap);
            (stiffness, 2.0 / 3.0 * stiffness * overlap)
        } else {
            let stiffness = radii.reduced(p.modulus);
            (stiffness, stiffness * overlap.max(0.0))
        }
    }

    fn parameters(
        &self,
        (modulus, shear_ratio): (f64, f64),
        angles: [f64; 2],
        densities: [f64; 2],
        restitution: Option<f64>,
    ) -> GranularParameters {
        GranularParameters {
            modulus,
            shear_ratio,
            friction: angles[0].min(angles[1]).tan(),
            densities,
            damping_ratio: restitution.map_or(0.0, restitution::damping_ratio),
        }
    }
}

impl ContactLaw for Granular {
    type History = Memory;
    type Parameters = GranularParameters;
    type Scratch = Terms;

    fn name(&self) -> &'static str {
        "granular"
    }

    #[inline(always)]
    fn history_length(&self) -> usize {
        3
    }

    fn between_spheres(&self, first: &Material, second: &Material) -> GranularParameters {
        let stiffness = match self.effects.hertz {
            Some(hertz) => hertz.between_spheres(first, second),
            None => springs::between_spheres(first, second),
        };
        let angles = [first.friction_angle, second.friction_angle];
        let restitution = self.effects.restitution.map(|r| r.spheres);
        self.parameters(stiffness, angles, [first.density, second.density], restitution)
    }

    fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> GranularParameters {
        let stiffness = match self.effects.hertz {
            Some(hertz) => hertz.on_wall(sphere, wall),
            None => springs::on_wall(sphere, wall),
        };
        let angles = [sphere.friction_angle, wall.friction_angle];
        let restitution = self.effects.restitution.map(|r| r.walls);
        self.parameters(stiffness, angles, [sphere.density; 2], restitution)
    }

    fn needs(&self, parameters: &GranularParameters) -> Needs {
        if parameters.friction > 0.0 {
            Needs::Torques
        } else if parameters.damping_ratio > 0.0 {
            Needs::Motion
        } else {
            Needs::Overlap
        }
    }

    fn stiffens(&self) -> bool {
        self.effects.hertz.is_some()
    }

    fn expected_overlap(
        &self,
        parameters: &GranularParameters,
        radii: impl Radii,
        energy: f64,
        usual: f64,
    ) -> f64 {
        match self.effects.hertz {
            Some(_) => {
                let radius = radii.reduced(1.0);
                usual.max(hertz::overlap_of_energy(parameters.modulus, radius, energy))
            }
            None => usual,
        }
    }

    #[inline(always)]
    fn stiffness(&self, p: &GranularParameters, radii: impl Radii, overlap: f64) -> Stiffness {
        let (mut normal, _) = self.at_rest(p, radii, overlap);
        let mut shear = if p.friction > 0.0 { p.shear_ratio * normal } else { 0.0 };
        if p.damping_ratio > 0.0 {
            let ratio = self.shape() * p.damping_ratio;
            normal *= restitution::stiffening(ratio);
            // What slides has 2/7 of the mass of what approaches, where spheres turn.
            shear *= restitution::stiffening(3.5f64.sqrt() * ratio);
        }
        Stiffness { normal, shear }
    }

    fn force(
        &self,
        p: &GranularParameters,
        radii: impl Radii,
        overlap: f64,
        history: &Memory,
    ) -> ContactForce {
        let (_, normal) = self.at_rest(p, radii, overlap);
        let [x, y, z] = [0, 1, 2].map(|k| history.0[k]);
        ContactForce { normal, shear: Vec3::new(x, y, z) }
    }

    /// Of the normal spring, and F_s² / 2k_t of the shear spring.
    fn elastic_energy(
        &self,
        p: &GranularParameters,
        radii: impl Radii,
        overlap: f64,
        history: &Memory,
    ) -> f64 {
        let (stiffness, normal) = self.at_rest(p, radii, overlap);
        let share = if self.effects.hertz.is_some() { 0.4 } else { 0.5 };
        let shear = self.force(p, radii, overlap, history).shear.norm_squared();
        let tangential = if shear > 0.0 { 0.5 * shear / (p.shear_ratio * stiffness) } else { 0.0 };
        share * normal * overlap + tangential
    }

    fn reversed(&self, mut history: Memory) -> Memory {
        history.0[..3].iter_mut().for_each(|x| *x = -*x);
        history
    }

    #[inline(always)]
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &mut Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        let damped = MOTION && self.effects.restitution.is_some();
        if self.effects.hertz.is_some() {
            hertz::press(batch, terms, parameters);
        } else {
            springs::press(batch, terms, parameters);
        }
        if damped {
            restitution::resist(batch, terms, parameters, self.shape());
            restitution::join(batch, terms);
            restitution::drag::<G, TORQUES>(batch, terms, parameters);
        }
        terms.grip = terms.push;
        if MOTION && batch.dt != 0.0 {
            shear::follow::<G, TORQUES>(batch, terms, parameters);
            if self.effects.hertz.is_some() {
                hertz::shrink(batch, terms);
                shear::shrink(batch, terms);
            }
            shear::cut(batch, terms, parameters);
        }
        sum::<G, MOTION, TORQUES>(batch, terms);
    }
}

/// Forces and torques.
#[inline(always)]
fn sum<G: Geometry, const MOTION: bool, const TORQUES: bool>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
) {
    for l in batch.lanes() {
        let normal = batch.geometry.normal(l);
        let mut force = scaled(terms.push[l], normal);
        if MOTION {
            let spring = [0, 1, 2].map(|k| batch.history[k][l]);
            let shear = add_scaled(spring, 1.0, get(&terms.drag, l));
            force = add_scaled(force, 1.0, shear);
            if TORQUES {
                let moment = cross(normal, shear);
                let [first, second] = batch.geometry.arms(l);
                put(&mut batch.torque[0], l, scaled(-first, moment));
                put(&mut batch.torque[1], l, scaled(-second, moment));
            }
        }
        put(&mut batch.force, l, force);
    }
}
