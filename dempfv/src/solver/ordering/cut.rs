//! The smallest set of vertices that separates one end of a part from the other:
//! a maximum flow with vertices of capacity one (Dinic 1970; Menger's theorem).

use super::part::{Part, Side};

/// The band around the median that the cut must lie in has this part of the
/// vertices times n^(-1/3): some layers, however large the part.
const BAND: f64 = 4.0;
/// It is never wider than this part of the vertices.
const WIDEST: f64 = 0.4;

const NONE: u32 = u32::MAX;
/// Before the first vertex of a path of the flow, and after the last.
const END: u32 = u32::MAX - 1;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Zone {
    Source,
    Band,
    Sink,
}

/// The side of each vertex; `None` where the part has no band to cut in.
pub(super) fn separate(part: &Part) -> Option<Vec<Side>> {
    let zones = zones(part)?;
    let mut flow = Flow::new(part, zones);
    while flow.layers() {
        flow.augment();
    }
    let sides = flow.sides();
    let left = sides.iter().filter(|&&s| s == Side::Left).count();
    let right = sides.iter().filter(|&&s| s == Side::Right).count();
    (left > 0 && right > 0).then_some(sides)
}

/// First, middle and last vertices along the longest side of the part.
fn zones(part: &Part) -> Option<Vec<Zone>> {
    let points = part.points();
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let axis = (0..3).max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b])))?;
    let n = points.len();
    let share = (BAND * (n as f64).powf(-1.0 / 3.0)).min(WIDEST);
    let (first, last) = (
        (n as f64 * (0.5 - 0.5 * share)) as usize,
        ((n as f64 * (0.5 + 0.5 * share)) as usize).min(n - 1),
    );
    let mut keys: Vec<f32> = points.iter().map(|p| p[axis]).collect();
    let (_, &mut from, above) = keys.select_nth_unstable_by(first, f32::total_cmp);
    let to = match last - first {
        0 => from,
        k => *above.select_nth_unstable_by(k - 1, f32::total_cmp).1,
    };
    let zone = |p: &[f32; 3]| match p[axis] {
        x if x < from => Zone::Source,
        x if x > to => Zone::Sink,
        _ => Zone::Band,
    };
    let mut zones: Vec<Zone> = points.iter().map(zone).collect();
    // No edge may leap over the band.
    for v in 0..n {
        let leaps = |&w: &u32| zones.get(w as usize) == Some(&Zone::Sink);
        if zones[v] == Zone::Source && part.neighbors(v).iter().any(leaps) {
            zones[v] = Zone::Band;
        }
    }
    let has = |zone| zones.contains(&zone);
    (has(Zone::Source) && has(Zone::Sink)).then_some(zones)
}

/// A flow through the band. Each vertex of it stands for two, an entry and an
/// exit, joined by an arc of capacity one; `2 v` and `2 v + 1` number them.
struct Flow<'a> {
    part: &'a Part,
    zones: Vec<Zone>,
    /// Vertices of the band.
    band: Vec<u32>,
    /// The vertex before and after each on its path; `NONE` off the paths.
    before: Vec<u32>,
    after: Vec<u32>,
    /// Distance of entries and exits from the source in the residual graph.
    level: Vec<u32>,
    /// How far an augmentation has looked at the neighbours of an exit.
    looked: Vec<u32>,
    queue: Vec<u32>,
}

