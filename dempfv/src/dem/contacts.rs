//! The live contacts, one by one, for observables and output.

use super::neighbours::WallPair;
use super::system::Dem;
use crate::{Vec3, WallId};

/// The other side of a sphere's contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The sphere with this index.
    Sphere(u32),
    /// A wall.
    Wall(WallId),
}

/// A contact that carries force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the sphere; with two spheres, the smaller index.
    pub i: u32,
    /// What it touches.
    pub partner: Partner,
    /// Unit normal from the sphere to its partner.
    pub normal: Vec3,
    /// Depth by which the two overlap (m).
    pub overlap: f64,
    /// Distance from the sphere's centre to the partner's, or to the wall's
    /// plane (m).
    pub distance: f64,
    /// Normal stiffness k_n (N/m).
    pub stiffness: f64,
    /// Normal force, positive in compression (N).
    pub normal_force: f64,
    /// Shear force on the partner (N).
    pub shear: Vec3,
}

impl Contact {
    /// Force on the partner (N); the sphere gets the opposite.
    pub fn force(&self) -> Vec3 {
        self.normal_force * self.normal + self.shear
    }
}

impl Dem {
    /// The contacts that touched at the last [`Dem::compute_contacts`], with
    /// the normal and overlap of the current positions: sphere pairs first,
    /// then walls.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let list = &self.list;
        let pairs = list.pairs.iter().zip(&list.touch).zip(&list.shear);
        let spheres = pairs
            .filter(|((_, touch), _)| **touch)
            .map(|((&[i, j], _), &shear)| self.sphere_contact(i, j, shear));
        let pairs = list.wall_pairs.iter().zip(&list.wall_touch).zip(&list.wall_shear);
        let walls = pairs
            .filter(|((_, touch), _)| **touch)
            .map(|((&pair, _), &shear)| self.wall_contact(pair, shear));
        spheres.chain(walls)
    }

    fn sphere_contact(&self, i: u32, j: u32, shear: Vec3) -> Contact {
        let p = &self.particles;
        let (a, b) = (i as usize, j as usize);
        let apart = p.position[b] - p.position[a];
        let distance = apart.norm();
        let overlap = p.radius[a] + p.radius[b] - distance;
        let stiffness = self.law.pair_stiffness(p.radius[a], p.radius[b]);
        Contact {
            i,
            partner: Partner::Sphere(j),
            normal: apart / distance,
            overlap,
            distance,
            stiffness,
            normal_force: stiffness * overlap.max(0.0),
            shear,
        }
    }

    fn wall_contact(&self, pair: WallPair, shear: Vec3) -> Contact {
        let WallPair { i, wall } = pair;
        let k = i as usize;
        let plane = self.walls[wall.index()].position;
        let distance = (self.particles.position[k][wall.axis()] - plane) * wall.inward();
        let radius = self.particles.radius[k];
        let stiffness = self.law.wall * radius;
        let overlap = radius - distance;
        Contact {
            i,
            partner: Partner::Wall(wall),
            normal: -wall.inward_normal(),
            overlap,
            distance,
            stiffness,
            normal_force: stiffness * overlap.max(0.0),
            shear,
        }
    }

    /// Number of contacts between spheres at the last
    /// [`Dem::compute_contacts`].
    pub fn sphere_contact_count(&self) -> usize {
        self.list.touch.iter().filter(|t| **t).count()
    }

    /// Number of contacts of spheres with walls, likewise.
    pub fn wall_contact_count(&self) -> usize {
        self.list.wall_touch.iter().filter(|t| **t).count()
    }
}
