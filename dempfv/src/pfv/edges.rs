//! The edges of a triangulation: pairs of spheres, and spheres and walls, that are neighbours in the
//! pore network.

use rayon::prelude::*;

use super::frame::FACETS;
use super::{NONE, Network, Tessellation};
use crate::Vec3;

/// Who is whose neighbour, and the areas of the facets between their power cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EdgeList {
    /// The two vertices, the smaller first, so that a wall comes second: edges between spheres and
    /// then those to walls, each sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Area of the facet that is dual to each edge (m²). On a wall it is the part of the wall that is
    /// nearest to the sphere, in terms of power.
    pub area: Vec<f64>,
    /// How many of the edges are between spheres.
    pub between_spheres: usize,
}

impl EdgeList {
    /// The edges of a network that was built of spheres at `position` (m). Each facet between two
    /// pores adds the triangle of an edge and the pores' centres to the areas of its three edges.
    pub fn new(network: &Network, position: &[Vec3]) -> EdgeList {
        let t = &network.tessellation;
        let n = t.spheres;
        let mut parts: Vec<([u32; 2], u32, f64)> = (0..t.cells.len())
            .into_par_iter()
            .flat_map_iter(|i| {
                facets(t, i).flat_map(move |(j, [a, b, c])| {
                    let order = i as u32;
                    [[a, b], [b, c], [c, a]].into_iter().filter_map(move |edge| {
                        let center = [network.center[i], network.center[j]];
                        let part = triangle(network, position, edge, center)?;
                        Some(([edge[0].min(edge[1]), edge[0].max(edge[1])], order, part))
                    })
                })
            })
            .collect();
        // Sums do not depend on who was first: parts of one edge from one pore are at most two, and
        // a stable sort keeps their order.
        parts.par_sort_by_key(|&([a, b], order, _)| (b as usize >= n, a, b, order));
        let mut list = EdgeList::default();
        for (pair, _, part) in parts {
            if list.pairs.last() != Some(&pair) {
                list.pairs.push(pair);
                list.area.push(0.0);
                list.between_spheres += usize::from((pair[1] as usize) < n);
            }
            if let Some(area) = list.area.last_mut() {
                *area += part;
            }
        }
        // A flat pore has the centre of a pore beside it, which may fold a facet.
        list.area.iter_mut().for_each(|area| *area = area.max(0.0));
        list
    }
}

/// The facets that a pore shares with pores of larger numbers: that pore, and the vertices
/// counterclockwise seen from outside.
fn facets(t: &Tessellation, i: usize) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
    let (cell, around) = (&t.cells[i], &t.neighbors[i]);
    (0..4).filter(move |&k| around[k] != NONE && around[k] as usize > i).map(move |k| {
        let facet = FACETS[k].map(|v| cell[v]);
        (around[k] as usize, facet)
    })
}

/// Signed area (m²) of the triangle of an edge and two pore centres, seen along the edge; `None`
/// between two walls.
fn triangle(
    network: &Network,
    position: &[Vec3],
    [a, b]: [u32; 2],
    [p, q]: [Vec3; 2],
) -> Option<f64> {
    let t = &network.tessellation;
    let (from, along) = match (t.wall(a), t.wall(b)) {
        (None, None) => {
            let (x, y) = (position[a as usize], position[b as usize]);
            let apart = y - x;
            (x, apart / apart.norm())
        }
        (None, Some(wall)) => (position[a as usize], -wall.inward_normal()),
        (Some(wall), None) => (position[b as usize], wall.inward_normal()),
        (Some(_), Some(_)) => return None,
    };
    Some(0.5 * along.dot(&(p - from).cross(&(q - from))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfv::{Boundary, Clamp, Fluid};
    use crate::{Aabb, PerWall, WallId};

    /// Spheres of different sizes, not in a lattice (a multiplicative sequence), in a box away from
    /// the origin.
    fn network() -> (Network, Vec<Vec3>, Vec<f64>) {
        let bounds = Aabb { min: Vec3::new(1.0, 2.0, 3.0), max: Vec3::new(2.0, 3.2, 4.1) };
        let part = |k: usize, a: f64| (k as f64 * a).fract();
        let x = |k: usize| Vec3::new(part(k, 0.618_034), part(k, 0.414_214), part(k, 0.732_051));
        let place = |k| bounds.min + bounds.size().component_mul(&(x(k) * 0.8).add_scalar(0.1));
        let position: Vec<Vec3> = (1..=200).map(place).collect();
        let radius: Vec<f64> = (0..200).map(|k| 0.03 + 0.02 * part(k, 0.302_776)).collect();
        let fluid = Fluid {
            viscosity: 1.0,
            slip_walls: true,
            clamp: Clamp::None,
            boundary: Boundary::default(),
        };
        let network = Network::new(&position, &radius, bounds, &fluid).unwrap().0;
        assert!(network.tessellation.hidden.is_empty(), "the premise");
        (network, position, radius)
    }

    /// The power cells fill the box: each facet is the base of two pyramids whose heights are
    /// together the distance of the two. And those on a wall are the wall.
    #[test]
    fn facets_close_the_power_cells() {
        let (network, position, _) = network();
        let list = EdgeList::new(&network, &position);
        let (bounds, n) = (network.bounds, position.len());
        let mut volume = 0.0;
        let mut wall_area = PerWall::<f64>::default();
        for (&[a, b], area) in list.pairs.iter().zip(&list.area) {
            let x = position[a as usize];
            let distance = match network.tessellation.wall(b) {
                None => (position[b as usize] - x).norm(),
                Some(wall) => {
                    wall_area[wall] += area;
                    (x[wall.axis()] - bounds.wall(wall)).abs()
                }
            };
            volume += area * distance / 3.0;
        }
        assert!((volume / bounds.volume() - 1.0).abs() < 1e-12, "{volume} {}", bounds.volume());
        for wall in WallId::ALL {
            let off = wall_area[wall] / bounds.wall_area(wall) - 1.0;
            assert!(off.abs() < 1e-12, "{wall}: {off}");
        }
        let split = list.pairs.iter().position(|p| p[1] as usize >= n).unwrap();
        assert_eq!(split, list.between_spheres);
        assert!(list.pairs[..split].is_sorted() && list.pairs[split..].is_sorted());
    }
}
