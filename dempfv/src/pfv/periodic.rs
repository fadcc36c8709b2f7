//! What a network has in a periodic cell, and copies that are near to each other.

use crate::{Cell, Vec3};

/// What a network has in a periodic cell.
#[derive(Clone, Debug)]
pub struct PeriodicNetwork {
    /// The cell that the network was built in, by its short edges.
    pub cell: Cell,
    /// For each throat the way from the centre of its first pore to that of the second, of the copy
    /// that it leads to (m).
    pub way: Vec<Vec3>,
    /// For each pore the way from the copy of each of its spheres to its centre (m).
    pub arm: Vec<[Vec3; 4]>,
    /// Volume of the fluid in each pore (m³).
    pub(super) void: Vec<f64>,
}

/// The corners of a pore (m), each sphere by the copy nearest to the first.
pub(crate) fn cell_corners(vertices: &[u32; 4], position: &[Vec3], cell: &Cell) -> [Vec3; 4] {
    let at = vertices.map(|v| position[v as usize]);
    at.map(|x| at[0] + nearest(&(x - at[0]), cell))
}

/// The shortest of the ways (m) to the copies of a point, where it is less than half of each edge.
pub(super) fn nearest(way: &Vec3, cell: &Cell) -> Vec3 {
    let images: [i32; 3] = cell.fractions(way).map(|f| f.round() as i32).into();
    way - cell.shift(images)
}
