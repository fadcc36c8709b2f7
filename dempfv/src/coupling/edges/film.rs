//! The fluid between two neighbours in a step.

use crate::dem::Dem;
use crate::{PerWall, Vec3, WallId};

/// Two neighbours: how they are placed, how they move relative to each other, and what the fluid
/// between them makes of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Film {
    /// Mean radius of two spheres, or that of the one at a wall (m).
    pub radius: f64,
    /// The smaller radius, likewise (m).
    pub smaller: f64,
    /// Area of the facet between their power cells (m²).
    pub area: f64,
    /// Stiffness of the spring in series with the film (N/m).
    pub stiffness: f64,
    /// Unit normal from the first to the second.
    pub normal: Vec3,
    /// Distance of the centres, or of a centre and the wall's plane (m).
    pub distance: f64,
    /// Distances of both centres from the plane between the power cells (m).
    pub arms: [f64; 2],
    /// Distance of the surfaces (m); negative where they overlap.
    pub gap: f64,
    /// Thickness of the film between rough surfaces that nothing presses (m).
    pub thickness: f64,
    /// Velocity of the second surface relative to the first, across the normal (m/s).
    pub slip: Vec3,
    /// Speed at which they come closer (m/s).
    pub closing: f64,
    /// Spin of the second relative to the first (rad/s).
    pub turn: Vec3,
    /// Force per slip by viscous shear and by shear lubrication (N·s/m).
    pub viscous_shear: f64,
    pub shear_lubrication: f64,
    /// Couple per relative spin, across the normal and along it (N·m·s).
    pub pump: f64,
    pub twist: f64,
    /// Force of the film, positive where it pushes the two apart (N), now and a step before.
    pub force: f64,
    pub force_before: f64,
}

/// How two surfaces move relative to each other.
#[derive(Clone, Copy)]
pub struct Relative {
    pub slip: Vec3,
    pub closing: f64,
    pub turn: Vec3,
}

/// Spheres and walls as films see them.
#[derive(Clone, Copy)]
pub struct Bodies<'a> {
    pub position: &'a [Vec3],
    pub velocity: &'a [Vec3],
    pub spin: &'a [Vec3],
    pub radius: &'a [f64],
    /// Coordinate of each wall's plane (m), and its velocity along its axis (m/s).
    pub plane: PerWall<f64>,
    pub wall_velocity: PerWall<f64>,
}

impl<'a> Bodies<'a> {
    pub fn of(dem: &'a Dem) -> Bodies<'a> {
        let p = dem.storage();
        Bodies {
            position: &p.position,
            velocity: &p.velocity,
            spin: &p.spin,
            radius: &p.radius,
            plane: dem.walls().map(|wall| wall.position),
            wall_velocity: dem.walls().map(|wall| wall.velocity),
        }
    }

    /// The wall that the second vertex of an edge stands for, if it is one.
    pub fn wall(&self, vertex: u32) -> Option<WallId> {
        let n = self.position.len();
        (vertex as usize).checked_sub(n).and_then(|w| WallId::ALL.get(w).copied())
    }
}

impl Film {
    /// Takes where the two are now, and how they move.
    pub fn measure(&mut self, bodies: &Bodies, [i, j]: [u32; 2], roughness: f64) {
        let (a, r) = (bodies.position[i as usize], bodies.radius[i as usize]);
        match bodies.wall(j) {
            None => {
                let apart = bodies.position[j as usize] - a;
                self.distance = apart.norm();
                self.normal = apart / self.distance;
                let (d, s) = (self.distance, bodies.radius[j as usize]);
                self.gap = d - r - s;
                let first = 0.5 * (d + (r - s) * (r + s) / d);
                self.arms = [first, d - first];
            }
            Some(wall) => {
                self.distance = (a[wall.axis()] - bodies.plane[wall]) * wall.inward();
                self.normal = -wall.inward_normal();
                self.gap = self.distance - r;
                self.arms = [self.distance, 0.0];
            }
        }
        self.thickness = self.gap.max(0.0) + 2.0 * roughness * self.radius;
        let relative = self.relative(bodies, [i, j]);
        (self.slip, self.closing, self.turn) = (relative.slip, relative.closing, relative.turn);
    }

    /// How the two move, in the place that was measured. Both surfaces are taken in the plane between
    /// the power cells: a pair that turns as one body has no slip then, and a force there no moment on
    /// both together.
    pub fn relative(&self, bodies: &Bodies, [i, j]: [u32; 2]) -> Relative {
        let (i, j, n) = (i as usize, j as usize, self.normal);
        let rim = self.arms[0] * bodies.spin[i];
        let (velocity, rims, turn) = match bodies.wall(j as u32) {
            None => (
                bodies.velocity[j] - bodies.velocity[i],
                rim + self.arms[1] * bodies.spin[j],
                bodies.spin[j] - bodies.spin[i],
            ),
            Some(wall) => {
                let moved = -wall.inward() * bodies.wall_velocity[wall] * n;
                (moved - bodies.velocity[i], rim, -bodies.spin[i])
            }
        };
        let apart = velocity.dot(&n);
        Relative { slip: velocity - apart * n - rims.cross(&n), closing: -apart, turn }
    }

    /// Force across the normal on the first (N); the second gets the opposite.
    pub fn drag(&self) -> Vec3 {
        (self.viscous_shear + self.shear_lubrication) * self.slip
    }

    /// Couple on the first (N·m); the second gets the opposite.
    pub fn couple(&self) -> Vec3 {
        let along = self.turn.dot(&self.normal);
        self.pump * self.turn + (self.twist - self.pump) * along * self.normal
    }
}
