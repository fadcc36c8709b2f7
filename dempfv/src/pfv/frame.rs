//! Spheres and walls in coordinates that start at the box's lower corner, so
//! that a packing far from the origin loses no digits in the geometry.

use rayon::prelude::*;

use crate::{Aabb, Vec3, WallId};

/// A packing in its box, seen from the box's lower corner.
pub(super) struct Frame<'a> {
    /// Sphere centres relative to the box's lower corner (m).
    pub x: Vec<Vec3>,
    /// Sphere radii (m).
    pub r: &'a [f64],
    /// Edge lengths of the box (m).
    pub size: Vec3,
}

/// A vertex of the triangulation.
#[derive(Clone, Copy)]
pub(super) enum Vertex {
    Sphere { x: Vec3, r: f64 },
    Wall(WallId),
}

impl<'a> Frame<'a> {
    pub fn new(position: &[Vec3], radius: &'a [f64], bounds: &Aabb) -> Self {
        Frame {
            x: position.par_iter().map(|x| x - bounds.min).collect(),
            r: radius,
            size: bounds.size(),
        }
    }

    pub fn spheres(&self) -> usize {
        self.x.len()
    }

    /// Whether none of the vertices is a wall.
    #[inline(always)]
    pub fn are_spheres<const N: usize>(&self, vertices: &[u32; N]) -> bool {
        let walls = self.x.len() as u32;
        let mut spheres = true;
        for &v in vertices {
            spheres &= v < walls;
        }
        spheres
    }

    pub fn vertex(&self, v: u32) -> Vertex {
        match self.x.get(v as usize) {
            Some(&x) => Vertex::Sphere { x, r: self.r[v as usize] },
            None => Vertex::Wall(WallId::ALL[v as usize - self.x.len()]),
        }
    }

    /// Coordinate of a wall's plane along its axis.
    pub fn plane(&self, wall: WallId) -> f64 {
        if wall.is_max() { self.size[wall.axis()] } else { 0.0 }
    }

    /// Distance of a point from a wall, positive inside the box.
    pub fn distance(&self, wall: WallId, x: &Vec3) -> f64 {
        wall.inward() * (x[wall.axis()] - self.plane(wall))
    }

    /// Projection of a point on a wall.
    pub fn project(&self, wall: WallId, x: &Vec3) -> Vec3 {
        let mut on = *x;
        on[wall.axis()] = self.plane(wall);
        on
    }
}

/// Vertices of the facet opposite each vertex of a positively oriented cell,
/// in the order that turns counterclockwise seen from outside.
pub(super) const FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
