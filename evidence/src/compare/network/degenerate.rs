//! Pores that only one of the two programs has: is it the packing that leaves the choice?

use dempfv::pfv::{NONE, Network};
use serde::{Deserialize, Serialize};

use super::case::Packing;
use super::difference::walls;
use super::theirs::Match;

/// Five points are cospherical where the powers agree to this share of the square of the
/// distance between the pore's centre and its spheres.
const COSPHERICAL: f64 = 1e-6;
/// So many are listed.
const LISTED: usize = 20;

/// Pores that only one program has.
#[derive(Clone, Serialize, Deserialize)]
pub struct Differing {
    /// Number of pores that only one of the two has.
    pub count: usize,
    /// Of ours among them, those with a fifth vertex on the sphere around the other four: any
    /// choice between the triangulations of such a cluster is right.
    pub degenerate: usize,
    /// Of ours among them, those that are not.
    pub unexplained: usize,
    /// Vertices of the first ones of ours.
    pub pores: Vec<[u32; 4]>,
}

impl Differing {
    /// Looks at the pores that YADE does not have.
    pub fn new(packing: &Packing, network: &Network, matched: &Match) -> Differing {
        let (degenerate, other): (Vec<_>, Vec<_>) =
            matched.only_ours().partition(|&i| is_degenerate(packing, network, i));
        let cells = &network.tessellation.cells;
        Differing {
            count: matched.differing(),
            degenerate: degenerate.len(),
            unexplained: other.len(),
            pores: matched.only_ours().take(LISTED).map(|i| cells[i]).collect(),
        }
    }

    /// Why the pores may differ, if the packing leaves the choice in each case.
    pub fn explanation(&self) -> Option<String> {
        let shown = self.count > 0 && self.unexplained == 0 && self.degenerate > 0;
        shown.then(|| {
            format!(
                "each of the {} pores of ours among them has a fifth vertex on the sphere around its \
                 four: the packing is degenerate there, and every triangulation is right",
                self.degenerate
            )
        })
    }
}

/// Whether the vertex across one of a pore's facets has the pore's own power, or a wall
/// passes through its centre.
fn is_degenerate(packing: &Packing, network: &Network, pore: usize) -> bool {
    let t = &network.tessellation;
    let (cell, center) = (t.cells[pore], network.center[pore]);
    let power = |v: u32| {
        let (x, r) = (packing.position.get(v as usize)?, packing.radius[v as usize]);
        Some(((center - x).norm_squared() - r * r, (center - x).norm_squared()))
    };
    let Some((own, size)) = cell.iter().find_map(|&v| power(v)) else { return false };
    let across = t.neighbors[pore].into_iter().filter(|&j| j != NONE);
    let mut vertices = across.flat_map(|j| t.cells[j as usize]).filter(|v| !cell.contains(v));
    vertices.any(|v| match (power(v), t.wall(v)) {
        (Some((there, _)), _) => (there - own).abs() <= COSPHERICAL * size,
        (None, Some(wall)) if walls(network, pore) < 3 => {
            let away = center[wall.axis()] - packing.bounds.wall(wall);
            away * away <= COSPHERICAL * size
        }
        _ => false,
    })
}
