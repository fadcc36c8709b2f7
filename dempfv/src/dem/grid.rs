//! Cells that hold the particles while the neighbour list is built: a grid for each class of
//! sizes, so that few large spheres among many small ones make no large cells for these.

use crate::{Aabb, Vec3};

/// Classes of sizes at most; the last takes all that are smaller.
const CLASSES: usize = 24;

/// Particles in cells, by classes of sizes: each spans a factor of two in radius.
#[derive(Default)]
pub(super) struct Grid {
    levels: Vec<Level>,
    /// Class of each particle.
    class: Vec<u8>,
}

/// The particles of one class.
#[derive(Default)]
struct Level {
    cells: CellIndex,
    /// Largest radius among them (m).
    largest: f64,
    /// Where each cell's particles start in `members`.
    start: Vec<u32>,
    /// Indices of the particles, cell by cell, ascending within a cell.
    members: Vec<u32>,
    /// Indices of the particles, and the cell of each.
    particles: Vec<u32>,
    cell: Vec<u32>,
}

impl Grid {
    /// Bins particles of these radii (m). Particles beyond the box belong to the nearest cell.
    /// `margin` is the largest gap between neighbours (m).
    pub fn fill(&mut self, position: &[Vec3], radius: &[f64], box_: &Aabb, margin: f64) {
        let largest = radius.iter().copied().fold(0.0, f64::max);
        self.class.clear();
        self.class.extend(radius.iter().map(|&r| class(r, largest)));
        let count = self.class.iter().max().map_or(0, |&last| last as usize + 1);
        self.levels.resize_with(count, Level::default);
        for level in &mut self.levels {
            level.particles.clear();
            level.largest = 0.0;
        }
        for ((i, &class), &r) in (0u32..).zip(&self.class).zip(radius) {
            let level = &mut self.levels[class as usize];
            level.particles.push(i);
            level.largest = level.largest.max(r);
        }
        for level in &mut self.levels {
            level.fill(position, box_, margin);
        }
    }

    /// Calls `visit` with the index of each particle in the cells that have room for a neighbour
    /// of a sphere at `x` of radius `r`, at a gap of no more than `margin` (m).
    pub fn around(&self, x: &Vec3, r: f64, margin: f64, mut visit: impl FnMut(u32)) {
        for level in self.levels.iter().filter(|level| !level.particles.is_empty()) {
            level.around(x, r + level.largest + margin, &mut visit);
        }
    }
}

/// How many halvings the largest radius is above this one.
fn class(radius: f64, largest: f64) -> u8 {
    // As a cast has it, what is no number is the first class.
    ((largest / radius).log2() as u8).min(CLASSES as u8 - 1)
}

impl Level {
    fn fill(&mut self, position: &[Vec3], box_: &Aabb, margin: f64) {
        self.cells = CellIndex::new(box_, 2.0 * self.largest + margin, self.particles.len());
        let cells = self.cells.count();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.clear();
        for &i in &self.particles {
            let cell = self.cells.of(&position[i as usize]);
            self.cell.push(cell as u32);
            self.start[cell + 1] += 1;
        }
        for k in 0..cells {
            self.start[k + 1] += self.start[k];
        }
        self.members.resize(self.particles.len(), 0);
        for (&i, &cell) in self.particles.iter().zip(&self.cell) {
            let slot = &mut self.start[cell as usize];
            self.members[*slot as usize] = i;
            *slot += 1;
        }
        // The starts have moved on to the ends: shift them back by one cell.
        self.start.copy_within(0..cells, 1);
        self.start[0] = 0;
    }

    /// Visits the particles of all cells within `reach` (m) of a point, along each axis.
    fn around(&self, x: &Vec3, reach: f64, visit: &mut impl FnMut(u32)) {
        let low = self.cells.coordinates(&x.add_scalar(-reach));
        let high = self.cells.coordinates(&x.add_scalar(reach));
        for a in low[0]..=high[0] {
            for b in low[1]..=high[1] {
                // The cells of a row lie side by side in `members`.
                let from = self.start[self.cells.index(a, b, low[2])];
                let to = self.start[self.cells.index(a, b, high[2]) + 1];
                for &j in &self.members[from as usize..to as usize] {
                    visit(j);
                }
            }
        }
    }
}

/// A box cut into cubes, but for what is left over at its ends.
#[derive(Clone, Copy, Default)]
pub(super) struct CellIndex {
    low: Vec3,
    inverse: f64,
    dims: [usize; 3],
}

impl CellIndex {
    /// Cells of no less than `least` along each edge (m), and no more of them than a few for each
    /// of `count` things, whatever the shape of the box.
    pub fn new(box_: &Aabb, least: f64, count: usize) -> CellIndex {
        let size = box_.size();
        let most = (4 * count + 64) as f64;
        let mut edge = least.max((size.product() / most).cbrt());
        let along = |edge: f64| size.map(|length| (length / edge).max(1.0));
        // A long or a flat box has more cells of this edge than its volume tells.
        while along(edge).product() > most {
            edge *= 2.0;
        }
        let dims = along(edge).map(|cells| cells as usize).into();
        CellIndex { low: box_.min, inverse: 1.0 / edge, dims }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// The cell of a point; the nearest one if it lies beyond the box.
    pub fn of(&self, x: &Vec3) -> usize {
        let [a, b, c] = self.coordinates(x);
        self.index(a, b, c)
    }

    /// Where a point, or the nearest of the box, lies along each axis.
    pub fn coordinates(&self, x: &Vec3) -> [usize; 3] {
        // The conversion saturates: what lies below the box becomes 0.
        std::array::from_fn(|k| {
            (((x[k] - self.low[k]) * self.inverse) as usize).min(self.dims[k] - 1)
        })
    }

    /// Number of a cell.
    pub fn index(&self, a: usize, b: usize, c: usize) -> usize {
        (a * self.dims[1] + b) * self.dims[2] + c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pair that is near is found from either side, whatever the sizes and the box.
    #[test]
    fn all_neighbours_are_found() {
        let mut state = 9u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for (size, ratio) in [
            (Vec3::new(1.0, 1.0, 1.0), 1.0_f64),
            (Vec3::new(1.0, 1.0, 1.0), 1e3),
            (Vec3::new(1e9, 1.0, 1.0), 30.0),
            (Vec3::new(1e-6, 1e9, 1e9), 10.0),
            (Vec3::new(1e300, 1.0, 1e-3), 3.0),
        ] {
            let box_ = Aabb { min: Vec3::zeros(), max: size };
            let x: Vec<Vec3> = (0..300).map(|_| size.map(|s| s.min(3.0) * random())).collect();
            let r: Vec<f64> = (0..300).map(|_| 0.2 * ratio.powf(-random())).collect();
            let margin = 0.01;
            let mut grid = Grid::default();
            grid.fill(&x, &r, &box_, margin);
            assert!(grid.levels.iter().all(|l| l.cells.count() <= 4 * 300 + 64));
            for i in 0..x.len() {
                let near = |j: usize| (x[j] - x[i]).norm() < r[i] + r[j] + margin;
                let mut found = vec![false; x.len()];
                grid.around(&x[i], r[i], margin, |j| found[j as usize] = true);
                assert!((0..x.len()).all(|j| found[j] || !near(j)), "{size} {ratio} {i}");
            }
        }
    }
}
