//! Neighbours in a periodic cell, across its faces too.

use super::cell_pass::image_index;
use super::error::DemError;
use super::grid::Grid;
use super::particles::Particles;
use crate::{Cell, Tensor, Vec3};

/// By how much a sphere may stray out of the cell, as a share of the edges. With it and a reach of
/// at most half a height, the copies of a pair that touch are at most one cell apart.
pub(super) const STRAY: f64 = 0.25;

/// Where the spheres are within the cell, while a list is built.
#[derive(Default)]
pub(super) struct Wrapped {
    /// Centre of the copy in the cell (m).
    pub position: Vec<Vec3>,
    /// The sphere itself is so many cells away.
    image: Vec<[i32; 3]>,
}

/// How far neighbours see in a cell.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    pub cell: &'a Cell,
    /// Distances between opposite faces (m).
    heights: [f64; 3],
    /// Largest radius (m).
    largest: f64,
    /// Largest gap between neighbours (m).
    margin: f64,
}

impl<'a> Sight<'a> {
    /// # Errors
    /// [`DemError::CellTooSmall`] where a pair might have two copies within reach.
    pub fn new(cell: &'a Cell, largest: f64, margin: f64) -> Result<Sight<'a>, DemError> {
        let heights = cell.heights();
        let height = heights.into_iter().fold(f64::INFINITY, f64::min);
        let least = 2.0 * (2.0 * largest + margin);
        if height < least {
            return Err(DemError::CellTooSmall { height, least, largest });
        }
        Ok(Sight { cell, heights, largest, margin })
    }

    /// The images n of the cell in which something near a sphere of radius `r` (m) may be that is
    /// at these coordinates along the edges.
    fn images(&self, fractions: Vec3, r: f64) -> impl Iterator<Item = [i32; 3]> + use<> {
        let farthest = r + self.largest + self.margin;
        let [along_a, along_b, along_c] = [0, 1, 2].map(|k| {
            let share = farthest / self.heights[k];
            let low = if fractions[k] < share { -1 } else { 0 };
            let high = if fractions[k] > 1.0 - share { 1 } else { 0 };
            low..=high
        });
        along_a.flat_map(move |a| {
            let along_c = along_c.clone();
            along_b.clone().flat_map(move |b| along_c.clone().map(move |c| [a, b, c]))
        })
    }

    /// The copies (m) of a sphere at `x` in the cell, of radius `r` (m), that are near the cell.
    pub fn copies(&self, x: &Vec3, r: f64) -> impl Iterator<Item = Vec3> + use<'a> {
        let (cell, x) = (*self.cell, *x);
        self.images(cell.fractions(&x), r).map(move |image| x - cell.shift(image))
    }

    /// Twice the largest radius and the margin (m): no pair in the list is farther apart.
    pub fn reach(&self) -> f64 {
        2.0 * self.largest + self.margin
    }
}

/// How a cell has deformed since a list was built.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellStrain {
    deformation: Tensor,
    /// Sum of the strains.
    sum: f64,
    /// No pair in the list is farther apart (m).
    reach: f64,
}

impl CellStrain {
    /// None yet; no pair in the list is farther apart than `reach` (m).
    pub fn none(reach: f64) -> CellStrain {
        CellStrain { deformation: Tensor::identity(), sum: 0.0, reach }
    }

    /// Adds a strain Δt L; returns how far it may bring a sphere nearer to another that is just
    /// not in the list, each from its side (m).
    pub fn add(&mut self, strain: &Tensor) -> f64 {
        self.deformation += strain * self.deformation;
        self.sum += strain.norm();
        0.5 * strain.norm() * self.reach
    }

    /// The same of all strains since the list was built (m).
    pub fn approach(&self) -> f64 {
        0.5 * self.sum * self.reach
    }

    /// How far a sphere has gone from a place that went with the cell (m).
    pub fn way(&self, now: &[f64; 4], then: &[f64; 4]) -> f64 {
        let [now, then] = [now, then].map(|c| Vec3::new(c[0], c[1], c[2]));
        (now - self.deformation * then).norm()
    }
}

impl Wrapped {
    /// Takes the places of all spheres.
    pub fn fill(&mut self, position: &[Vec3], cell: &Cell) {
        let places = || position.iter().map(|x| cell.wrap(x));
        self.position.clear();
        self.position.extend(places().map(|(inside, _)| inside));
        self.image.clear();
        self.image.extend(places().map(|(_, image)| image));
    }

    /// The later spheres near sphere `i`, each with the image that is near, in their order.
    pub fn around(
        &self,
        i: usize,
        particles: &Particles,
        grid: &Grid,
        sight: &Sight<'_>,
        found: &mut Vec<(u32, u8)>,
    ) {
        found.clear();
        let (x, r) = (self.position[i], particles.radius[i]);
        for image in sight.images(sight.cell.fractions(&x), r) {
            let place = x - sight.cell.shift(image);
            grid.around(&place, r, sight.margin, |j| {
                let k = j as usize;
                if k <= i {
                    return;
                }
                let d2 = (self.position[k] - place).norm_squared();
                let reach = r + particles.radius[k] + sight.margin;
                if d2 < reach * reach {
                    let (own, other) = (self.image[i], self.image[k]);
                    let image = [0, 1, 2].map(|e| (image[e] + own[e] - other[e]).clamp(-1, 1));
                    found.push((j, image_index(image)));
                }
            });
        }
        found.sort_unstable();
    }
}
