//! The smallest set of vertices that separates a source from a sink: a maximum
//! flow with vertices of capacity one (Dinic 1970; Menger's theorem).

const NONE: u32 = u32::MAX;
/// Before the first vertex of a path of the flow, and after the last.
const END: u32 = u32::MAX - 1;

/// Which side of the cut a vertex of the band is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Source,
    Sink,
    Cut,
}

/// A flow through a band. Each vertex of it stands for two nodes, an entry 2 v
/// and an exit 2 v + 1, joined by an arc of capacity one.
#[derive(Default)]
pub(super) struct MaxFlow {
    /// Neighbours of vertex v in the band: `adjacent[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    adjacent: Vec<u32>,
    /// Vertices with a neighbour in the source, and whether each is one of them.
    first: Vec<u32>,
    at_source: Vec<bool>,
    /// Vertices with a neighbour in the sink.
    last: Vec<u32>,
    /// The vertex before and after each on its path; `NONE` off the paths.
    before: Vec<u32>,
    after: Vec<u32>,
    /// Distance of each node to the sink in the residual graph.
    distance: Vec<u32>,
    /// The next neighbour that a search looks at from the exit of a vertex.
    look: Vec<u32>,
    /// Nodes on the side of the source.
    reached: Vec<bool>,
    queue: Vec<u32>,
    path: Vec<u32>,
}

impl MaxFlow {
    /// Forgets everything; vertices come next.
    pub(super) fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.adjacent.clear();
        self.first.clear();
        self.at_source.clear();
        self.last.clear();
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Adds a neighbour to the vertex that is described now.
    pub(super) fn neighbor(&mut self, w: u32) {
        self.adjacent.push(w);
    }

    /// Ends the description of a vertex.
    pub(super) fn end_vertex(&mut self, at_source: bool, at_sink: bool) {
        let v = self.len() as u32;
        if at_source {
            self.first.push(v);
        }
        if at_sink {
            self.last.push(v);
        }
        self.at_source.push(at_source);
        self.start.push(self.adjacent.len() as u32);
    }

    /// Number of paths: vertices in a minimum cut.
    pub(super) fn value(&self) -> usize {
        self.first.iter().filter(|&&v| self.before[v as usize] == END).count()
    }

    /// Makes the flow maximal.
    pub(super) fn maximize(&mut self) {
        let n = self.len();
        self.before.clear();
        self.before.resize(n, NONE);
        self.after.clear();
        self.after.resize(n, NONE);
        while self.measure() {
            self.augment();
        }
    }

    /// Finds the distances to the sink, where an arc within a vertex has no length.
    /// False when no more path may begin: the flow is maximal.
    fn measure(&mut self) -> bool {
        let MaxFlow { start, adjacent, last, at_source, before, after, distance, queue, .. } = self;
        distance.clear();
        distance.resize(2 * before.len(), NONE);
        // Room for every node, and for one that is known already.
        queue.clear();
        queue.resize(distance.len() + 1, 0);
        let mut tail = 0;
        // Without a branch, which could not be foretold.
        let mut reach = |distance: &mut [u32], queue: &mut [u32], node: u32, far: u32| {
            let known = &mut distance[node as usize];
            queue[tail] = node;
            tail += usize::from(*known == NONE);
            *known = far.min(*known);
            tail
        };
        let mut end = 0;
        for &v in last.iter() {
            end = reach(distance, queue, 2 * v + 1, 0);
        }
        let mut open = false;
        let mut head = 0;
        while head < end {
            let node = queue[head];
            head += 1;
            let far = distance[node as usize];
            let v = (node / 2) as usize;
            let entry = 2 * v;
            let next = after[v];
            if node as usize == entry {
                // Of a path. The way back to its entry begins at its exit.
                if distance[entry + 1] == NONE {
                    distance[entry + 1] = far;
                    if next != END {
                        end = reach(distance, queue, 2 * next, far + 1);
                    }
                }
            } else if next == NONE {
                distance[entry] = far;
            } else {
                // To the exit of a vertex of a path leads the entry of the next.
                if next != END {
                    end = reach(distance, queue, 2 * next, far + 1);
                }
                continue;
            }
            open |= at_source[v] && before[v] != END;
            for &w in &adjacent[start[v] as usize..start[v + 1] as usize] {
                end = reach(distance, queue, 2 * w + 1, far + 1);
            }
        }
        open
    }

