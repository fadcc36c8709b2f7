//! The spheres of a periodic cell with their copies around it.
//!
//! Round-off breaks ties in a triangulation, and it would break them otherwise for a copy than for
//! the sphere itself. Therefore edges and places are rounded to a grid so coarse that sums of them
//! are exact in double precision, and so fine (some 1e-15 of all) that it is round-off itself: a copy
//! of four spheres then is, to the last bit, what the four are.

use super::frame::Frame;
use crate::{Cell, Vec3};

/// Places among the copies are multiples of 2 to so many powers below their largest extent.
const BITS: i32 = 50;

/// Which copy of a cell: how many edges away along each.
pub(super) type Image = [i8; 3];

/// Spheres of a cell, then copies of them.
pub(super) struct CellCopies {
    /// Centres (m) from `origin`.
    pub x: Vec<Vec3>,
    pub r: Vec<f64>,
    /// Sphere and copy of each.
    pub of: Vec<(u32, Image)>,
    /// Edges of the box around all of them (m).
    pub size: Vec3,
    /// The box's lower corner (m).
    pub origin: Vec3,
    edges: [Vec3; 3],
}

impl CellCopies {
    /// With the copies that are up to `margin` (m) away from the cell's faces.
    pub fn new(position: &[Vec3], radius: &[f64], cell: &Cell, margin: f64) -> CellCopies {
        let shares = Vec3::from(cell.heights().map(|height| margin / height));
        let reach = shares.map(|share| share.ceil() as i8);
        let [a, b, c] = cell.lengths();
        let largest = (2.0 * f64::from(reach.max()) + 3.0) * (a + b + c);
        let unit = 2f64.powi(largest.log2().ceil() as i32 - BITS);
        let on_grid = |x: Vec3| x.map(|x| (x / unit).round() * unit);
        let edges = cell.edges().map(on_grid);
        let inside: Vec<Vec3> = position.iter().map(|x| on_grid(cell.wrap(x).0)).collect();
        let fractions: Vec<Vec3> = inside.iter().map(|x| cell.fractions(x)).collect();
        let mut copies = CellCopies {
            x: inside.clone(),
            r: radius.to_vec(),
            of: (0..position.len() as u32).map(|sphere| (sphere, [0; 3])).collect(),
            size: Vec3::zeros(),
            origin: Vec3::zeros(),
            edges,
        };
        let along = |k: usize| -reach[k]..=reach[k];
        for image in
            along(0).flat_map(|i| along(1).flat_map(move |j| along(2).map(move |k| [i, j, k])))
        {
            let shift = copies.shift(image);
            let near = |f: &Vec3| {
                (0..3).all(|k| {
                    let there = f[k] + f64::from(image[k]);
                    (-shares[k]..=1.0 + shares[k]).contains(&there)
                })
            };
            let here = image == [0; 3];
            for (i, _) in fractions.iter().enumerate().filter(|(_, f)| !here && near(f)) {
                copies.x.push(inside[i] + shift);
                copies.r.push(radius[i]);
                copies.of.push((i as u32, image));
            }
        }
        copies.shut_in(on_grid(Vec3::repeat(radius.iter().copied().fold(0.0, f64::max))));
        copies
    }

    /// Puts a box around all, with so much room (m) at its faces.
    fn shut_in(&mut self, room: Vec3) {
        let infinite = Vec3::repeat(f64::INFINITY);
        let (mut low, mut high) = (infinite, -infinite);
        for x in &self.x {
            (low, high) = (low.inf(x), high.sup(x));
        }
        self.origin = low - room;
        self.size = high - low + 2.0 * room;
        let origin = self.origin;
        self.x.iter_mut().for_each(|x| *x -= origin);
    }

    /// The way to a copy of the cell (m), exactly.
    pub fn shift(&self, image: Image) -> Vec3 {
        (0..3).map(|k| self.edges[k] * f64::from(image[k])).sum()
    }

    /// All of them as a packing in a box.
    pub fn frame(&self) -> Frame<'_> {
        Frame { x: self.x.clone(), r: &self.r, size: self.size }
    }

    /// The number of each one's sphere.
    pub fn spheres(&self) -> Vec<u32> {
        self.of.iter().map(|(sphere, _)| *sphere).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two copies are apart by exactly what their spheres are, in a cell without any round number.
    #[test]
    fn copies_are_exact() {
        let third = |a: f64, b: f64, c: f64| Vec3::new(a, b, c) / 3.0;
        let cell = Cell::new([third(1.0, 0.1, 0.0), third(0.2, 1.1, 0.3), third(0.0, -0.2, 0.9)]);
        let cell = cell.unwrap();
        let x: Vec<Vec3> =
            (1..20).map(|k| Vec3::repeat(f64::from(k)).map(|k| (k * 0.77).sin())).collect();
        let x: Vec<Vec3> =
            x.iter().zip(1..).map(|(x, k)| x + Vec3::x() * f64::from(k).sqrt()).collect();
        let copies = CellCopies::new(&x, &[0.01; 19], &cell, 0.35);
        assert!(copies.x.len() > 27 * 19, "{}", copies.x.len());
        for (x, (sphere, image)) in copies.x.iter().zip(&copies.of) {
            assert_eq!(x - copies.x[*sphere as usize], copies.shift(*image));
        }
    }
}
