//! Clumps of one shape in the places of spheres.

use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::rng::Rng;
use crate::Vec3;

/// The shape of a clump, in units of the radius of the sphere that it takes the place of, from whose
/// centre its places count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClumpTemplate {
    /// Centre and radius of each member; all of them within the sphere.
    pub members: Vec<(Vec3, f64)>,
}

/// Spheres that are the members of clumps.
#[derive(Clone, Debug, PartialEq)]
pub struct ClumpedSpheres {
    /// Centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The members of each clump, for [`Dem::bind`](super::Dem::bind).
    pub clumps: Vec<Vec<u32>>,
}

/// What a member may stand out of its sphere, of whose radius it is a share.
const ROUND_OFF: f64 = 1e-9;

impl ClumpTemplate {
    /// What is wrong with it, if anything; members that cannot be bound are refused where they are.
    pub fn problem(&self) -> Option<&'static str> {
        let number = |&(c, r): &(Vec3, f64)| c.iter().all(|x| x.is_finite()) && r > 0.0;
        let inside = |&(c, r): &(Vec3, f64)| c.norm() + r <= 1.0 + ROUND_OFF;
        if self.members.len() < 2 {
            return Some("has fewer than two members");
        }
        if !self.members.iter().all(number) {
            return Some("has a member without a finite place and a radius above 0");
        }
        if !self.members.iter().all(inside) {
            return Some("has a member that stands out of the unit sphere");
        }
        None
    }

    /// A clump of this shape in the place of each sphere (m), turned at random. Members have the numbers
    /// that follow each other.
    ///
    /// # Errors
    /// [`DemError::Clump`] for a template with a [`problem`](ClumpTemplate::problem).
    pub fn in_place_of(
        &self,
        spheres: &[(Vec3, f64)],
        seed: u64,
    ) -> Result<ClumpedSpheres, DemError> {
        if let Some(reason) = self.problem() {
            return Err(DemError::Clump { clump: 0, reason });
        }
        let mut rng = Rng::new(seed);
        let count = spheres.len() * self.members.len();
        let mut all = ClumpedSpheres {
            position: Vec::with_capacity(count),
            radius: Vec::with_capacity(count),
            clumps: Vec::with_capacity(spheres.len()),
        };
        for &(centre, radius) in spheres {
            let turn = any_turn(&mut rng);
            let first = all.position.len() as u32;
            for &(place, share) in &self.members {
                all.position.push(centre + radius * (turn * place));
                all.radius.push(radius * share);
            }
            all.clumps.push((first..all.position.len() as u32).collect());
        }
        Ok(all)
    }
}

/// A rotation of which each is as likely (K. Shoemake: Graphics Gems III, 1992).
fn any_turn(rng: &mut Rng) -> UnitQuaternion<f64> {
    let [u, v, w] = [0; 3].map(|_| rng.uniform());
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    let [v, w] = [v, w].map(|x| std::f64::consts::TAU * x);
    let vector = Vec3::new(a * v.sin(), a * v.cos(), b * w.sin());
    UnitQuaternion::new_normalize(Quaternion::from_parts(b * w.cos(), vector))
}
