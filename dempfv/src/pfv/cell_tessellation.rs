//! The regular triangulation of a periodic cell of any shape.
//!
//! The spheres are triangulated with copies around the cell, and of each tetrahedron's copies one is
//! kept: the one whose lowest vertex, by coordinates, is in the cell. Across each facet of a kept one
//! must lie the copy of a kept one, and back; then these with all their copies are closed, each two
//! that meet were neighbours in one regular triangulation, and with volumes that add up to the cell's
//! they fill space once: they are the regular triangulation of all copies. Where that fails, the
//! copies did not reach far enough.

use std::collections::HashMap;

use rayon::prelude::*;

use super::cell_copies::{CellCopies, Image};
use super::error::{PoreVertex, PoreVertices};
use super::{NONE, PfvError, Tessellation};
use crate::{Cell, Vec3};

/// How far copies reach at first, in mean spacings of the spheres, beside the largest diameter; and
/// by what it grows where that is not enough.
const MARGIN: f64 = 2.5;
const MORE: f64 = 1.6;
/// Copies that reach farther, in heights of the cell, would not help.
const FARTHEST: f64 = 1.25;
/// Volumes of the pores add up to the cell's within this share.
const WHOLE: f64 = 1e-9;
/// A pore is narrower than this share of the cell along each edge: then the copies of its spheres are
/// the nearest to each other, also when they have moved on.
const WIDEST: f64 = 0.49;

/// A copy of a sphere: its number and which copy, to be compared.
type Vertex = (u32, Image);

/// The tetrahedra of a periodic cell, one of all copies each.
pub(super) struct CellTessellation {
    pub copies: CellCopies,
    /// With the numbers of spheres as vertices.
    pub tessellation: Tessellation,
    /// The same with those of copies: where each tetrahedron really is.
    pub placed: Tessellation,
    /// Which copy of each neighbour it is that a tetrahedron meets.
    pub across: Vec<[Image; 4]>,
}

impl CellTessellation {
    /// Triangulates spheres (m) in a cell of short edges.
    pub fn new(
        position: &[Vec3],
        radius: &[f64],
        cell: &Cell,
    ) -> Result<CellTessellation, PfvError> {
        let spacing = (cell.volume() / position.len() as f64).cbrt();
        let largest = radius.iter().copied().fold(0.0, f64::max);
        let height = cell.heights().into_iter().fold(0.0, f64::max);
        let mut margin = (MARGIN * spacing + 2.0 * largest).min(FARTHEST * height);
        loop {
            let copies = CellCopies::new(position, radius, cell, margin);
            let found = CellTessellation::among(copies, position.len(), cell)?;
            if let Some(found) = found {
                found.check_widths(cell)?;
                return Ok(found);
            }
            if margin >= FARTHEST * height {
                return Err(PfvError::NotPeriodic { spheres: position.len() });
            }
            margin = (MORE * margin).min(FARTHEST * height);
        }
    }

    /// Keeps one copy of each tetrahedron; `None` where these do not close.
    fn among(
        copies: CellCopies,
        spheres: usize,
        cell: &Cell,
    ) -> Result<Option<CellTessellation>, PfvError> {
        let all = Tessellation::new(&copies.frame())?;
        let walls = copies.x.len() as u32;
        let lowest = |cell: &[u32; 4]| {
            let key = |v: &u32| copies.x[*v as usize];
            let below = |a: &Vec3, b: &Vec3| {
                a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
            };
            let inside = cell.iter().all(|&v| v < walls);
            let lowest = || cell.iter().copied().min_by(|a, b| below(&key(a), &key(b)));
            inside.then(lowest).flatten()
        };
        // The copy of the cell that each tetrahedron belongs to.
        let home: Vec<Option<Image>> =
            all.cells.par_iter().map(|c| lowest(c).map(|v| copies.of[v as usize].1)).collect();
        let kept: Vec<usize> = (0..home.len()).filter(|&c| home[c] == Some([0; 3])).collect();
        let known: HashMap<[Vertex; 4], u32> =
            kept.iter().zip(0..).map(|(&c, k)| (name(&copies, &all.cells[c], [0; 3]), k)).collect();
        let beyond = |c: u32| -> Option<(u32, Image)> {
            let image = home.get(c as usize).copied().flatten()?;
            let name = name(&copies, &all.cells[c as usize], image);
            known.get(&name).map(|&k| (k, image))
        };
        let around: Option<Vec<[(u32, Image); 4]>> = kept
            .par_iter()
            .map(|&c| {
                let [a, b, c, d] = all.neighbors[c].map(beyond);
                Some([a?, b?, c?, d?])
            })
            .collect();
        let Some(around) = around.filter(|around| closes(around)) else { return Ok(None) };
        let placed: Vec<[u32; 4]> = kept.iter().map(|&c| all.cells[c]).collect();
        let neighbors: Vec<[u32; 4]> = around.iter().map(|around| around.map(|(k, _)| k)).collect();
        let hidden = all.hidden.into_iter().filter(|&v| (v as usize) < spheres).collect();
        let numbers = |cell: &[u32; 4]| cell.map(|v| copies.of[v as usize].0);
        let tessellation = Tessellation {
            spheres,
            cells: placed.iter().map(numbers).collect(),
            neighbors: neighbors.clone(),
            hidden,
        };
        let placed =
            Tessellation { spheres: copies.x.len(), cells: placed, neighbors, hidden: vec![] };
        let across = around.iter().map(|around| around.map(|(_, image)| image)).collect();
        let found = CellTessellation { copies, tessellation, placed, across };
        let whole = (found.volume() / cell.volume() - 1.0).abs() < WHOLE;
        Ok(whole.then_some(found))
    }

    /// Volume of all kept tetrahedra (m³).
    fn volume(&self) -> f64 {
        let x = |v: u32| self.copies.x[v as usize];
        let six = |&[a, b, c, d]: &[u32; 4]| {
            let (b, c, d) = (x(b) - x(a), x(c) - x(a), x(d) - x(a));
            b.dot(&c.cross(&d))
        };
        self.placed.cells.iter().map(six).sum::<f64>() / 6.0
    }

    /// Refuses pores that reach through half of the cell.
    fn check_widths(&self, cell: &Cell) -> Result<(), PfvError> {
        for (placed, numbers) in self.placed.cells.iter().zip(&self.tessellation.cells) {
            let at = placed.map(|v| cell.fractions(&self.copies.x[v as usize]));
            for edge in 0..3 {
                let (low, high) =
                    at.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| {
                        (l.min(f[edge]), h.max(f[edge]))
                    });
                if high - low > WIDEST {
                    let vertices = PoreVertices(numbers.map(PoreVertex::Sphere));
                    return Err(PfvError::WidePore { vertices, share: high - low });
                }
            }
        }
        Ok(())
    }
}

/// What tells a tetrahedron from all but its copies: its vertices as they are in the copy of the cell
/// that it belongs to, in order.
fn name(copies: &CellCopies, cell: &[u32; 4], home: Image) -> [Vertex; 4] {
    let mut name = cell.map(|v| {
        let (sphere, image) = copies.of[v as usize];
        (sphere, [0, 1, 2].map(|k| image[k] - home[k]))
    });
    name.sort_unstable();
    name
}

/// Whether each neighbour has the tetrahedron for its own, on the way back.
fn closes(around: &[[(u32, Image); 4]]) -> bool {
    around.iter().zip(0u32..).all(|(neighbors, i)| {
        neighbors
            .iter()
            .all(|(j, image)| *j != NONE && around[*j as usize].contains(&(i, image.map(|n| -n))))
    })
}
