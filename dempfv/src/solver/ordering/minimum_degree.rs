//! Minimum degree for a small part: rows of bits, with what is around it.

use super::graph::Graph;

const NONE: u32 = u32::MAX;

/// Parts that need more words than this (32 MiB) are not small.
const MAX_BIT_WORDS: usize = 1 << 22;

/// Work arrays of the ordering of small parts.
#[derive(Default)]
pub(super) struct MinimumDegree {
    /// A row of bits for each vertex: its neighbours.
    rows: Vec<u64>,
    degree: Vec<u32>,
    pivot: Vec<u64>,
    neighbors: Vec<u32>,
    sequence: Vec<u32>,
}

impl MinimumDegree {
    /// Sorts the vertices of a part, those with a label: always the one with the
    /// fewest neighbours among those that are left and those around, the first of
    /// several. Exact, since every elimination joins the neighbours at once; only
    /// parts that are dense and large are sorted by the neighbours at first.
    /// `number` is any array with an entry per vertex, those around included.
    pub(super) fn order(
        &mut self,
        graph: &Graph,
        vertices: &mut [u32],
        labels: &[u32],
        label: u32,
        number: &mut [u32],
    ) {
        let n = vertices.len();
        let all = self.renumber(graph, vertices, labels, label, number);
        let words = all.div_ceil(64);
        if n * words > MAX_BIT_WORDS {
            vertices.sort_by_key(|&v| graph.neighbors(v).len());
            return;
        }
        self.fill(graph, vertices, words);
        // The same instructions on any machine, where it has them faster ones.
        pulp::Arch::new().dispatch(|| self.eliminate(n, words));
        self.neighbors.clear();
        self.neighbors.extend(self.sequence.iter().map(|&k| vertices[k as usize]));
        vertices.copy_from_slice(&self.neighbors);
    }

    /// Lists the neighbours of all vertices by their numbers: those of the part
    /// come first. Returns how many there are.
    fn renumber(
        &mut self,
        graph: &Graph,
        vertices: &[u32],
        labels: &[u32],
        label: u32,
        number: &mut [u32],
    ) -> usize {
        for (k, &v) in vertices.iter().enumerate() {
            number[v as usize] = k as u32;
            for &w in graph.neighbors(v) {
                if labels[w as usize] != label {
                    number[w as usize] = NONE;
                }
            }
        }
        self.neighbors.clear();
        let mut all = vertices.len();
        for &v in vertices {
            for &w in graph.neighbors(v) {
                let number = &mut number[w as usize];
                if *number == NONE {
                    *number = all as u32;
                    all += 1;
                }
                self.neighbors.push(*number);
            }
        }
        all
    }

    fn fill(&mut self, graph: &Graph, vertices: &[u32], words: usize) {
        self.rows.clear();
        self.rows.resize(vertices.len() * words, 0);
        self.degree.clear();
        let mut next = 0;
        for (row, &v) in self.rows.chunks_exact_mut(words.max(1)).zip(vertices) {
            let degree = graph.neighbors(v).len();
            for &w in &self.neighbors[next..next + degree] {
                row[w as usize / 64] |= 1 << (w % 64);
            }
            next += degree;
            self.degree.push(degree as u32);
        }
    }

    #[inline(always)]
    fn eliminate(&mut self, n: usize, words: usize) {
        let MinimumDegree { rows, degree, pivot, sequence, .. } = self;
        sequence.clear();
        pivot.clear();
        pivot.resize(words, 0);
        for _ in 0..n {
            let least = degree.iter().copied().fold(u32::MAX, u32::min);
            let Some(v) = degree.iter().position(|&d| d == least) else { return };
            degree[v] = u32::MAX;
            sequence.push(v as u32);
            pivot.copy_from_slice(&rows[v * words..][..words]);
            for k in 0..n.div_ceil(64).min(words) {
                let mut bits = pivot[k];
                while bits != 0 {
                    let u = 64 * k + bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    if u >= n {
                        break;
                    }
                    let row = &mut rows[u * words..][..words];
                    row[v / 64] &= !(1 << (v % 64));
                    let mut count = 0;
                    for (own, other) in row.iter_mut().zip(pivot.iter()) {
                        *own |= other;
                        count += own.count_ones();
                    }
                    row[u / 64] &= !(1 << (u % 64));
                    degree[u] = count - 1;
                }
            }
        }
    }
}
