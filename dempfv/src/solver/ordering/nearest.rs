//! What is known at places, and looked up by the nearest of them.

/// Points in cells, about one in each.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    low: [f32; 3],
    /// Cells per length.
    scale: [f32; 3],
    cells: [u32; 3],
    /// The points of cell c: `start[c]..start[c + 1]`.
    start: Vec<u32>,
    point: Vec<[f32; 3]>,
    label: Vec<u32>,
}

impl Grid {
    /// Points and their labels. Those that are no numbers count as some place.
    pub(super) fn new(points: &[[f32; 3]], labels: &[u32]) -> Grid {
        let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
        for p in points {
            for (&x, (low, high)) in p.iter().zip(low.iter_mut().zip(&mut high)) {
                if x.is_finite() {
                    *low = low.min(x);
                    *high = high.max(x);
                }
            }
        }
        let mut grid = Grid {
            low,
            scale: [0.0; 3],
            cells: [1; 3],
            start: Vec::new(),
            point: Vec::new(),
            label: Vec::new(),
        };
        grid.divide([0, 1, 2].map(|k| f64::from(high[k]) - f64::from(low[k])), points.len());
        grid.sort(points, labels);
        grid
    }

    /// Chooses the cells of a box of these lengths: cubes, one for each point.
    fn divide(&mut self, length: [f64; 3], points: usize) {
        let longest = length.iter().copied().fold(0.0, f64::max);
        if longest <= 0.0 {
            return;
        }
        // A box that is flat has cells in its plane only.
        let sides = length.map(|l| l.max(longest * 1e-3));
        let volume: f64 = sides.iter().map(|l| l / longest).product();
        let per_length = (points as f64 / volume).cbrt() / longest;
        let cells = sides.map(|side| (side * per_length).ceil().clamp(1.0, 4096.0));
        self.cells = cells.map(|cells| cells as u32);
        self.scale = [0, 1, 2].map(|k| (cells[k] / sides[k]) as f32);
    }

    fn sort(&mut self, points: &[[f32; 3]], labels: &[u32]) {
        let count = self.cells.iter().map(|&c| c as usize).product::<usize>();
        let cell: Vec<u32> = points.iter().map(|p| self.cell(p)).collect();
        let mut start = vec![0u32; count + 2];
        for &c in &cell {
            start[c as usize + 2] += 1;
        }
        for c in 0..count {
            start[c + 2] += start[c + 1];
        }
        self.point = vec![[0.0; 3]; points.len()];
        self.label = vec![0; points.len()];
        for (k, &c) in cell.iter().enumerate() {
            let next = &mut start[c as usize + 1];
            self.point[*next as usize] = points[k];
            self.label[*next as usize] = labels[k];
            *next += 1;
        }
        start.pop();
        self.start = start;
    }

    /// The cell of a coordinate; the outermost for what lies outside.
    fn along(&self, axis: usize, x: f32) -> u32 {
        // The conversion saturates.
        (((x - self.low[axis]) * self.scale[axis]) as u32).min(self.cells[axis] - 1)
    }

    fn cell(&self, p: &[f32; 3]) -> u32 {
        let [x, y, z] = [0, 1, 2].map(|k| self.along(k, p[k]));
        (z * self.cells[1] + y) * self.cells[0] + x
    }

    /// The label of the nearest point, or of one that is not much farther: cells are
    /// searched until one is found, with a layer around it.
    pub(super) fn label(&self, p: &[f32; 3]) -> Option<u32> {
        let middle = [0, 1, 2].map(|k| self.along(k, p[k]));
        let widest = self.cells.into_iter().max().unwrap_or(1);
        let mut reach = 1;
        loop {
            if let Some(found) = self.nearest(p, middle, reach) {
                return Some(found);
            }
            if reach >= widest {
                return None;
            }
            reach *= 2;
        }
    }

    /// The label of the nearest point in the cells around one.
    fn nearest(&self, p: &[f32; 3], middle: [u32; 3], reach: u32) -> Option<u32> {
        let from = middle.map(|c| c.saturating_sub(reach));
        let to = [0, 1, 2].map(|k| (middle[k] + reach).min(self.cells[k] - 1));
        let mut best = (f32::INFINITY, None);
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                let row = (z * self.cells[1] + y) * self.cells[0];
                // Cells of a row follow each other.
                let range = self.start[(row + from[0]) as usize] as usize
                    ..self.start[(row + to[0]) as usize + 1] as usize;
                for (q, &label) in self.point[range.clone()].iter().zip(&self.label[range]) {
                    let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
                    let distance = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                    if best.1.is_none() || distance < best.0 {
                        best = (distance, Some(label));
                    }
                }
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point finds itself, and what lies near finds the nearest.
    #[test]
    fn the_nearest_is_found() {
        let points: Vec<[f32; 3]> = (0..1000u32)
            .map(|k| [k % 10, k / 10 % 10, k / 100].map(|x| x as f32 * 0.5 - 3.0))
            .collect();
        let labels: Vec<u32> = (0..1000).map(|k| 7 * k).collect();
        let grid = Grid::new(&points, &labels);
        for (p, &label) in points.iter().zip(&labels) {
            assert_eq!(grid.label(p), Some(label));
            assert_eq!(grid.label(&[p[0] + 0.2, p[1] - 0.2, p[2] + 0.1]), Some(label));
        }
        assert_eq!(grid.label(&[-1e9, -3.0, -1e30]), Some(0));
        // All are as far: any of them.
        assert!(grid.label(&[f32::INFINITY; 3]).is_some());
    }

    /// All in one place, on a line, no numbers, none.
    #[test]
    fn any_points_will_do() {
        assert_eq!(Grid::new(&[], &[]).label(&[0.0; 3]), None);
        assert_eq!(Grid::new(&[[2.0; 3]; 5], &[3; 5]).label(&[0.0; 3]), Some(3));
        assert!(Grid::new(&[[f32::NAN; 3]; 5], &[3; 5]).label(&[f32::NAN; 3]).is_some());
        let line: Vec<_> = (0..100u32).map(|k| [0.0, k as f32, 0.0]).collect();
        let grid = Grid::new(&line, &(0..100).collect::<Vec<_>>());
        assert_eq!(grid.label(&[5.0, 41.7, 0.0]), Some(42));
    }
}
