//! The dissection of a network that has moved a little: by place, then mended.

use rayon::prelude::*;

use super::super::SymmetricCsc;
use super::graph::Graph;
use super::tree::{self, Size, Tree};
use super::{Ordering, require_points, turns_at};

/// Separators may become so much heavier before they are found anew. By then the
/// factor of a packing has about as much more entries than with an ordering of its own.
const HEAVIER: f64 = 1.12;

/// After so many followings leaves are ordered anew, whose decay no weight tells.
const MOST: u32 = 16;

/// No leaf may hold more of the vertices than this many times its share.
const LARGEST: usize = 8;

impl Ordering {
    /// An ordering of a network that has moved a little since this one was made, and
    /// changed where it had to: `a` and `points` are the new ones, in any numbering.
    ///
    /// Each unknown takes the turn of the nearest old one, and is in the part that this
    /// was in. Where parts that should be separated touch, one of the two unknowns joins
    /// the separator, and leaves it where it separates nothing. A dissection that has
    /// suffered too much is made anew; so may be called at every remesh.
    ///
    /// # Panics
    /// As [`order`](super::order).
    pub fn follow(&self, a: &SymmetricCsc, points: &[[f64; 3]]) -> Ordering {
        require_points(a, points);
        let grown = a.n.max(self.part.len()) > 2 * a.n.min(self.part.len());
        if grown || self.followed >= MOST {
            return Ordering::new(a, points);
        }
        let graph = Graph::whole(a, points);
        // Without an old unknown to follow, last, in the separator of the whole.
        let (last, root) = (self.part.len(), self.tree.len().saturating_sub(1) as u32);
        let (turns, mut labels): (Vec<u32>, Vec<u32>) = graph
            .point
            .par_iter()
            .with_min_len(4096)
            .map(|p| match self.turns.label(p) {
                Some(turn) => (turn, self.part[turn as usize]),
                None => (last as u32, root),
            })
            .unzip();
        mend(&graph, &self.tree, &mut labels);
        let all = (0..a.n as u32).collect();
        let (by_turn, _) = sorted(all, &turns, last + 1);
        let (vertices, start) = sorted(by_turn, &labels, self.tree.len());
        let sizes = sizes(&self.tree, &start);
        let most = LARGEST * (a.n / sizes.len().max(1) + super::block::LEAF);
        let leaves = sizes.iter().filter(|size| size.below == 0);
        let uneven = leaves.clone().any(|size| size.vertices as usize > most);
        if uneven || tree::weight(&sizes) > HEAVIER * self.weight {
            return Ordering::new(a, points);
        }
        let part = vertices.iter().map(|&v| labels[v as usize]).collect();
        Ordering {
            turns: turns_at(&graph.point, &vertices),
            permutation: vertices.into_iter().map(i64::from).collect(),
            tree: self.tree.clone(),
            part,
            weight: self.weight,
            followed: self.followed + 1,
        }
    }
}

/// Moves vertices into separators until no two parts touch that should not, and out
/// of them where they separate nothing.
fn mend(graph: &Graph, tree: &Tree, labels: &mut [u32]) {
    for v in 0..graph.len() {
        for &w in graph.neighbors(v as u32) {
            let (own, other) = (labels[v], labels[w as usize]);
            if !tree.in_line(own, other) {
                // What is high already has less far to go.
                let mover = if own >= other { v } else { w as usize };
                labels[mover] = tree.join(own, other);
            }
        }
    }
    for v in 0..graph.len() {
        let own = labels[v];
        if tree.is_leaf(own) {
            continue;
        }
        let lower = graph.neighbors(v as u32).iter().map(|&w| labels[w as usize]);
        let lower = lower.filter(|&label| label < own);
        if let Some(place) = lower.reduce(|a, b| tree.join(a, b)) {
            labels[v] = place;
        }
    }
}

/// Vertices sorted by label, in their order where labels are the same, and where each
/// label begins.
fn sorted(vertices: Vec<u32>, labels: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; count + 2];
    for &label in labels {
        start[label as usize + 2] += 1;
    }
    for k in 0..count {
        start[k + 2] += start[k + 1];
    }
    let mut out = vec![0; vertices.len()];
    for v in vertices {
        let next = &mut start[labels[v as usize] as usize + 1];
        out[*next as usize] = v;
        *next += 1;
    }
    start.pop();
    (out, start)
}

fn sizes(tree: &Tree, start: &[u32]) -> Vec<Size> {
    let size = |(k, pair): (usize, &[u32])| Size {
        vertices: pair[1] - pair[0],
        below: tree.below(k as u32),
    };
    start.windows(2).enumerate().map(size).collect()
}