    /// Adds paths that never go away from the sink until none is left.
    fn augment(&mut self) {
        self.look.clear();
        self.look.extend_from_slice(&self.start[..self.start.len() - 1]);
        for k in 0..self.first.len() {
            let v = self.first[k];
            let open = self.before[v as usize] != END && self.distance[2 * v as usize] != NONE;
            if open && self.search(v) {
                self.apply();
            }
        }
    }

    /// Looks for a path from the entry of a vertex at the source to the sink.
    /// What lies on it, or leads nowhere, is not looked at again.
    fn search(&mut self, first: u32) -> bool {
        self.path.clear();
        let mut node = 2 * first;
        loop {
            let distance = self.distance[node as usize];
            if distance == 0 && node % 2 == 1 {
                self.distance[node as usize] = NONE;
                self.path.push(node);
                return true;
            }
            if let Some(next) = self.onward(node, distance) {
                self.path.push(node);
                node = next;
                continue;
            }
            self.distance[node as usize] = NONE;
            match self.path.pop() {
                Some(back) => node = back,
                None => return false,
            }
        }
    }

    /// The next node on the way to the sink from a node at a distance.
    fn onward(&mut self, node: u32, distance: u32) -> Option<u32> {
        let v = (node / 2) as usize;
        if node.is_multiple_of(2) {
            let (next, length) = match self.before[v] {
                NONE => (node + 1, 0),
                END => return None,
                u => (2 * u + 1, 1),
            };
            let known = self.distance[next as usize];
            return (known != NONE && known + length == distance).then_some(next);
        }
        if self.before[v] != NONE && self.distance[node as usize - 1] == distance {
            return Some(node - 1);
        }
        let end = self.start[v + 1];
        while self.look[v] < end {
            let w = self.adjacent[self.look[v] as usize];
            let known = self.distance[2 * w as usize];
            if known != NONE && known + 1 == distance {
                return Some(2 * w);
            }
            self.look[v] += 1;
        }
        None
    }

    /// Turns the paths of the flow along the path that was found.
    fn apply(&mut self) {
        // What is taken away first: a vertex may lose an arc and gain another.
        for pair in self.path.windows(2) {
            let (v, u) = (pair[0] / 2, pair[1] / 2);
            if pair[0] % 2 == 0 && u != v {
                self.after[u as usize] = NONE;
                self.before[v as usize] = NONE;
            }
        }
        for pair in self.path.windows(2) {
            let (u, w) = (pair[0] / 2, pair[1] / 2);
            if pair[0] % 2 == 1 && u != w {
                self.after[u as usize] = w;
                self.before[w as usize] = u;
            }
            self.distance[pair[0] as usize] = NONE;
        }
        if let (Some(first), Some(last)) = (self.path.first(), self.path.last()) {
            self.before[(first / 2) as usize] = END;
            self.after[(last / 2) as usize] = END;
        }
    }

    /// The sides of a minimum cut: of those that follow the order `ahead` of the
    /// vertices, the one that comes nearest to `half` vertices on the side of the
    /// source, without those that are no part of the band.
    pub(super) fn sides(&mut self, half: usize, ahead: impl Fn(u32) -> f32, sides: &mut Vec<Side>) {
        self.reached.clear();
        self.reached.resize(2 * self.len(), false);
        let mut size = 0;
        for k in 0..self.first.len() {
            size += self.follow(self.first[k]);
        }
        if size < half {
            self.advance(half, size, ahead);
        }
        sides.clear();
        sides.extend(self.reached.chunks_exact(2).map(|node| match node {
            [_, true] => Side::Source,
            [true, false] => Side::Cut,
            _ => Side::Sink,
        }));
    }

    /// Moves the cut away from the source. Whatever lies between the outermost cuts
    /// may be on either side, if all that the residual graph leads to goes with it.
    fn advance(&mut self, half: usize, mut size: usize, ahead: impl Fn(u32) -> f32) {
        let mut between = std::mem::take(&mut self.look);
        between.clear();
        between.extend((0..self.len() as u32).filter(|&v| {
            let entry = 2 * v as usize;
            !self.reached[entry] && self.distance[entry] == NONE
        }));
        between.sort_unstable_by(|&v, &w| ahead(v).total_cmp(&ahead(w)).then(v.cmp(&w)));
        for &v in &between {
            if size >= half {
                break;
            }
            let more = self.follow(v);
            if size + more > half && size + more - half > half.saturating_sub(size) {
                // Further from half than before: not that step.
                for &node in &self.queue {
                    self.reached[node as usize] = false;
                }
                break;
            }
            size += more;
        }
        self.look = between;
    }

