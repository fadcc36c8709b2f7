//! From spheres and walls to cells: the only place where a wall is a sphere.

use rayon::prelude::*;

use super::error::{PfvError, PoreVertex, PoreVertices};
use super::frame::Frame;
use super::slabs;
use crate::{WallId, calls};

/// In neighbour lists: nothing lies there.
pub const NONE: u32 = u32::MAX;

/// Radius of the sphere that stands in for a wall, in units of the largest box
/// edge. YADE takes as many times the edge along y: in boxes where that is the
/// largest, cubes among them, both find the same cells.
const WALL_RADIUS: f64 = 50_000.0;

/// From this ratio of edges on the radius grows with the ratio: a sphere of that radius would bulge
/// by the thickness of the box.
const FLAT_BOX: f64 = 10.0;

/// Most that the radius grows: a plane at the end of so long a radius is known to 4e-9 of the box's
/// largest edge.
const MOST_GROWTH: f64 = 500.0;

/// The regular triangulation of spheres and walls: the finite tetrahedra.
///
/// Vertices `0..n` are the spheres, `n..n + 6` the walls in the order of
/// [`WallId::ALL`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Number of spheres `n`.
    pub spheres: usize,
    /// Vertices of each cell, positively oriented; cells in spatial order.
    pub cells: Vec<[u32; 4]>,
    /// Per cell and vertex the cell across the opposite facet, or [`NONE`].
    pub neighbors: Vec<[u32; 4]>,
    /// Spheres whose power cell is empty: they are no vertex of any pore.
    pub hidden: Vec<u32>,
}

impl Tessellation {
    /// Triangulates the spheres and the six walls of the frame.
    pub(super) fn new(frame: &Frame) -> Result<Self, PfvError> {
        let spheres = frame.spheres();
        if spheres == 0 {
            return Err(PfvError::NoSpheres);
        }
        calls::count(&calls::TRIANGULATIONS);
        let raw = slabs::triangulate(&weighted_points(frame), spheres, frame.size)
            .map_err(|e| PfvError::Triangulation { spheres, reason: e.to_string() })?;
        let order = spatial_order(&raw.cells, frame);
        let mut rank = vec![0u32; order.len()];
        for (new, &old) in order.iter().enumerate() {
            rank[old as usize] = new as u32;
        }
        let renumber = |c: u32| if c == NONE { NONE } else { rank[c as usize] };
        Ok(Tessellation {
            spheres,
            cells: order.par_iter().map(|&c| raw.cells[c as usize]).collect(),
            neighbors: order.par_iter().map(|&c| raw.neighbors[c as usize].map(renumber)).collect(),
            hidden: raw.hidden,
        })
    }

    /// The wall that a vertex stands for, if it is one.
    pub fn wall(&self, vertex: u32) -> Option<WallId> {
        (vertex as usize).checked_sub(self.spheres).and_then(|w| WallId::ALL.get(w).copied())
    }

    /// The vertices of a cell, for messages.
    pub(super) fn vertices_of(&self, cell: u32) -> PoreVertices {
        PoreVertices(self.cells[cell as usize].map(|v| match self.wall(v) {
            Some(wall) => PoreVertex::Wall(wall),
            None => PoreVertex::Sphere(v),
        }))
    }
}

fn weighted_points(frame: &Frame) -> Vec<[f64; 4]> {
    let flatness = frame.size.max() / frame.size.min();
    let growth = (flatness / FLAT_BOX).clamp(1.0, MOST_GROWTH);
    let big = WALL_RADIUS * growth * frame.size.max();
    let middle = 0.5 * frame.size;
    let spheres = frame.x.iter().zip(frame.r).map(|(x, r)| [x.x, x.y, x.z, r * r]);
    let walls = WallId::ALL.map(|wall| {
        let mut c = middle;
        c[wall.axis()] = frame.plane(wall) - wall.inward() * big;
        [c.x, c.y, c.z, big * big]
    });
    spheres.chain(walls).collect()
}

/// Cells sorted along a Morton curve through the centroids of their spheres.
fn spatial_order(cells: &[[u32; 4]], frame: &Frame) -> Vec<u32> {
    let scale = frame.size.map(|s| f64::from(1u32 << 21) / s);
    let mut keyed: Vec<(u64, u32)> = (0..cells.len() as u32)
        .into_par_iter()
        .map(|c| {
            let spheres = cells[c as usize].iter().filter_map(|&v| frame.x.get(v as usize));
            let (sum, count) =
                spheres.fold((crate::Vec3::zeros(), 0.0), |(s, k), x| (s + x, k + 1.0));
            let at = (sum / f64::max(count, 1.0)).component_mul(&scale);
            let key = (0..3).map(|a| spread(at[a] as u64) << a).fold(0, |k, bits| k | bits);
            (key, c)
        })
        .collect();
    // Cells of one centroid, at walls, in the order of their vertices.
    let vertices = |c: u32| cells[c as usize];
    keyed
        .par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| vertices(a.1).cmp(&vertices(b.1))));
    keyed.into_iter().map(|(_, c)| c).collect()
}

/// Moves the lowest 21 bits of a number three places apart.
fn spread(v: u64) -> u64 {
    let mut v = v.min((1 << 21) - 1);
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}
