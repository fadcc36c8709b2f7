//! Cuts a part of the graph in place, again and again, with one set of work arrays.

use super::band::{self, Range};
use super::graph::Graph;
use super::max_flow::{MaxFlow, Side};
use super::minimum_degree::MinimumDegree;

/// Parts of no more vertices than this are not cut.
pub(super) const LEAF_VERTICES: usize = 128;

/// Neither side of a cut may hold more than this of a part.
const MAX_SIDE_FRACTION: f64 = 0.9;

/// The label of what is ordered later: separators and what is around the graph.
const LATER: u32 = 0;
/// The label of all other vertices at first.
const WHOLE: u32 = 1;

/// A graph, and to which part of it each vertex belongs now.
pub(super) struct Dissection {
    graph: Graph,
    /// The part of each vertex, those around included.
    label: Vec<u32>,
    /// The last label that was given.
    labels: u32,
    /// Number of a vertex in the part, the band or the leaf that is looked at.
    number: Vec<u32>,
    /// Of each vertex of a part, where it lies along the axis.
    keys: Vec<f32>,
    counts: Vec<u32>,
    band: Vec<u32>,
    flow: MaxFlow,
    /// Of each vertex of the band, its place in the list of the part.
    place: Vec<u32>,
    sides: Vec<Side>,
    /// Vertices that are set aside or wait.
    queue: Vec<u32>,
    leaf: MinimumDegree,
}

/// A part that was cut.
struct Cut {
    /// Labels of the sides.
    labels: [u32; 2],
    /// Vertices on the sides.
    sizes: [usize; 2],
}

impl Dissection {
    pub(super) fn new(graph: Graph) -> Dissection {
        let n = graph.len();
        let mut label = vec![LATER; n + graph.halo];
        label[..n].fill(WHOLE);
        Dissection {
            number: vec![0; n + graph.halo],
            graph,
            label,
            labels: WHOLE,
            keys: Vec::new(),
            counts: Vec::new(),
            band: Vec::new(),
            flow: MaxFlow::default(),
            place: Vec::new(),
            sides: Vec::new(),
            queue: Vec::new(),
            leaf: MinimumDegree::default(),
        }
    }

    fn all(&self) -> Vec<u32> {
        (0..self.graph.len() as u32).collect()
    }

    /// Some of the vertices as a graph of their own.
    pub(super) fn extract(&self, vertices: &[u32]) -> Graph {
        self.graph.part(vertices)
    }

    /// Orders all vertices.
    pub(super) fn order(&mut self, out: &mut [i64]) {
        self.dissect(&mut self.all(), WHOLE, out);
    }

    /// Cuts the whole once: the vertices of both sides. The cut is written to the
    /// end of `out`. `None` where no cut is worth it.
    pub(super) fn cut_whole(&mut self, out: &mut [i64]) -> Option<(Vec<u32>, Vec<u32>)> {
        let mut left = self.all();
        let sizes = self.cut(&mut left, WHOLE)?.sizes;
        let separator = left.split_off(sizes[0] + sizes[1]);
        self.write(&separator, &mut out[left.len()..]);
        let right = left.split_off(sizes[0]);
        Some((left, right))
    }

    fn write(&self, vertices: &[u32], out: &mut [i64]) {
        for (place, &v) in out.iter_mut().zip(vertices) {
            *place = i64::from(self.graph.unknown[v as usize]);
        }
    }

    /// Orders the vertices of a part.
    fn dissect(&mut self, vertices: &mut [u32], label: u32, out: &mut [i64]) {
        let cut = if vertices.len() > LEAF_VERTICES { self.cut(vertices, label) } else { None };
        let Some(cut) = cut else {
            let Dissection { graph, label: labels, number, leaf, .. } = self;
            leaf.order(graph, vertices, labels, label, number);
            self.write(vertices, out);
            return;
        };
        let (left, rest) = vertices.split_at_mut(cut.sizes[0]);
        let (right, separator) = rest.split_at_mut(cut.sizes[1]);
        let (first, rest) = out.split_at_mut(left.len());
        let (second, last) = rest.split_at_mut(right.len());
        self.write(separator, last);
        self.dissect(left, cut.labels[0], first);
        self.dissect(right, cut.labels[1], second);
    }

    /// Cuts a part: sorts its vertices into both sides and the separator and gives
    /// the sides labels of their own. `None`, and the label as it was, where no cut
    /// is worth it.
    fn cut(&mut self, vertices: &mut [u32], label: u32) -> Option<Cut> {
        let axis = band::axis(&self.graph.point, vertices);
        let cut = axis.and_then(|(axis, range)| {
            self.keys.clear();
            let point = |&v: &u32| self.graph.point[v as usize][axis];
            self.keys.extend(vertices.iter().map(point));
            self.cut_by_keys(vertices, &range)
        });
        cut.or_else(|| {
            self.rank(vertices);
            let range = Range { low: 0.0, high: vertices.len() as f32 };
            self.cut_by_keys(vertices, &range)
        })
        .or_else(|| {
            self.relabel(vertices, label);
            None
        })
    }

