//! The pores as polyhedra, for pictures and other programs.

use super::Cells;
use crate::input::InputError;
use crate::io::error::Result;
use crate::pfv::{Network, cell_corners};
use crate::{Aabb, Cell, Vec3};

/// Corners of a box counted in binary (bit 0 along the first edge, and so on)
/// in the order of a hexahedron: around one face, then around the other.
const AROUND: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// The pores as cells on points (m), for spheres at `position` and walls
/// at `bounds`: tetrahedra inside; at the walls the prisms, wedges and
/// boxes between spheres and their projections. The first points are the
/// sphere centres; cell `i` is pore `i`.
///
/// # Errors
/// An [`InputError`] when there is not one position per sphere.
pub fn pore_cells(
    network: &Network,
    position: &[Vec3],
    bounds: &Aabb,
) -> Result<(Vec<Vec3>, Cells)> {
    let t = &network.tessellation;
    require_one_per_sphere(network, position)?;
    let mut points = position.to_vec();
    let mut cells = Cells::default();
    let mut corners = Vec::with_capacity(8);
    for cell in &t.cells {
        if cell.iter().all(|&v| (v as usize) < t.spheres) {
            cells.push_tetra(*cell);
            continue;
        }
        corners.clear();
        corners.extend(cell.iter().filter_map(|&v| position.get(v as usize)));
        for wall in cell.iter().filter_map(|&v| t.wall(v)) {
            // Each wall doubles the corners: its own are the projections.
            for k in 0..corners.len() {
                let mut on_wall: Vec3 = corners[k];
                on_wall[wall.axis()] = bounds.wall(wall);
                corners.push(on_wall);
            }
        }
        let first = points.len() as u32;
        points.extend(&corners);
        if corners.len() == 6 {
            cells.push_wedge([0, 1, 2, 3, 4, 5].map(|k| first + k));
        } else {
            cells.push_hexahedron(AROUND.map(|k| first + k as u32));
        }
    }
    cells.orient(&points);
    Ok((points, cells))
}

/// The pores of a periodic cell as tetrahedra with points of their own (m): each in one piece, where
/// one of its spheres is; cell `i` is pore `i`. Any copy of a sphere may be given.
///
/// # Errors
/// An [`InputError`] when there is not one position per sphere.
pub fn pore_cells_in_cell(
    network: &Network,
    position: &[Vec3],
    cell: &Cell,
) -> Result<(Vec<Vec3>, Cells)> {
    require_one_per_sphere(network, position)?;
    let mut points = vec![];
    let mut cells = Cells::default();
    for pore in &network.tessellation.cells {
        let first = points.len() as u32;
        points.extend(cell_corners(pore, position, cell));
        cells.push_tetra([0, 1, 2, 3].map(|k| first + k));
    }
    cells.orient(&points);
    Ok((points, cells))
}

fn require_one_per_sphere(network: &Network, position: &[Vec3]) -> Result<()> {
    let spheres = network.tessellation.spheres;
    if position.len() == spheres {
        return Ok(());
    }
    let what = format!("`position` has {} entries", position.len());
    let remedy = format!("give one centre for each of the {spheres} spheres");
    Err(InputError::new(what, remedy).into())
}
