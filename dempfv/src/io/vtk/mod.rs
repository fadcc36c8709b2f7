//! Results for ParaView and VTK: one `.vtu` file per frame, and a `.pvd`
//! collection that gives each its time.
//!
//! The files are VTK XML unstructured grids, version 1.0, with appended raw
//! binary data, little endian: as fast to write and as small as the data.

mod collection;
mod grid;
mod pore_cells;

use std::path::Path;

pub use collection::Collection;
use grid::{Array, Column, Grid};
pub use pore_cells::{pore_cells, pore_cells_in_cell};

use crate::Vec3;
use crate::io::error::Result;

/// VTK's numbers of the cell types used here.
const VERTEX: u8 = 1;
const TETRA: u8 = 10;
const HEXAHEDRON: u8 = 12;
const WEDGE: u8 = 13;

/// What is known of the spheres at one time; all slices have one entry per
/// sphere.
#[derive(Clone, Copy, Debug)]
pub struct SphereFrame<'a> {
    /// Centres (m).
    pub position: &'a [Vec3],
    /// Radii (m).
    pub radius: &'a [f64],
    /// Velocities (m/s).
    pub velocity: &'a [Vec3],
    /// Resultant forces (N).
    pub force: &'a [Vec3],
    /// The user's numbers of the spheres.
    pub id: &'a [u32],
}

/// Writes spheres as points with `radius`, `velocity`, `force` and `id`. In
/// ParaView: filter "Glyph", type sphere, scaled by `radius`, factor 2.
///
/// # Errors
/// [`IoError::File`](crate::io::IoError::File) when the file cannot be written or the slices differ
/// in length; nothing partial remains.
pub fn write_spheres(path: &Path, frame: &SphereFrame) -> Result<()> {
    let cells = Cells::vertices(frame.position.len());
    Grid {
        points: frame.position,
        cells: &cells,
        point_data: &[
            Column { name: "radius", array: Array::Scalars(frame.radius) },
            Column { name: "velocity", array: Array::Vectors(frame.velocity) },
            Column { name: "force", array: Array::Vectors(frame.force) },
            Column { name: "id", array: Array::Ids(frame.id) },
        ],
        cell_data: &[],
    }
    .write(path)
}

/// Writes cells (pores) with data of one number per cell, by name and in SI
/// units: `&[("pressure", &p), ("volume", &v)]`.
///
/// ```
/// use dempfv::{Vec3, io::vtk::{self, Cells}};
/// let points = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let mut cells = Cells::default();
/// cells.push_tetra([0, 1, 2, 3]);
/// let path = std::env::temp_dir().join("dempfv-doc-cells.vtu");
/// vtk::write_cells(&path, &points, &cells, &[("pressure", &[101.3])])?;
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), dempfv::Error>(())
/// ```
///
/// # Errors
/// [`IoError::File`](crate::io::IoError::File) when the file cannot be written, a column has not one
/// number per cell, or a cell names a point that is not there; nothing partial
/// remains.
pub fn write_cells(
    path: &Path,
    points: &[Vec3],
    cells: &Cells,
    cell_data: &[(&str, &[f64])],
) -> Result<()> {
    let columns: Vec<_> = cell_data
        .iter()
        .map(|&(name, values)| Column { name, array: Array::Scalars(values) })
        .collect();
    Grid { points, cells, point_data: &[], cell_data: &columns }.write(path)
}

/// Cells as flat arrays: tetrahedra, wedges (prisms on a triangle) and
/// hexahedra. A cell's vertices are indices of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    connectivity: Vec<u32>,
    /// End of each cell in `connectivity`.
    offsets: Vec<u32>,
    types: Vec<u8>,
}

impl Cells {
    fn vertices(count: usize) -> Cells {
        let count = count as u32;
        Cells {
            connectivity: (0..count).collect(),
            offsets: (1..=count).collect(),
            types: vec![VERTEX; count as usize],
        }
    }

    fn push(&mut self, kind: u8, vertices: &[u32]) {
        self.connectivity.extend_from_slice(vertices);
        self.offsets.push(self.connectivity.len() as u32);
        self.types.push(kind);
    }

    /// Appends a tetrahedron. Positive: seen from the fourth vertex, the first
    /// three turn counter-clockwise.
    pub fn push_tetra(&mut self, vertices: [u32; 4]) {
        self.push(TETRA, &vertices);
    }

    /// Appends a wedge: two triangles, the second opposite the first.
    /// Positive: seen from the second triangle, the first turns clockwise (its
    /// normal points out of the wedge, as VTK has it).
    pub fn push_wedge(&mut self, vertices: [u32; 6]) {
        self.push(WEDGE, &vertices);
    }

    /// Appends a hexahedron: two quadrangles, the second opposite the first.
    /// Positive: seen from the second, the first turns counter-clockwise.
    pub fn push_hexahedron(&mut self, vertices: [u32; 8]) {
        self.push(HEXAHEDRON, &vertices);
    }

    /// The vertices of each cell in turn.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.offsets.iter().scan(0, |start, &end| {
            let cell = &self.connectivity[*start..end as usize];
            *start = end as usize;
            Some(cell)
        })
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.types.len()
    }

    /// True when there is no cell.
    pub fn is_empty(&self) -> bool {
        self.types.is_empty()
    }

    /// Removes all cells and keeps their memory.
    pub fn clear(&mut self) {
        self.connectivity.clear();
        self.offsets.clear();
        self.types.clear();
    }

    /// Mirrors the order of vertices in cells that are negative, so that all
    /// have a positive volume and outward faces for VTK. The points are those
    /// that [`write_cells`] gets; cells that name others are left as they are.
    pub fn orient(&mut self, points: &[Vec3]) {
        let mut start = 0;
        for (&end, &kind) in self.offsets.iter().zip(&self.types) {
            let cell = &mut self.connectivity[start..end as usize];
            start = end as usize;
            if cell.iter().all(|&v| (v as usize) < points.len())
                && orientation(kind, cell, points) < 0.0
            {
                mirror(kind, cell);
            }
        }
    }
}

/// A number with the sign of a convex cell's volume in VTK's vertex order.
fn orientation(kind: u8, cell: &[u32], points: &[Vec3]) -> f64 {
    let x = |i: usize| points[cell[i] as usize];
    match kind {
        TETRA => (x(1) - x(0)).cross(&(x(2) - x(0))).dot(&(x(3) - x(0))),
        WEDGE => {
            let across = x(3) + x(4) + x(5) - x(0) - x(1) - x(2);
            -(x(1) - x(0)).cross(&(x(2) - x(0))).dot(&across)
        }
        HEXAHEDRON => {
            let across = x(4) + x(5) + x(6) + x(7) - x(0) - x(1) - x(2) - x(3);
            (x(2) - x(0)).cross(&(x(3) - x(1))).dot(&across)
        }
        _ => 0.0,
    }
}

/// Turns a cell of one orientation into the same cell with the other.
fn mirror(kind: u8, cell: &mut [u32]) {
    match kind {
        TETRA => cell.swap(1, 2),
        WEDGE => {
            cell.swap(1, 2);
            cell.swap(4, 5);
        }
        HEXAHEDRON => {
            cell.swap(1, 3);
            cell.swap(5, 7);
        }
        _ => {}
    }
}
