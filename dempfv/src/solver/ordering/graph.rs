//! A part of the graph, by itself: its vertices are numbered from 0 and lie close
//! together in memory. What is around it, its halo, is kept for the degrees of its own vertices
//! (Pellegrini, Roman and Amestoy 2000).

use super::super::SymmetricCsc;

/// Vertices that are ordered together, and around them (the halo) vertices that
/// are ordered later.
pub(super) struct Graph {
    /// The unknown of each vertex of its own; the halo comes after them, without
    /// names.
    pub unknown: Vec<u32>,
    /// Where each of them lies.
    pub point: Vec<[f32; 3]>,
    /// Neighbours of vertex v of its own: `adjacent[start[v]..start[v + 1]]`. Those
    /// from `unknown.len()` on are of the halo.
    pub start: Vec<u32>,
    pub adjacent: Vec<u32>,
    /// Number of vertices in the halo.
    pub halo: usize,
}

impl Graph {
    /// The whole graph of a matrix's pattern; nothing is around it.
    pub(super) fn whole(a: &SymmetricCsc, points: &[[f64; 3]]) -> Graph {
        let mut start = vec![0u32; a.n + 2];
        let below = |j: usize| &a.row_idx[a.col_ptr[j] as usize + 1..a.col_ptr[j + 1] as usize];
        for j in 0..a.n {
            let rows = below(j);
            start[j + 2] += rows.len() as u32;
            for &i in rows {
                start[i as usize + 2] += 1;
            }
        }
        for v in 0..a.n {
            start[v + 2] += start[v + 1];
        }
        // Entry v + 1 is where the next neighbour of v goes, and ends as the end.
        let mut adjacent = vec![0u32; start[a.n + 1] as usize];
        for j in 0..a.n {
            for &i in below(j) {
                for (v, w) in [(i as usize, j), (j, i as usize)] {
                    let next = &mut start[v + 1];
                    adjacent[*next as usize] = w as u32;
                    *next += 1;
                }
            }
        }
        start.pop();
        let point = points.iter().map(|p| p.map(|x| x as f32)).collect();
        Graph { unknown: (0..a.n as u32).collect(), point, start, adjacent, halo: 0 }
    }

    /// Number of vertices of its own.
    pub(super) fn len(&self) -> usize {
        self.unknown.len()
    }

    /// Neighbours of a vertex of its own.
    pub(super) fn neighbors(&self, v: u32) -> &[u32] {
        let v = v as usize;
        &self.adjacent[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// Some of its vertices, with what is around them.
    pub(super) fn part(&self, vertices: &[u32]) -> Graph {
        const NONE: u32 = u32::MAX;
        let mut number = vec![NONE; self.len() + self.halo];
        for (k, &v) in vertices.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        let mut start = Vec::with_capacity(vertices.len() + 1);
        start.push(0);
        let mut size = 0;
        for &v in vertices {
            size += self.neighbors(v).len();
            start.push(size as u32);
        }
        let mut adjacent = Vec::with_capacity(size);
        let mut next = vertices.len() as u32;
        for &v in vertices {
            adjacent.extend(self.neighbors(v).iter().map(|&w| {
                let number = &mut number[w as usize];
                if *number == NONE {
                    *number = next;
                    next += 1;
                }
                *number
            }));
        }
        Graph {
            unknown: vertices.iter().map(|&v| self.unknown[v as usize]).collect(),
            point: vertices.iter().map(|&v| self.point[v as usize]).collect(),
            start,
            adjacent,
            halo: next as usize - vertices.len(),
        }
    }
}
