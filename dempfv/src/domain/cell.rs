//! A periodic cell: three edges that fill space with copies of what is between them.

use serde::{Deserialize, Serialize};

use super::{Aabb, Tensor, Vec3};

/// A volume below this share of the product of the edges is that of a flat cell.
const FLAT: f64 = 1e-9;
/// A sum of edges takes the place of one where it is shorter by this share at least, so that
/// round-off does not change edges of one length for ever.
const SHORTER: f64 = 1e-9;

/// A periodic cell, any parallelepiped with a corner at the origin.
///
/// A point x has copies at x + H n for all whole n, where the columns of H are the edges. The same
/// copies follow from many cells, as from one with the edges a, b + a, c;
/// [`reduced`](Cell::reduced) takes the one with short edges.
///
/// ```
/// use dempfv::{Cell, Vec3};
/// let cell = Cell::new([Vec3::x(), Vec3::new(0.25, 1.0, 0.0), 2.0 * Vec3::z()])?;
/// assert_eq!(cell.volume(), 2.0);
/// let (inside, image) = cell.wrap(&Vec3::new(1.5, 0.5, -0.5));
/// assert_eq!((inside, image), (Vec3::new(0.5, 0.5, 1.5), [1, 0, -1]));
/// # Ok::<(), dempfv::CellError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[Vec3; 3]", into = "[Vec3; 3]")]
pub struct Cell {
    matrix: Tensor,
    inverse: Tensor,
}

/// Three vectors that are no cell.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CellError {
    /// A number is infinite or none.
    #[error("an edge of the cell is not finite; give three edges of three numbers in m")]
    NotFinite,
    /// A length that is not positive.
    #[error("the cell has an edge of the length {length} m; give three lengths above 0")]
    Length {
        /// The length (m).
        length: f64,
    },
    /// The three edges lie in a plane, or one is zero.
    #[error(
        "the edges of the cell span a volume of {volume:e} m³: they lie in a plane, or nearly; give \
         three edges in metres that do not"
    )]
    Flat {
        /// The volume (m³).
        volume: f64,
    },
    /// The third edge is on the wrong side of the first two.
    #[error(
        "the edges of the cell are left-handed, with a volume of {volume:e} m³; let two change places"
    )]
    LeftHanded {
        /// The volume (m³).
        volume: f64,
    },
}

impl TryFrom<[Vec3; 3]> for Cell {
    type Error = CellError;

    fn try_from(edges: [Vec3; 3]) -> Result<Cell, CellError> {
        Cell::new(edges)
    }
}

impl From<Cell> for [Vec3; 3] {
    fn from(cell: Cell) -> [Vec3; 3] {
        cell.edges()
    }
}

impl Cell {
    /// The cell with these edges (m).
    ///
    /// # Errors
    /// For edges that are not finite, left-handed, or in a plane.
    pub fn new(edges: [Vec3; 3]) -> Result<Cell, CellError> {
        Cell::of_matrix(Tensor::from_columns(&edges))
    }

    /// A right-angled cell with edges of these lengths (m) along the axes.
    ///
    /// # Errors
    /// As [`Cell::new`]; for a length that is not positive.
    pub fn of_size(size: Vec3) -> Result<Cell, CellError> {
        if let Some(&length) = size.iter().find(|&&length| length.is_nan() || length <= 0.0) {
            return Err(CellError::Length { length });
        }
        Cell::of_matrix(Tensor::from_diagonal(&size))
    }

    fn of_matrix(matrix: Tensor) -> Result<Cell, CellError> {
        let volume = matrix.determinant();
        if !(matrix.iter().all(|x| x.is_finite()) && volume.is_finite()) {
            return Err(CellError::NotFinite);
        }
        let product: f64 = matrix.column_iter().map(|edge| edge.norm()).product();
        match matrix.try_inverse() {
            Some(_) if volume < -FLAT * product => Err(CellError::LeftHanded { volume }),
            Some(inverse) if volume > FLAT * product && inverse.iter().all(|x| x.is_finite()) => {
                Ok(Cell { matrix, inverse })
            }
            _ => Err(CellError::Flat { volume }),
        }
    }

    /// The edges a, b, c (m).
    pub fn edges(&self) -> [Vec3; 3] {
        [0, 1, 2].map(|k| self.matrix.column(k).into_owned())
    }

    /// H: the edges as columns (m).
    pub fn matrix(&self) -> &Tensor {
        &self.matrix
    }

    /// Volume (m³).
    pub fn volume(&self) -> f64 {
        self.matrix.determinant()
    }

    /// Lengths of the edges a, b, c (m).
    pub fn lengths(&self) -> [f64; 3] {
        self.edges().map(|edge| edge.norm())
    }

    /// Angles between b and c, c and a, a and b (rad).
    pub fn angles(&self) -> [f64; 3] {
        let [a, b, c] = self.edges();
        [b.angle(&c), c.angle(&a), a.angle(&b)]
    }