    fn relabel(&mut self, vertices: &[u32], label: u32) {
        for &v in vertices {
            self.label[v as usize] = label;
        }
    }

    /// Takes for keys the order in which a breadth first search from a far end of
    /// the part meets the vertices.
    fn rank(&mut self, vertices: &[u32]) {
        let far = self.search(vertices, 0);
        self.search(vertices, far);
        self.keys.clear();
        self.keys.resize(vertices.len(), 0.0);
        for (rank, &v) in self.queue.iter().enumerate() {
            self.keys[self.number[v as usize] as usize] = rank as f32;
        }
    }

    /// Searches a part from one of its vertices, then from the first that is left,
    /// and so on. Leaves the vertices in `queue`, and returns the last one's place
    /// in the list.
    fn search(&mut self, vertices: &[u32], first: usize) -> usize {
        self.labels += 2;
        let (fresh, seen) = (self.labels - 1, self.labels);
        self.relabel(vertices, fresh);
        let Dissection { graph, label, number, queue, .. } = self;
        for (k, &v) in vertices.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        queue.clear();
        let mut head = 0;
        for &root in std::iter::once(&vertices[first]).chain(vertices) {
            if label[root as usize] == fresh {
                label[root as usize] = seen;
                queue.push(root);
            }
            while head < queue.len() {
                for &w in graph.neighbors(queue[head]) {
                    if label[w as usize] == fresh {
                        label[w as usize] = seen;
                        queue.push(w);
                    }
                }
                head += 1;
            }
        }
        queue.last().map_or(0, |&v| number[v as usize] as usize)
    }

    /// Cuts a part where the keys are about the median; `None` where no cut is
    /// worth it.
    fn cut_by_keys(&mut self, vertices: &mut [u32], range: &Range) -> Option<Cut> {
        let (from, to) = band::planes(&self.keys, range, &mut self.counts);
        self.labels += 3;
        let (source, sink, within) = (self.labels - 2, self.labels - 1, self.labels);
        for (&v, &key) in vertices.iter().zip(&self.keys) {
            self.label[v as usize] = match key {
                x if x < from => source,
                x if x > to => sink,
                _ => within,
            };
        }
        self.describe(vertices, source, sink, within);
        self.flow.maximize();
        self.choose_sides(vertices, source, sink);
        self.partition(vertices, source, sink)
    }

    /// Describes the band to the flow.
    fn describe(&mut self, vertices: &[u32], source: u32, sink: u32, within: u32) {
        let Dissection { graph, label, number, flow, band, place, .. } = self;
        band.clear();
        place.clear();
        flow.clear();
        for (k, &v) in vertices.iter().enumerate() {
            let own = label[v as usize];
            // No edge may leap over the band.
            let leaps = |&w: &u32| label[w as usize] == sink;
            if own == source && graph.neighbors(v).iter().any(leaps) {
                label[v as usize] = within;
            } else if own != within {
                continue;
            }
            number[v as usize] = band.len() as u32;
            band.push(v);
            place.push(k as u32);
        }
        for &v in band.iter() {
            let (mut at_source, mut at_sink) = (false, false);
            for &w in graph.neighbors(v) {
                let side = label[w as usize];
                if side == within {
                    flow.neighbor(number[w as usize]);
                }
                at_source |= side == source;
                at_sink |= side == sink;
            }
            flow.end_vertex(at_source, at_sink);
        }
    }

    /// Takes the minimum cut that is best balanced.
    fn choose_sides(&mut self, vertices: &[u32], source: u32, sink: u32) {
        let Dissection { label, flow, band, sides, keys, place, .. } = self;
        // Halves of what the cut leaves, about.
        let outside = vertices.iter().filter(|&&v| label[v as usize] == source).count();
        let half = (vertices.len() - flow.value()) / 2;
        flow.sides(half.saturating_sub(outside), |v| keys[place[v as usize] as usize], sides);
        for (&v, side) in band.iter().zip(sides) {
            label[v as usize] = match side {
                Side::Source => source,
                Side::Sink => sink,
                Side::Cut => LATER,
            };
        }
    }

    /// Sorts the vertices by side, keeping their order. `None` where a side is too
    /// large.
    fn partition(&mut self, vertices: &mut [u32], source: u32, sink: u32) -> Option<Cut> {
        let Dissection { label, queue: right, band: separator, .. } = self;
        right.clear();
        separator.clear();
        let mut left = 0;
        for k in 0..vertices.len() {
            let v = vertices[k];
            match label[v as usize] {
                side if side == source => {
                    vertices[left] = v;
                    left += 1;
                }
                side if side == sink => right.push(v),
                _ => separator.push(v),
            }
        }
        vertices[left..][..right.len()].copy_from_slice(right);
        vertices[left + right.len()..].copy_from_slice(separator);
        let larger = left.max(right.len());
        let worth = larger as f64 <= MAX_SIDE_FRACTION * vertices.len() as f64;
        worth.then_some(Cut { labels: [source, sink], sizes: [left, right.len()] })
    }
}