impl<'a> Flow<'a> {
    fn new(part: &'a Part, zones: Vec<Zone>) -> Flow<'a> {
        let n = part.len();
        let band = (0..n as u32).filter(|&v| zones[v as usize] == Zone::Band).collect();
        Flow {
            part,
            zones,
            band,
            before: vec![NONE; n],
            after: vec![NONE; n],
            level: vec![NONE; 2 * n],
            looked: vec![0; n],
            queue: Vec::new(),
        }
    }

    fn touches(&self, v: u32, zone: Zone) -> bool {
        let is = |&w: &u32| self.zones.get(w as usize) == Some(&zone);
        self.part.neighbors(v as usize).iter().any(is)
    }

    /// Finds the distances from the source. False when the sink is out of reach:
    /// the flow is maximal.
    fn layers(&mut self) -> bool {
        self.level.fill(NONE);
        self.looked.fill(0);
        self.queue.clear();
        let mut reached = false;
        for k in 0..self.band.len() {
            let v = self.band[k];
            if self.touches(v, Zone::Source) {
                self.level[2 * v as usize] = 0;
                self.queue.push(2 * v);
            }
        }
        let mut head = 0;
        while head < self.queue.len() {
            let node = self.queue[head];
            head += 1;
            let next = self.level[node as usize] + 1;
            let v = node / 2;
            if node % 2 == 0 {
                match self.before[v as usize] {
                    NONE => self.reach(2 * v + 1, next),
                    END => {}
                    // Back along the path that comes in here.
                    u => self.reach(2 * u + 1, next),
                }
                continue;
            }
            if self.after[v as usize] != END && self.touches(v, Zone::Sink) {
                reached = true;
            }
            if self.before[v as usize] != NONE {
                // The path through this vertex may turn off elsewhere.
                self.reach(2 * v, next);
            }
            for k in 0..self.part.neighbors(v as usize).len() {
                let w = self.part.neighbors(v as usize)[k];
                if self.zones.get(w as usize) == Some(&Zone::Band) && self.after[v as usize] != w {
                    self.reach(2 * w, next);
                }
            }
        }
        reached
    }

    fn reach(&mut self, node: u32, level: u32) {
        if self.level[node as usize] == NONE {
            self.level[node as usize] = level;
            self.queue.push(node);
        }
    }

    /// Adds paths along the layers until none is left.
    fn augment(&mut self) {
        let mut path = Vec::new();
        for k in 0..self.band.len() {
            let v = self.band[k];
            if self.level[2 * v as usize] == 0 && self.search(v, &mut path) {
                self.apply(&path);
            }
        }
    }

    /// Looks for a path from the entry of a vertex at the source to the sink.
    /// What lies on it, or leads nowhere, is not looked at again in these layers.
    fn search(&mut self, first: u32, path: &mut Vec<u32>) -> bool {
        path.clear();
        path.push(2 * first);
        while let Some(&node) = path.last() {
            let v = node / 2;
            if node % 2 == 1 && self.after[v as usize] != END && self.touches(v, Zone::Sink) {
                for &node in path.iter() {
                    self.level[node as usize] = NONE;
                }
                return true;
            }
            match self.onward(node) {
                Some(next) => path.push(next),
                None => {
                    self.level[node as usize] = NONE;
                    path.pop();
                }
            }
        }
        false
    }

    /// The next node of the next layer that a node leads to.
    fn onward(&mut self, node: u32) -> Option<u32> {
        let v = (node / 2) as usize;
        let below = self.level[node as usize] + 1;
        if node % 2 == 0 {
            let next = match self.before[v] {
                NONE => node + 1,
                END => return None,
                u => 2 * u + 1,
            };
            return (self.level[next as usize] == below).then_some(next);
        }
        // The way back through the vertex comes before its neighbours.
        while self.looked[v] as usize <= self.part.neighbors(v).len() {
            let k = self.looked[v] as usize;
            self.looked[v] += 1;
            if k == 0 {
                if self.before[v] != NONE && self.level[node as usize - 1] == below {
                    return Some(node - 1);
                }
                continue;
            }
            let w = self.part.neighbors(v)[k - 1];
            let inside = self.zones.get(w as usize) == Some(&Zone::Band);
            if inside && self.after[v] != w && self.level[2 * w as usize] == below {
                return Some(2 * w);
            }
        }
        None
    }

    /// Turns the paths of the flow along a path of the residual graph.
    fn apply(&mut self, path: &[u32]) {
        // What is taken away first: a vertex may lose an arc and gain another.
        for pair in path.windows(2) {
            let (v, u) = (pair[0] / 2, pair[1] / 2);
            if pair[0] % 2 == 0 && u != v {
                self.after[u as usize] = NONE;
                self.before[v as usize] = NONE;
            }
        }
        for pair in path.windows(2) {
            let (u, w) = (pair[0] / 2, pair[1] / 2);
            if pair[0] % 2 == 1 && u != w {
                self.after[u as usize] = w;
                self.before[w as usize] = u;
            }
        }
        if let (Some(first), Some(last)) = (path.first(), path.last()) {
            self.before[(first / 2) as usize] = END;
            self.after[(last / 2) as usize] = END;
        }
    }

    /// The sides of the cut, after the last layers have failed to reach the sink.
    fn sides(&self) -> Vec<Side> {
        let side = |v: usize| match self.zones[v] {
            Zone::Source => Side::Left,
            Zone::Sink => Side::Right,
            Zone::Band if self.level[2 * v + 1] != NONE => Side::Left,
            Zone::Band if self.level[2 * v] != NONE => Side::Cut,
            Zone::Band => Side::Right,
        };
        (0..self.part.len()).map(side).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::SymmetricCsc;
    use super::*;

    /// The pattern of an m x m x l grid, l the longest side.
    fn grid(m: usize, l: usize) -> (SymmetricCsc, Vec<[f64; 3]>) {
        let mut a = SymmetricCsc { n: m * m * l, col_ptr: vec![0], ..Default::default() };
        let mut points = vec![];
        for j in 0..a.n {
            let (x, y, z) = (j % m, j / m % m, j / (m * m));
            points.push([x as f64, y as f64, z as f64]);
            a.row_idx.push(j as i64);
            for (inside, stride) in [(x + 1 < m, 1), (y + 1 < m, m), (z + 1 < l, m * m)] {
                if inside {
                    a.row_idx.push((j + stride) as i64);
                }
            }
            a.col_ptr.push(a.row_idx.len() as i64);
        }
        a.values = vec![1.0; a.row_idx.len()];
        (a, points)
    }

    /// A bar is cut across: m x m vertices, no edge between the sides.
    #[test]
    fn a_bar_is_cut_across() {
        let (a, points) = grid(6, 20);
        let part = Part::whole(&a, &points);
        let sides = separate(&part).unwrap();
        assert_eq!(sides.iter().filter(|&&s| s == Side::Cut).count(), 36);
        for v in 0..part.len() {
            for &w in part.neighbors(v) {
                let pair = [sides[v], sides[w as usize]];
                assert!(pair != [Side::Left, Side::Right], "{v} {w}");
            }
        }
    }

    /// A bar with a narrow place in its band is cut there.
    #[test]
    fn a_narrow_place_is_found() {
        let (mut a, points) = grid(6, 20);
        // At z = 11 only the column x = y = 2 goes on to z = 12.
        let layer = |j: i64| j / 36;
        let mut row_idx = vec![];
        let mut col_ptr = vec![0];
        for j in 0..a.n {
            for &i in &a.row_idx[a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize] {
                let through = layer(j as i64) == 11 && layer(i) == 12;
                if !through || j % 36 == 14 {
                    row_idx.push(i);
                }
            }
            col_ptr.push(row_idx.len() as i64);
        }
        (a.row_idx, a.col_ptr) = (row_idx, col_ptr);
        let sides = separate(&Part::whole(&a, &points)).unwrap();
        assert_eq!(sides.iter().filter(|&&s| s == Side::Cut).count(), 1);
    }
}