    /// Distances between opposite faces (m): of those that b and c, c and a, a and b span.
    pub fn heights(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 1.0 / self.inverse.row(k).norm())
    }

    /// The box around the cell (m).
    pub fn bounds(&self) -> Aabb {
        let side = |pick: fn(f64, f64) -> f64| {
            Vec3::from_fn(|k, _| self.matrix.row(k).iter().fold(0.0, |sum, &x| sum + pick(x, 0.0)))
        };
        Aabb { min: side(f64::min), max: side(f64::max) }
    }

    /// Coordinates of a point along the edges (1): from 0 to below 1 in the cell.
    pub fn fractions(&self, x: &Vec3) -> Vec3 {
        self.inverse * x
    }

    /// The way to the copy n of a point (m): H n.
    pub fn shift(&self, image: [i32; 3]) -> Vec3 {
        self.matrix * Vec3::from(image.map(f64::from))
    }

    /// The copy of a point that is in the cell (m), and the n with x = inside + H n. A point that is
    /// more than 2³¹ cells away stays outside, and one that is no number none.
    pub fn wrap(&self, x: &Vec3) -> (Vec3, [i32; 3]) {
        let image: [i32; 3] = self.fractions(x).map(|f| f.floor() as i32).into();
        (x - self.shift(image), image)
    }

    /// The cell after a step of length `dt` (s) with this velocity gradient (1/s):
    /// H' = (1 + Δt L) H.
    ///
    /// # Errors
    /// As [`Cell::new`], for what is left of it.
    pub fn deformed(&self, velocity_gradient: &Tensor, dt: f64) -> Result<Cell, CellError> {
        Cell::of_matrix(self.matrix + dt * velocity_gradient * self.matrix)
    }

    /// A cell of the same copies whose edges no sum or difference of them can shorten; `None`
    /// where this one is so.
    pub fn reduced(&self) -> Option<Cell> {
        let mut edges = self.edges();
        // Each turn makes the sum of their squares less, of which a lattice has few values.
        while let Some((k, edge)) = shorter(&edges) {
            edges[k] = edge;
        }
        // The volume is that of before: this is a cell.
        (edges != self.edges()).then(|| Cell::new(edges).unwrap_or(*self))
    }
}

/// An edge and a shorter one that takes its place.
fn shorter(edges: &[Vec3; 3]) -> Option<(usize, Vec3)> {
    const TIMES: [f64; 3] = [-1.0, 0.0, 1.0];
    (0..3).find_map(|k| {
        let (old, p, q) = (edges[k], edges[(k + 1) % 3], edges[(k + 2) % 3]);
        let sums = TIMES.iter().flat_map(|i| TIMES.iter().map(move |j| old + *i * p + *j * q));
        let best = sums.min_by(|x, y| x.norm_squared().total_cmp(&y.norm_squared()))?;
        (best.norm_squared() < (1.0 - SHORTER) * old.norm_squared()).then_some((k, best))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skew() -> Cell {
        Cell::new([Vec3::new(2.0, 0.1, 0.0), Vec3::new(0.7, 1.5, -0.2), Vec3::new(-0.3, 0.4, 1.8)])
            .unwrap()
    }

    #[test]
    fn wrapped_points_are_inside_and_their_image_leads_back() {
        let cell = skew();
        for k in 0..200 {
            let x = Vec3::new(f64::from(k).sin(), (1.3 * f64::from(k)).cos(), f64::from(k) - 99.5);
            let (inside, image) = cell.wrap(&x);
            let f = cell.fractions(&inside);
            assert!(f.iter().all(|f| (-1e-12..1.0 + 1e-12).contains(f)), "{f}");
            assert!((inside + cell.shift(image) - x).norm() < 1e-12);
        }
    }

    /// V = height times the area of its face.
    #[test]
    fn heights_are_volume_over_area() {
        let cell = skew();
        let [a, b, c] = cell.edges();
        for (height, area) in
            cell.heights().into_iter().zip([b.cross(&c), c.cross(&a), a.cross(&b)])
        {
            assert!((height * area.norm() / cell.volume() - 1.0).abs() < 1e-14);
        }
    }

    /// Sheared by whole edges and back: the lattice is that of the unit cube again.
    #[test]
    fn a_sheared_cube_is_reduced_to_the_cube() {
        let far = Vec3::new(-7.0, 3.0, 1.0);
        let cell = Cell::new([Vec3::x(), Vec3::new(5.0, 1.0, 0.0), far]).unwrap();
        let reduced = cell.reduced().unwrap();
        assert_eq!(*reduced.matrix(), Tensor::identity());
        assert_eq!(reduced.reduced(), None);
        // Edges at 120° to each other in turn lie nearly in a plane; their sum is short.
        let [a, b] = [Vec3::x(), Vec3::new(-0.5, 0.75f64.sqrt(), 0.0)];
        let flat = Cell::new([a, b, -a - b + 0.1 * Vec3::z()]).unwrap();
        let shortest = flat.reduced().unwrap().lengths().into_iter().fold(f64::INFINITY, f64::min);
        assert!((shortest - 0.1).abs() < 1e-14, "{shortest}");
    }

    #[test]
    fn what_is_no_cell_is_refused() {
        let edges = |c: Vec3| Cell::new([Vec3::x(), Vec3::y(), c]);
        assert!(matches!(edges(-Vec3::z()), Err(CellError::LeftHanded { .. })));
        assert!(matches!(edges(Vec3::x() + Vec3::y()), Err(CellError::Flat { .. })));
        assert!(matches!(edges(Vec3::zeros()), Err(CellError::Flat { .. })));
        assert!(matches!(edges(Vec3::repeat(f64::NAN)), Err(CellError::NotFinite)));
    }
}
