//! A part of the graph, by itself: its vertices are numbered from 0 and lie close
//! together in memory.

use super::super::SymmetricCsc;

/// Which side of a cut a vertex is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Cut,
}

/// Vertices that are ordered together, and around them (the halo) vertices that
/// are ordered later.
pub(super) struct Part {
    /// The unknown of each vertex of its own; the halo comes after them, without
    /// names.
    unknown: Vec<u32>,
    /// Where each of them lies.
    point: Vec<[f32; 3]>,
    /// Neighbours of vertex v of its own: `adjacent[start[v]..start[v + 1]]`. Those
    /// from `unknown.len()` on are of the halo.
    start: Vec<u32>,
    adjacent: Vec<u32>,
    /// Number of vertices in the halo.
    halo: usize,
}

impl Part {
    /// The whole graph of a matrix's pattern; nothing is around it.
    pub(super) fn whole(a: &SymmetricCsc, points: &[[f64; 3]]) -> Part {
        let mut start = vec![0u32; a.n + 1];
        let below = |j: usize| a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize;
        for j in 0..a.n {
            for &i in &a.row_idx[below(j)] {
                if i as usize != j {
                    start[i as usize + 1] += 1;
                    start[j + 1] += 1;
                }
            }
        }
        for v in 0..a.n {
            start[v + 1] += start[v];
        }
        let mut adjacent = vec![0u32; start[a.n] as usize];
        let mut next = start.clone();
        for j in 0..a.n {
            for &i in &a.row_idx[below(j)] {
                let i = i as usize;
                if i != j {
                    adjacent[next[i] as usize] = j as u32;
                    adjacent[next[j] as usize] = i as u32;
                    next[i] += 1;
                    next[j] += 1;
                }
            }
        }
        let point = points.iter().map(|p| p.map(|x| x as f32)).collect();
        Part { unknown: (0..a.n as u32).collect(), point, start, adjacent, halo: 0 }
    }

    /// Number of vertices of its own.
    pub(super) fn len(&self) -> usize {
        self.unknown.len()
    }

    /// As [`len`](Part::len), for who asks how much there is to order.
    pub(super) fn own(&self) -> usize {
        self.unknown.len()
    }

    /// Number of vertices around it.
    pub(super) fn halo(&self) -> usize {
        self.halo
    }

    /// The unknown of a vertex of its own.
    pub(super) fn unknown(&self, v: usize) -> u32 {
        self.unknown[v]
    }

    /// Where the vertices of its own lie.
    pub(super) fn points(&self) -> &[[f32; 3]] {
        &self.point
    }

    /// Neighbours of a vertex of its own.
    pub(super) fn neighbors(&self, v: usize) -> &[u32] {
        &self.adjacent[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// Both sides of a cut, each with what is around it, and the unknowns of the cut.
    pub(super) fn split(&self, sides: &[Side]) -> (Part, Part, Vec<u32>) {
        let cut = (0..self.len()).filter(|&v| sides[v] == Side::Cut);
        let separator = cut.map(|v| self.unknown[v]).collect();
        (self.side(sides, Side::Left), self.side(sides, Side::Right), separator)
    }

    fn side(&self, sides: &[Side], side: Side) -> Part {
        const NONE: u32 = u32::MAX;
        let own: Vec<u32> =
            (0..self.len() as u32).filter(|&v| sides[v as usize] == side).collect();
        let mut number = vec![NONE; self.len() + self.halo];
        for (k, &v) in own.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        let mut part = Part {
            unknown: own.iter().map(|&v| self.unknown[v as usize]).collect(),
            point: own.iter().map(|&v| self.point[v as usize]).collect(),
            start: Vec::with_capacity(own.len() + 1),
            adjacent: Vec::new(),
            halo: 0,
        };
        part.start.push(0);
        let size: usize = own.iter().map(|&v| self.neighbors(v as usize).len()).sum();
        part.adjacent.reserve_exact(size);
        for &v in &own {
            for &w in self.neighbors(v as usize) {
                // What is not of this side is of the cut or was around before.
                if number[w as usize] == NONE {
                    number[w as usize] = (own.len() + part.halo) as u32;
                    part.halo += 1;
                }
                part.adjacent.push(number[w as usize]);
            }
            part.start.push(part.adjacent.len() as u32);
        }
        part
    }
}
