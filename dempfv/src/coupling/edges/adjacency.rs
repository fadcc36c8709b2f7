//! The edges of each sphere.

/// For each sphere the places of its edges, one run after the other.
#[derive(Debug, Default)]
pub struct Adjacency {
    start: Vec<u32>,
    edges: Vec<u32>,
}

impl Adjacency {
    /// Of edges between `spheres` and, with numbers from there on, walls.
    pub fn new(spheres: usize, pairs: &[[u32; 2]]) -> Adjacency {
        let mut start = vec![0u32; spheres + 1];
        let ends = |pair: &[u32; 2]| pair.map(|v| v as usize).into_iter().filter(|&v| v < spheres);
        for v in pairs.iter().flat_map(|pair| ends(pair)) {
            start[v + 1] += 1;
        }
        for v in 0..spheres {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut edges = vec![0; start[spheres] as usize];
        for (e, pair) in (0u32..).zip(pairs) {
            for v in ends(pair) {
                edges[next[v] as usize] = e;
                next[v] += 1;
            }
        }
        Adjacency { start, edges }
    }

    /// The places of a sphere's edges, ascending.
    pub fn of(&self, sphere: usize) -> &[u32] {
        &self.edges[self.start[sphere] as usize..self.start[sphere + 1] as usize]
    }
}
