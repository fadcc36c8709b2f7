//! The regular triangulation slab by slab, one thread for each.
//!
//! Every slab is triangulated with its surroundings and keeps the cells whose
//! middle lies within it. What comes out is certain, however thin the
//! surroundings are. Where two slabs meet, each names the pairs of cells that
//! touch there; they must name the same ones. Then all facets are shared by two
//! cells or lie on the hull, which is made of walls: positively oriented cells
//! with this boundary cover the hull once. Each two neighbours were neighbours
//! in one regular triangulation, so the union is regular across every facet,
//! and hence as a whole. A sphere that is hidden in a slab is hidden by fewer
//! spheres than there are. Ties are broken by CGAL by the points' coordinates
//! and not by their order, so that there is one regular triangulation to find,
//! and the number of slabs does not show. Where any of this fails, everything
//! is triangulated at once.

use std::collections::HashMap;

use cgal_sys::{Error, NONE, Triangulation};
use rayon::prelude::*;

use crate::Vec3;

/// Fewest spheres of a slab: with fewer its surroundings cost more than the
/// other threads save.
const SLAB: usize = 2_500;

/// Width of a slab's surroundings in units of the spheres' mean spacing. Settled
/// packings need 1.5, random points 2.5; where voids are wider, at the surface
/// of a heap for one, slabs do not fit and the work is done twice.
const SURROUNDINGS: f64 = 2.5;

/// A neighbour that another slab keeps.
const ACROSS: u32 = NONE - 1;

/// Triangulates weighted points (x, y, z and weight): spheres inside a box of
/// this size, then walls around it. The order of the cells is arbitrary; that of
/// a cell's vertices is the ascending one, save the last two where orientation
/// demands.
pub(super) fn triangulate(
    points: &[[f64; 4]],
    spheres: usize,
    size: Vec3,
) -> Result<Triangulation, Error> {
    let slabs = rayon::current_num_threads().min(spheres / SLAB);
    let mut whole = match Slabs::new(points, spheres, size, slabs).triangulate() {
        Some(whole) => whole,
        None => {
            let mut whole = cgal_sys::triangulate(points)?;
            sort_all(&mut whole);
            whole
        }
    };
    if show_first_twins(&mut whole, points) {
        sort_all(&mut whole);
    }
    Ok(whole)
}

fn sort_all(t: &mut Triangulation) {
    (&mut t.cells, &mut t.neighbors).into_par_iter().for_each(|(c, n)| sort(c, n));
}

/// Of points that coincide in all their numbers CGAL hides all but one, and
/// which one depends on the order of insertion. Makes it the first; returns
/// whether there were any.
fn show_first_twins(t: &mut Triangulation, points: &[[f64; 4]]) -> bool {
    let at = |v: u32| points[v as usize].map(|x| x + 0.0).map(f64::to_bits);
    let mut twins: HashMap<[u64; 4], u32> = HashMap::new();
    // From the last to the first, so that the first stays.
    twins.extend(t.hidden.iter().rev().map(|&v| (at(v), v)));
    if twins.is_empty() {
        return false;
    }
    let mut swaps: HashMap<u32, u32> = HashMap::new();
    for v in (0..points.len() as u32).filter(|v| t.hidden.binary_search(v).is_err()) {
        if let Some(&twin) = twins.get(&at(v)).filter(|twin| **twin < v) {
            swaps.insert(v, twin);
        }
    }
    for v in t.cells.as_flattened_mut() {
        *v = swaps.get(v).copied().unwrap_or(*v);
    }
    let shown: HashMap<u32, u32> = swaps.iter().map(|(&v, &twin)| (twin, v)).collect();
    t.hidden.iter_mut().for_each(|v| *v = shown.get(v).copied().unwrap_or(*v));
    t.hidden.sort_unstable();
    !swaps.is_empty()
}

