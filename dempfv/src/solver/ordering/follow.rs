//! The dissection of a network that has moved a little: by place, then mended.

use rayon::prelude::*;

use super::super::SymmetricCsc;
use super::degree::Leaf;
use super::graph::Graph;
use super::nearest::Grid;
use super::tree::{self, Size, Tree};
use super::{Ordering, require_points};

/// Separators may become so much heavier before they are found anew.
const HEAVIER: f64 = 1.2;

/// No leaf may hold more of the vertices than this many times its share.
const LARGEST: usize = 8;

/// Leaves that a thread takes at a time.
const BATCH: usize = 32;

impl Ordering {
    /// An ordering of a network that has moved a little since this one was made, and
    /// changed where it had to: `a` and `points` are the new ones, in any numbering.
    ///
    /// Each unknown goes to the part that the nearest old one was in. Where parts that
    /// should be separated touch, one of the two unknowns joins the separator, and
    /// leaves it where it separates nothing. A dissection that has suffered too much
    /// is made anew; so may be called at every remesh.
    ///
    /// # Panics
    /// As [`order`](super::order).
    pub fn follow(&self, a: &SymmetricCsc, points: &[[f64; 3]]) -> Ordering {
        require_points(a, points);
        let graph = Graph::whole(a, points);
        let root = self.tree.len().saturating_sub(1) as u32;
        let mut labels: Vec<u32> = graph
            .point
            .par_iter()
            .with_min_len(4096)
            .map(|p| self.parts.label(p).unwrap_or(root))
            .collect();
        mend(&graph, &self.tree, &mut labels);
        let (mut vertices, start) = sorted(&labels, self.tree.len());
        let sizes = sizes(&self.tree, &start);
        let most = LARGEST * (a.n / sizes.len().max(1) + super::block::LEAF);
        let leaves = sizes.iter().filter(|size| size.below == 0);
        let uneven = leaves.clone().any(|size| size.vertices as usize > most);
        if uneven || tree::weight(&sizes) > HEAVIER * self.weight {
            return Ordering::new(a, points);
        }
        order_leaves(&graph, &self.tree, &labels, &start, &mut vertices);
        Ordering {
            permutation: vertices.into_iter().map(i64::from).collect(),
            tree: self.tree.clone(),
            parts: Grid::new(&graph.point, &labels),
            weight: self.weight,
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

/// The vertices sorted by label, and where each label begins.
fn sorted(labels: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; count + 2];
    for &label in labels {
        start[label as usize + 2] += 1;
    }
    for k in 0..count {
        start[k + 2] += start[k + 1];
    }
    let mut vertices = vec![0; labels.len()];
    for (v, &label) in labels.iter().enumerate() {
        let next = &mut start[label as usize + 1];
        vertices[*next as usize] = v as u32;
        *next += 1;
    }
    start.pop();
    (vertices, start)
}

fn sizes(tree: &Tree, start: &[u32]) -> Vec<Size> {
    let size = |(k, pair): (usize, &[u32])| Size {
        vertices: pair[1] - pair[0],
        below: tree.below(k as u32),
    };
    start.windows(2).enumerate().map(size).collect()
}

/// Sorts the vertices of each leaf by minimum degree.
fn order_leaves(graph: &Graph, tree: &Tree, labels: &[u32], start: &[u32], vertices: &mut [u32]) {
    let mut rest = vertices;
    let mut leaves = Vec::new();
    for (label, pair) in (0..).zip(start.windows(2)) {
        let (part, others) = rest.split_at_mut((pair[1] - pair[0]) as usize);
        rest = others;
        if tree.is_leaf(label) && !part.is_empty() {
            leaves.push((label, part));
        }
    }
    leaves.par_chunks_mut(BATCH).for_each_init(
        || (Leaf::default(), vec![0; graph.len()]),
        |(leaf, number), batch| {
            for (label, part) in batch {
                leaf.order(graph, part, labels, *label, number);
            }
        },
    );
}