    /// Adds what the residual graph leads to from the entry of a vertex, and returns
    /// how many exits are among it. The nodes are in `queue`.
    fn follow(&mut self, v: u32) -> usize {
        self.queue.clear();
        self.pass(2 * v);
        let mut head = 0;
        let mut exits = 0;
        while head < self.queue.len() {
            let node = self.queue[head];
            head += 1;
            let v = (node / 2) as usize;
            if node.is_multiple_of(2) {
                match self.before[v] {
                    NONE => self.pass(node + 1),
                    END => {}
                    u => self.pass(2 * u + 1),
                }
                continue;
            }
            exits += 1;
            if self.before[v] != NONE {
                self.pass(node - 1);
            }
            for k in self.start[v]..self.start[v + 1] {
                self.pass(2 * self.adjacent[k as usize]);
            }
        }
        exits
    }

    fn pass(&mut self, node: u32) {
        let reached = &mut self.reached[node as usize];
        if !*reached {
            *reached = true;
            self.queue.push(node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flow through vertices by their neighbours; the first `ends` are at the
    /// source, the last `ends` at the sink.
    fn flow(neighbors: &[Vec<u32>], ends: usize) -> MaxFlow {
        let mut flow = MaxFlow::default();
        flow.clear();
        for (v, list) in neighbors.iter().enumerate() {
            list.iter().for_each(|&w| flow.neighbor(w));
            flow.end_vertex(v < ends, v >= neighbors.len() - ends);
        }
        flow.maximize();
        flow
    }

    /// Fails unless the cuts, wherever they lie, separate the ends and are as small as
    /// the flow is large: no set can be smaller (Menger 1927). Returns their size.
    fn check(neighbors: &[Vec<u32>], ends: usize) -> usize {
        let mut flow = flow(neighbors, ends);
        let value = flow.value();
        let mut sides = vec![];
        for half in [0, neighbors.len() / 2, neighbors.len()] {
            flow.sides(half, |v| v as f32, &mut sides);
            assert_eq!(sides.iter().filter(|&&s| s == Side::Cut).count(), value);
            for (v, list) in neighbors.iter().enumerate() {
                let leaps = |&w: &u32| sides[v] == Side::Source && sides[w as usize] == Side::Sink;
                assert!(!list.iter().any(leaps));
                assert!(v >= ends || sides[v] != Side::Sink);
                assert!(v < neighbors.len() - ends || sides[v] != Side::Source);
            }
        }
        value
    }

    fn graph(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Vec<Vec<u32>> {
        let mut neighbors = vec![vec![]; n];
        for (v, w) in edges {
            if v != w && !neighbors[v].contains(&(w as u32)) {
                neighbors[v].push(w as u32);
                neighbors[w].push(v as u32);
            }
        }
        neighbors
    }

    /// A path that must turn off what a greedy one took: 0-3-5 blocks 1-3, 0-4.
    #[test]
    fn a_path_gives_way() {
        let edges = [(0, 3), (0, 2), (1, 3), (3, 5), (2, 4)];
        assert_eq!(check(&graph(6, edges), 2), 2);
    }

    /// All goes through one vertex.
    #[test]
    fn a_narrow_place_is_found() {
        let edges = (0..5).map(|v| (v, 5)).chain((6..11).map(|v| (5, v)));
        assert_eq!(check(&graph(11, edges), 5), 1);
    }

    #[test]
    fn cuts_of_random_graphs_are_minimal() {
        let mut state = 88_172_645_463_325_252u64;
        let mut next = |n: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 33) as usize % n
        };
        for round in 0..300 {
            let n = 6 + next(60);
            let edges: Vec<_> = (0..n + next(2 * n)).map(|_| (next(n), next(n))).collect();
            check(&graph(n, edges), 1 + round % (n / 2));
        }
    }
}