/// Sorts a cell's vertices and keeps its orientation.
fn sort(cell: &mut [u32; 4], neighbors: &mut [u32; 4]) {
    let mut odd = false;
    for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
        if cell[a] > cell[b] {
            cell.swap(a, b);
            neighbors.swap(a, b);
            odd = !odd;
        }
    }
    if odd {
        cell.swap(2, 3);
        neighbors.swap(2, 3);
    }
}

struct Slabs<'a> {
    points: &'a [[f64; 4]],
    spheres: usize,
    axis: usize,
    /// Where the slabs begin and end along the axis.
    bounds: Vec<f64>,
    surroundings: f64,
}

/// What one slab keeps.
#[derive(Default)]
struct Piece {
    cells: Vec<[u32; 4]>,
    /// Among the slab's own cells.
    neighbors: Vec<[u32; 4]>,
    hidden: Vec<u32>,
    seams: Vec<Seam>,
    /// Facets with nothing beyond.
    hull: Vec<[u32; 3]>,
}

/// A facet between a cell of this slab and one of another.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Seam {
    facet: [u32; 3],
    /// The vertices opposite the facet, in ascending order.
    apexes: [u32; 2],
    apex: u32,
    cell: u32,
    place: u8,
}

impl<'a> Slabs<'a> {
    /// Slabs of as many spheres each, across the longest edge.
    fn new(points: &'a [[f64; 4]], spheres: usize, size: Vec3, slabs: usize) -> Slabs<'a> {
        let axis = size.imax();
        let mut along: Vec<f64> = points[..spheres].iter().map(|p| p[axis]).collect();
        let mut bounds = vec![f64::NEG_INFINITY];
        for cut in 1..slabs {
            let place = cut * spheres / slabs;
            bounds.push(*along.select_nth_unstable_by(place, f64::total_cmp).1);
        }
        bounds.push(f64::INFINITY);
        let surroundings = SURROUNDINGS * (size.product() / spheres as f64).cbrt();
        Slabs { points, spheres, axis, bounds, surroundings }
    }

    /// `None` where slabs would not pay or do not fit together.
    fn triangulate(&self) -> Option<Triangulation> {
        if self.bounds.len() < 3 {
            return None;
        }
        let pieces = self.bounds.par_windows(2).map(|bounds| self.piece(bounds[0], bounds[1]));
        self.join(pieces.collect::<Option<Vec<Piece>>>()?)
    }

    fn piece(&self, from: f64, to: f64) -> Option<Piece> {
        let near = |p: &[f64; 4]| {
            let reach = self.surroundings + p[3].sqrt();
            p[self.axis] + reach >= from && p[self.axis] - reach < to
        };
        let spheres = (0..self.spheres as u32).filter(|&i| near(&self.points[i as usize]));
        let ids: Vec<u32> = spheres.chain(self.spheres as u32..self.points.len() as u32).collect();
        let points: Vec<[f64; 4]> = ids.iter().map(|&i| self.points[i as usize]).collect();
        let Triangulation { mut cells, mut neighbors, hidden } =
            cgal_sys::triangulate(&points).ok()?;
        let hidden = hidden.into_iter().map(|i| ids[i as usize]).collect();
        let mut piece = Piece { hidden, ..Piece::default() };
        let mut kept = vec![ACROSS; cells.len()];
        for (c, cell) in cells.iter_mut().enumerate() {
            *cell = cell.map(|i| ids[i as usize]);
            sort(cell, &mut neighbors[c]);
            if self.keeps(cell, from, to) {
                kept[c] = piece.cells.len() as u32;
                piece.cells.push(*cell);
            }
        }
        for c in (0..cells.len()).filter(|&c| kept[c] != ACROSS) {
            let around = neighbors[c].map(|n| if n == NONE { NONE } else { kept[n as usize] });
            for place in (0..4).filter(|&place| around[place] >= ACROSS) {
                let facet = facet(cells[c], place);
                if around[place] == NONE {
                    piece.hull.push(facet);
                    continue;
                }
                let beyond = cells[neighbors[c][place] as usize];
                let apex = cells[c][place];
                let other = beyond.into_iter().find(|v| !facet.contains(v))?;
                let apexes = [apex.min(other), apex.max(other)];
                piece.seams.push(Seam { facet, apexes, apex, cell: kept[c], place: place as u8 });
            }
            piece.neighbors.push(around);
        }
        Some(piece)
    }

    /// Whether the middle of a cell's spheres lies within the bounds: the same
    /// bits in each slab, because the vertices are sorted.
    fn keeps(&self, cell: &[u32; 4], from: f64, to: f64) -> bool {
        let spheres = cell.iter().filter(|&&v| (v as usize) < self.spheres);
        let (sum, count) = spheres
            .fold((0.0, 0.0), |(s, n), &v| (s + self.points[v as usize][self.axis], n + 1.0));
        sum >= from * count && sum < to * count
    }

    /// Joins the pieces; `None` if they do not fit.
    fn join(&self, pieces: Vec<Piece>) -> Option<Triangulation> {
        let mut whole = Triangulation::default();
        let (mut seams, mut hull, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for piece in pieces {
            let first = u32::try_from(whole.cells.len()).ok()?;
            let shift = |n: u32| if n >= ACROSS { n } else { first + n };
            whole.cells.extend(piece.cells);
            whole.neighbors.extend(piece.neighbors.into_iter().map(|around| around.map(shift)));
            seams.extend(piece.seams.into_iter().map(|s| Seam { cell: first + s.cell, ..s }));
            hull.extend(piece.hull);
            known.extend(piece.hidden);
        }
        seams.sort_unstable();
        let (pairs, rest) = seams.as_chunks::<2>();
        let fit =
            |[a, b]: &[Seam; 2]| a.facet == b.facet && a.apexes == b.apexes && a.apex != b.apex;
        let twice = pairs.windows(2).any(|w| w[0][0].facet == w[1][0].facet);
        if !rest.is_empty() || twice || !pairs.iter().all(fit) || !self.is_octahedron(hull) {
            return None;
        }
        for [a, b] in pairs {
            whole.neighbors[a.cell as usize][a.place as usize] = b.cell;
            whole.neighbors[b.cell as usize][b.place as usize] = a.cell;
        }
        whole.hidden = self.hidden(&whole.cells, &known)?;
        Some(whole)
    }

    /// Whether a hull is that of six walls: a facet for each choice of three.
    fn is_octahedron(&self, mut hull: Vec<[u32; 3]>) -> bool {
        hull.sort_unstable();
        hull.dedup();
        let walls = hull.as_flattened().iter().all(|&v| v as usize >= self.spheres);
        hull.len() == 8 && walls
    }

    /// Points that are no vertex; `None` if no slab knows one of them.
    fn hidden(&self, cells: &[[u32; 4]], known: &[u32]) -> Option<Vec<u32>> {
        const VERTEX: u8 = 2;
        let mut state = vec![0u8; self.points.len()];
        known.iter().for_each(|&v| state[v as usize] = 1);
        cells.as_flattened().iter().for_each(|&v| state[v as usize] = VERTEX);
        let hidden = (0..state.len() as u32).filter(|&v| state[v as usize] != VERTEX);
        hidden.map(|v| (state[v as usize] == 1).then_some(v)).collect()
    }
}

/// The vertices of a facet, in ascending order.
fn facet(cell: [u32; 4], place: usize) -> [u32; 3] {
    let mut facet = [0; 3];
    let others = (0..4).filter(|&k| k != place);
    facet.iter_mut().zip(others).for_each(|(v, k)| *v = cell[k]);
    facet.sort_unstable();
    facet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six huge spheres for walls around a box, as the tessellation makes them.
    fn walled(mut points: Vec<[f64; 4]>, size: Vec3) -> Vec<[f64; 4]> {
        let big = 50_000.0 * size.max();
        for wall in 0..6 {
            let mut p = [0.5 * size.x, 0.5 * size.y, 0.5 * size.z, big * big];
            p[wall / 2] = if wall % 2 == 0 { -big } else { size[wall / 2] + big };
            points.push(p);
        }
        points
    }

    /// Overlapping spheres of many sizes: about one in ten is hidden.
    fn crowd(count: usize, size: Vec3) -> Vec<[f64; 4]> {
        let mut state = 7u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let spheres = (0..count).map(|_| {
            let r = 0.02 + 0.1 * next().powi(4);
            [size.x * next(), size.y * next(), size.z * next(), r * r]
        });
        walled(spheres.collect(), size)
    }

    /// A cell and those across its facets.
    type Surrounded = ([u32; 4], [Option<[u32; 4]>; 4]);

    fn sorted(t: Triangulation) -> (Vec<Surrounded>, Vec<u32>) {
        let beyond = |n: u32| (n != NONE).then(|| t.cells[n as usize]);
        let mut cells: Vec<_> =
            t.cells.iter().zip(&t.neighbors).map(|(&c, n)| (c, n.map(beyond))).collect();
        cells.sort_unstable();
        (cells, t.hidden)
    }

    /// Cells, neighbours and hidden points of a triangulation by slabs are
    /// those of the whole one.
    fn assert_same(points: &[[f64; 4]], size: Vec3) {
        let spheres = points.len() - 6;
        let mut whole = cgal_sys::triangulate(points).unwrap();
        sort_all(&mut whole);
        let whole = sorted(whole);
        for slabs in [2, 3, 5] {
            let mut parts = Slabs::new(points, spheres, size, slabs);
            // Wide voids between random points.
            parts.surroundings *= 2.0;
            let parts = parts.triangulate().unwrap_or_else(|| panic!("{slabs} slabs do not fit"));
            assert_eq!(sorted(parts), whole, "{slabs} slabs");
        }
    }

    #[test]
    fn slabs_are_the_whole() {
        let size = Vec3::new(1.0, 2.0, 1.0);
        let points = crowd(4_000, size);
        assert!(cgal_sys::triangulate(&points).unwrap().hidden.len() > 100);
        assert_same(&points, size);
    }

    /// Every eight neighbours lie on one sphere, and the cuts go through layers:
    /// ties everywhere.
    #[test]
    fn slabs_of_a_lattice_are_the_whole() {
        let n = 12;
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        let points = (0..n * n * n).map(|i| [at(i % n), at(i / n % n), at(i / n / n), 1.6e-3]);
        assert_same(&walled(points.collect(), Vec3::repeat(1.0)), Vec3::repeat(1.0));
    }

    /// A sphere as large as a slab is seen by all slabs that it reaches into.
    #[test]
    fn slabs_with_a_boulder_are_the_whole() {
        let size = Vec3::new(2.0, 1.0, 1.0);
        let mut points = crowd(3_000, size);
        points[0] = [1.1, 0.5, 0.5, 0.09];
        assert_same(&points, size);
    }

    /// With no surroundings to speak of, cells at the cut are wrong; that shows.
    #[test]
    fn slabs_that_do_not_fit_are_found_out() {
        let size = Vec3::repeat(1.0);
        let points = crowd(2_000, size);
        let mut slabs = Slabs::new(&points, 2_000, size, 2);
        slabs.surroundings = 0.0;
        assert!(slabs.triangulate().is_none());
    }

    /// Coincident spheres: the first is the vertex, whoever was inserted first.
    #[test]
    fn of_twins_the_first_is_shown() {
        let size = Vec3::repeat(1.0);
        let mut points = crowd(300, size);
        let shown: Vec<u32> = {
            let hidden = cgal_sys::triangulate(&points).unwrap().hidden;
            (0..300).filter(|v| !hidden.contains(v)).take(40).collect()
        };
        let twins: Vec<[f64; 4]> = shown.iter().map(|&v| points[v as usize]).collect();
        points.splice(300..300, [twins.clone(), twins].concat());
        let t = triangulate(&points, 380, size).unwrap();
        assert!((300..380).all(|v| t.hidden.contains(&v)));
        assert!(shown.iter().all(|v| !t.hidden.contains(v)));
        assert!(t.cells.iter().all(|c| c[0] < c[1] && c[1] < c[2].min(c[3])));
    }
}
