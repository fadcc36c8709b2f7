//! Which pore a point lies in.

use nalgebra::{Matrix4, Vector4};

use super::packing_check::require_length;
use super::{NONE, PfvError, Tessellation};
use crate::{Vec3, WallId};

impl Tessellation {
    /// The cell that contains a point of the box, from the centres (m) of the spheres that
    /// were triangulated. What lies between a facet and a wall belongs to the cell of that
    /// facet and wall. [`NONE`] if there is none, which takes a point that is no number.
    /// Looks at every cell.
    ///
    /// A point on a facet belongs to one of the cells there, the same every time.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when there is not one position per sphere.
    pub fn locate(&self, position: &[Vec3], point: &Vec3) -> Result<u32, PfvError> {
        require_length("position", position.len(), self.spheres, "spheres")?;
        let mut found = (NONE, f64::NEG_INFINITY);
        for (cell, number) in self.cells.iter().zip(0u32..) {
            if !self.is_near(cell, position, point) {
                continue;
            }
            let depth = self.depth(cell, position, point);
            if depth > found.1 {
                found = (number, depth);
            }
        }
        Ok(found.0)
    }

    /// Whether a point lies in the box around a cell, which reaches to infinity beyond the
    /// cell's walls.
    fn is_near(&self, cell: &[u32; 4], position: &[Vec3], point: &Vec3) -> bool {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for &v in cell {
            match (position.get(v as usize), self.wall(v)) {
                (Some(x), _) => (low, high) = (low.inf(x), high.sup(x)),
                (None, Some(wall)) if wall.is_max() => high[wall.axis()] = f64::INFINITY,
                (None, Some(wall)) => low[wall.axis()] = f64::NEG_INFINITY,
                (None, None) => return false,
            }
        }
        (0..3).all(|k| low[k] <= point[k] && point[k] <= high[k])
    }

    /// The smallest of a point's four coordinates in a cell: not negative inside it, and
    /// negative infinity for a cell without volume.
    ///
    /// A point is a sum of the cell's vertices. The shares of the spheres add up to 1. A
    /// wall's vertex is the direction towards it, the limit of the huge sphere behind the
    /// wall; its share is a length.
    fn depth(&self, cell: &[u32; 4], position: &[Vec3], point: &Vec3) -> f64 {
        // Homogeneous coordinates, from the point on: spheres end in 1, directions in 0.
        let vertex = |v: u32| match position.get(v as usize) {
            Some(x) => {
                let x = x - point;
                Vector4::new(x.x, x.y, x.z, 1.0)
            }
            None => {
                let outward = -WallId::ALL[v as usize - self.spheres].inward_normal();
                Vector4::new(outward.x, outward.y, outward.z, 0.0)
            }
        };
        let corners = Matrix4::from_columns(&cell.map(vertex));
        match corners.lu().solve(&Vector4::new(0.0, 0.0, 0.0, 1.0)) {
            Some(shares) if shares.iter().all(|s| s.is_finite()) => shares.min(),
            _ => f64::NEG_INFINITY,
        }
    }
}
