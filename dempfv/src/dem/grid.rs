//! Cells that hold the particles while the neighbour list is built.

use crate::{Aabb, Vec3};

/// Particles binned in cubic cells.
#[derive(Default)]
pub(super) struct Grid {
    low: Vec3,
    inverse: f64,
    dims: [usize; 3],
    /// Where each cell's particles start in `members`.
    start: Vec<u32>,
    /// Indices of the particles, cell by cell, ascending within a cell.
    members: Vec<u32>,
    /// Cell of each particle.
    cell: Vec<u32>,
}

impl Grid {
    /// Bins the particles in cells no smaller than `reach`, the largest
    /// distance of two centres that are neighbours. Particles beyond the box
    /// belong to the nearest cell.
    pub fn fill(&mut self, position: &[Vec3], box_: &Aabb, reach: f64) {
        let size = box_.size();
        // No more cells than a few per particle, however small these are.
        let volume_per_cell = size.product() / (4 * position.len() + 64) as f64;
        let edge = reach.max(volume_per_cell.cbrt());
        self.low = box_.min;
        self.inverse = 1.0 / edge;
        self.dims = std::array::from_fn(|k| ((size[k] / edge) as usize).clamp(1, 1 << 20));
        let cells = self.dims.iter().product::<usize>();

        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.clear();
        for x in position {
            let [a, b, c] = self.coordinates(x);
            let cell = self.index(a, b, c);
            self.cell.push(cell as u32);
            self.start[cell + 1] += 1;
        }
        for k in 0..cells {
            self.start[k + 1] += self.start[k];
        }
        self.members.resize(position.len(), 0);
        for (i, &cell) in (0u32..).zip(&self.cell) {
            let slot = &mut self.start[cell as usize];
            self.members[*slot as usize] = i;
            *slot += 1;
        }
        // The starts have moved on to the ends: shift them back by one cell.
        self.start.copy_within(0..cells, 1);
        self.start[0] = 0;
    }

    /// Calls `visit` with the index of each particle in the cells around `x`.
    pub fn around(&self, x: &Vec3, mut visit: impl FnMut(u32)) {
        let centre = self.coordinates(x);
        let range = |k: usize| centre[k].saturating_sub(1)..(centre[k] + 2).min(self.dims[k]);
        for a in range(0) {
            for b in range(1) {
                let row = range(2);
                // The cells of a row lie side by side in `members`.
                let from = self.start[self.index(a, b, row.start)];
                let to = self.start[self.index(a, b, row.end - 1) + 1];
                for &j in &self.members[from as usize..to as usize] {
                    visit(j);
                }
            }
        }
    }

    fn coordinates(&self, x: &Vec3) -> [usize; 3] {
        // The conversion saturates: what lies below the box becomes 0.
        std::array::from_fn(|k| {
            (((x[k] - self.low[k]) * self.inverse) as usize).min(self.dims[k] - 1)
        })
    }

    fn index(&self, a: usize, b: usize, c: usize) -> usize {
        (a * self.dims[1] + b) * self.dims[2] + c
    }
}
