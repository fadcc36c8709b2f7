//! The middle of a pore's volume.

use rayon::prelude::*;

use super::frame::{Frame, Vertex};
use super::{Network, PfvError};
use crate::{Aabb, Vec3, WallId};

impl Network {
    /// Centroid of each pore (m): the mean of the points of its volume, solids included, for
    /// spheres at `position` and walls at `bounds`. It lies inside the pore, where the
    /// power centre ([`Network::center`], from which conductances follow) may lie outside.
    /// Pores at walls reach to the walls. Not a number for a pore without volume.
    ///
    /// # Errors
    /// As [`Network::volumes_at`].
    pub fn centroids(&self, position: &[Vec3], bounds: &Aabb) -> Result<Vec<Vec3>, PfvError> {
        self.check_vertices(position, bounds)?;
        // The centroid does not depend on the radii.
        let radius = vec![0.0; position.len()];
        let frame = Frame::new(position, &radius, bounds);
        let cells = self.tessellation.cells.par_iter();
        Ok(cells.map(|&cell| bounds.min + centroid(&frame, cell)).collect())
    }
}

/// Centroid of the cell in the coordinates of the frame.
fn centroid(frame: &Frame, cell: [u32; 4]) -> Vec3 {
    let (mut spheres, mut walls) = (Vec::with_capacity(4), Vec::with_capacity(3));
    for v in cell {
        match frame.vertex(v) {
            Vertex::Sphere { x, .. } => spheres.push(x),
            Vertex::Wall(wall) => walls.push(wall),
        }
    }
    let NodeSum { weight, moment } = match spheres[..] {
        [a, b, c] => triangle_nodes(a, b, c).map(|x| columns(frame, &walls, x)).into_iter().sum(),
        [a, b] => segment_nodes(a, b).map(|x| columns(frame, &walls, x)).into_iter().sum(),
        [a] => columns(frame, &walls, a),
        _ => NodeSum { weight: 4.0, moment: spheres.iter().sum() },
    };
    moment / weight
}

/// A sum over nodes: of their weights, and of the points times these.
#[derive(Default)]
struct NodeSum {
    weight: f64,
    moment: Vec3,
}

impl std::iter::Sum for NodeSum {
    fn sum<I: Iterator<Item = NodeSum>>(nodes: I) -> NodeSum {
        nodes.fold(NodeSum::default(), |sum, node| NodeSum {
            weight: sum.weight + node.weight,
            moment: sum.moment + node.moment,
        })
    }
}

/// What lies between a point and its projections on one, two or three walls: a line, a
/// rectangle or a box, of which the middle counts.
fn columns(frame: &Frame, walls: &[WallId], x: Vec3) -> NodeSum {
    let (mut weight, mut middle) = (1.0, x);
    for &wall in walls {
        weight *= frame.distance(wall, &x);
        middle[wall.axis()] = 0.5 * (x[wall.axis()] + frame.plane(wall));
    }
    NodeSum { weight, moment: weight * middle }
}

/// The edges' middles: equal weights integrate polynomials of degree 2 over a triangle exactly.
fn triangle_nodes(a: Vec3, b: Vec3, c: Vec3) -> [Vec3; 3] {
    [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]
}

/// The two points of Gauss: equal weights integrate polynomials of degree 3 exactly.
fn segment_nodes(a: Vec3, b: Vec3) -> [Vec3; 2] {
    let (middle, half) = (0.5 * (a + b), 0.5 / 3f64.sqrt() * (b - a));
    [middle - half, middle + half]
}
