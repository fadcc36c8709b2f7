//! What a checkpoint holds.

use serde::{Deserialize, Serialize};

use super::particles::Particles;
use super::walls::Wall;
use crate::{Vec3, WallId};

/// The shear force that a contact of two spheres has built up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SphereHistory {
    /// Index of the first sphere, the smaller of the two.
    pub i: u32,
    /// Index of the second sphere.
    pub j: u32,
    /// Shear force on the second sphere (N).
    pub shear: Vec3,
}

/// The shear force that a contact of a sphere and a wall has built up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallHistory {
    /// Index of the sphere.
    pub i: u32,
    /// The wall.
    pub wall: WallId,
    /// Shear force on the wall (N).
    pub shear: Vec3,
}

/// Everything that the mechanics needs to go on as if it had not stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DemState {
    /// The spheres.
    pub particles: Particles,
    /// The walls, by [`WallId::index`].
    pub walls: [Wall; 6],
    /// Shear forces between spheres.
    pub sphere_history: Vec<SphereHistory>,
    /// Shear forces between spheres and walls.
    pub wall_history: Vec<WallHistory>,
    /// Length of the last step (s) if the shear forces have not yet followed
    /// its motion, else 0.
    pub pending_dt: f64,
}

impl DemState {
    /// Puts the spheres in spatial order and the history with them.
    pub(super) fn sort_spatially(&mut self) {
        let from = self.particles.sort_spatially();
        let mut to = vec![0u32; from.len()];
        for (k, &i) in (0u32..).zip(&from) {
            to[i as usize] = k;
        }
        for h in &mut self.sphere_history {
            let (i, j) = (to[h.i as usize], to[h.j as usize]);
            // The force is the one on the second sphere.
            (h.i, h.j, h.shear) = if i < j { (i, j, h.shear) } else { (j, i, -h.shear) };
        }
        for h in &mut self.wall_history {
            h.i = to[h.i as usize];
        }
    }
}
