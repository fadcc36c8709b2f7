//! What a run began with, as far as a restart cannot change it.

use serde::{Deserialize, Serialize};

use super::refused_all;
use crate::domain::{Aabb, Vec3};
use crate::scene::{ParticleSource, Plan};
use crate::simulation::fingerprint::fingerprint;
use crate::{InputError, Result};

/// What a run began with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::simulation) struct Origin {
    /// The scene, as [`Plan::to_toml`] writes it; that of the last restart.
    pub scene: String,
    spheres: u64,
    /// Of centres and radii, in the user's order.
    fingerprint: u64,
    bounds: Aabb,
}

impl Origin {
    /// Spheres at their first places (m), in their box.
    pub fn new(plan: &Plan, position: &[Vec3], radius: &[f64], bounds: Aabb) -> Origin {
        let fingerprint = fingerprint_of(position, radius);
        Origin { scene: plan.to_toml(), spheres: radius.len() as u64, fingerprint, bounds }
    }

    /// The same spheres and box, with the scene that goes on with them. Of a packing, the file is
    /// read; a cloud's keys are compared with all others.
    ///
    /// # Errors
    /// The spheres or their box are others, or the packing cannot be read.
    pub fn with(&self, plan: &Plan) -> Result<Origin> {
        if let Some(bounds) = plan.bounds {
            self.check_box(plan, &bounds)?;
        }
        if let Some((packing, bounds)) = plan.packing()? {
            self.check_packing(plan, &packing.position, &packing.radius)?;
            self.check_box(plan, &bounds)?;
        }
        Ok(Origin { scene: plan.to_toml(), ..*self })
    }

    fn check_box(&self, plan: &Plan, now: &Aabb) -> Result<(), InputError> {
        if *now == self.bounds {
            return Ok(());
        }
        let what = format!(
            "the box goes {}, it went {} when the run began; the walls are where the run has moved them",
            extent(now),
            extent(&self.bounds)
        );
        Err(refused_all(plan, &what))
    }

    fn check_packing(&self, plan: &Plan, x: &[Vec3], r: &[f64]) -> Result<(), InputError> {
        let ParticleSource::Packing(path) = &plan.particles.source else { return Ok(()) };
        let what = if r.len() as u64 != self.spheres {
            format!(
                "`packing` in [particles], {}, has {} spheres, the run began with {}",
                path.display(),
                r.len(),
                self.spheres
            )
        } else if fingerprint_of(x, r) != self.fingerprint {
            format!(
                "`packing` in [particles], {}, has other positions or radii than the {} spheres that the run \
                 began with",
                path.display(),
                self.spheres
            )
        } else {
            return Ok(());
        };
        Err(refused_all(plan, &what))
    }
}

fn fingerprint_of(position: &[Vec3], radius: &[f64]) -> u64 {
    fingerprint(position.iter().zip(radius).flat_map(|(x, &r)| [x.x, x.y, x.z, r]))
}

fn extent(bounds: &Aabb) -> String {
    let Aabb { min, max } = bounds;
    format!("from [{}, {}, {}] to [{}, {}, {}]", min.x, min.y, min.z, max.x, max.y, max.z)
}
