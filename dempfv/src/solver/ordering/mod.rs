//! A fill-reducing ordering for networks whose unknowns have coordinates.
//!
//! Nested dissection by minimum cuts: a part is cut across its longest side by
//! the smallest set of vertices that separates its first from its last, found as
//! a maximum flow inside a band around the median (Schild and Sommer 2015 cut
//! road networks so). What lies apart is ordered apart, then the separator. Small
//! parts are ordered by minimum degree, counting also what is ordered later.
//!
//! When the network has moved a little, its dissection moves along
//! ([`Ordering::follow`]): no flow is computed.
//!
//! The same ordering for any number of threads, and no random numbers.

mod band;
mod block;
mod degree;
mod fill;
mod flow;
mod follow;
mod graph;
mod nearest;
mod tree;

use std::iter::repeat_n;

use super::SymmetricCsc;
use block::Block;
pub use fill::factor_entries;
use graph::Graph;
use nearest::Grid;
use tree::{Size, Tree};

/// Parts of no more vertices than this are ordered by one thread, in place.
const BLOCK: usize = 8192;

/// Orders the unknowns of a matrix by its pattern and one point each (any unit):
/// entry k of the result is the unknown that is eliminated as the k-th.
///
/// The points only decide where a part is cut. Where they do not help (all in one
/// place, or no numbers), distances in the graph take their place.
///
/// ```
/// use dempfv::solver::{SymmetricCsc, ordering};
/// // Three pores in a row.
/// let a = SymmetricCsc {
///     n: 3,
///     col_ptr: vec![0, 2, 4, 5],
///     row_idx: vec![0, 1, 1, 2, 2],
///     values: vec![2.0, -1.0, 2.0, -1.0, 2.0],
/// };
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
/// // An end first: it fills nothing in.
/// assert_eq!(ordering::order(&a, &points), [0, 1, 2]);
/// ```
///
/// # Panics
/// If the matrix is malformed ([`SymmetricCsc::validate`]) or the points are not
/// one per unknown.
pub fn order(a: &SymmetricCsc, points: &[[f64; 3]]) -> Vec<i64> {
    require_points(a, points);
    dissected(Graph::whole(a, points)).0
}

fn require_points(a: &SymmetricCsc, points: &[[f64; 3]]) {
    assert_eq!(points.len(), a.n, "there must be one point per unknown");
}

/// An ordering that remembers where its separators lie.
#[derive(Clone, Debug)]
pub struct Ordering {
    permutation: Vec<i64>,
    tree: Tree,
    /// When the unknown at each point is eliminated.
    turns: Grid,
    /// The part of the dissection that each entry of the permutation is in.
    part: Vec<u32>,
    /// Weight of the separators when they were found.
    weight: f64,
    /// How often the network has moved since then.
    followed: u32,
}

impl Ordering {
    /// As [`order`].
    ///
    /// # Panics
    /// As [`order`].
    pub fn new(a: &SymmetricCsc, points: &[[f64; 3]]) -> Ordering {
        require_points(a, points);
        let (permutation, sizes) = dissected(Graph::whole(a, points));
        let tree = Tree::new(&sizes);
        let weight = tree::weight(&sizes);
        let own = |(label, size): (usize, &Size)| repeat_n(label as u32, size.vertices as usize);
        let part = sizes.iter().enumerate().flat_map(own).collect();
        let points: Vec<_> = points.iter().map(|p| p.map(|x| x as f32)).collect();
        let in_order: Vec<u32> = permutation.iter().map(|&unknown| unknown as u32).collect();
        let turns = turns_at(&points, &in_order);
        Ordering { permutation, tree, turns, part, weight, followed: 0 }
    }

    /// Entry k is the unknown that is eliminated as the k-th.
    pub fn permutation(&self) -> &[i64] {
        &self.permutation
    }
}

/// When the unknown at each point is eliminated: its place among all in that order.
fn turns_at(points: &[[f32; 3]], in_order: &[u32]) -> Grid {
    let mut turns = vec![0; in_order.len()];
    for (turn, &unknown) in in_order.iter().enumerate() {
        turns[unknown as usize] = turn as u32;
    }
    Grid::new(points, &turns)
}

/// The order of a graph, and the parts it was dissected into.
fn dissected(graph: Graph) -> (Vec<i64>, Vec<Size>) {
    let mut permutation = vec![0; graph.len()];
    let sizes = dissect(graph, &mut permutation);
    (permutation, sizes)
}

/// Writes the order of a part: both sides of a cut, then the cut.
fn dissect(graph: Graph, out: &mut [i64]) -> Vec<Size> {
    let mut block = Block::new(graph);
    let cut = if out.len() > BLOCK { block.cut_whole(out) } else { None };
    let Some((left, right)) = cut else {
        return block.order(out);
    };
    let (first, rest) = out.split_at_mut(left.len());
    let (second, separator) = rest.split_at_mut(right.len());
    let (left, right) = rayon::join(|| block.extract(&left), || block.extract(&right));
    drop(block);
    let (mut sizes, others) = rayon::join(|| dissect(left, first), || dissect(right, second));
    sizes.extend(others);
    sizes.push(Size::of_cut(separator.len(), sizes.len()));
    sizes
}
