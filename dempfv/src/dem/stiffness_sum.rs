//! How stiff a sphere is held by its contacts: the largest eigenvalues of 3 × 3 matrices.

use super::law::Stiffness;
use crate::Vec3;

/// The stiffness that a sphere's contacts put against its motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StiffnessSum {
    /// Σ k_s.
    shear: f64,
    /// Σ (k_n − k_s) n⊗n.
    excess: Symmetric,
    /// Σ k_s n⊗n.
    shear_along: Symmetric,
}

impl StiffnessSum {
    /// Adds a contact of this normal.
    pub fn add(&mut self, stiffness: Stiffness, normal: &Vec3) {
        self.shear += stiffness.shear;
        self.excess.add_square(stiffness.normal - stiffness.shear, normal);
        self.shear_along.add_square(stiffness.shear, normal);
    }

    /// The largest k over `mass`, or what was the largest so far.
    pub fn fastest(&self, mass: f64, so_far: f64) -> f64 {
        let highest = |bound: f64| (self.shear + bound) / mass;
        if highest(self.excess.bound()) <= so_far {
            return so_far;
        }
        so_far.max(highest(self.excess.largest()))
    }

    /// The same of k_r / r² over `inertia` / r².
    pub fn fastest_rotation(&self, inertia: f64, so_far: f64) -> f64 {
        if self.shear / inertia <= so_far {
            return so_far;
        }
        let least = -self.shear_along.negated().largest();
        so_far.max((self.shear - least) / inertia)
    }
}

/// A symmetric 3 × 3 matrix: xx, yy, zz, xy, yz, zx.
#[derive(Clone, Copy, Debug, Default)]
struct Symmetric([f64; 6]);

impl Symmetric {
    fn add_square(&mut self, factor: f64, n: &Vec3) {
        let entries = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x];
        self.0.iter_mut().zip(entries).for_each(|(sum, entry)| *sum += factor * entry);
    }

    fn negated(&self) -> Symmetric {
        Symmetric(self.0.map(|entry| -entry))
    }

    /// No less than the largest eigenvalue (Gershgorin).
    fn bound(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let (xy, yz, zx) = (xy.abs(), yz.abs(), zx.abs());
        (xx + xy + zx).max(yy + xy + yz).max(zz + yz + zx)
    }

    /// The largest eigenvalue, by the cosine formula for the roots of a cubic (Smith 1961).
    fn largest(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let mean = (xx + yy + zz) / 3.0;
        let (a, b, c) = (xx - mean, yy - mean, zz - mean);
        let size2 = (a * a + b * b + c * c + 2.0 * (xy * xy + yz * yz + zx * zx)) / 6.0;
        if size2 == 0.0 {
            return mean;
        }
        let size = size2.sqrt();
        let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * zx) + zx * (xy * yz - b * zx);
        let angle = (0.5 * determinant / (size2 * size)).clamp(-1.0, 1.0).acos() / 3.0;
        mean + 2.0 * size * angle.cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n⊗n has the eigenvalue 1 along n, whichever way n points, where the diagonal says 1/3; and
    /// sums of such with known eigenvalues.
    #[test]
    fn the_largest_eigenvalue_of_a_block() {
        let n = Vec3::repeat(1.0 / 3f64.sqrt());
        let mut m = Symmetric::default();
        m.add_square(2.0, &n);
        assert!((m.largest() - 2.0).abs() < 1e-14 && m.bound() >= 2.0 - 1e-14);
        assert!((-m.negated().largest()).abs() < 1e-14);
        let mut diagonal = Symmetric::default();
        for (factor, axis) in [(1.0, Vec3::x()), (5.0, Vec3::y()), (-2.0, Vec3::z())] {
            diagonal.add_square(factor, &axis);
        }
        assert!((diagonal.largest() - 5.0).abs() < 1e-13);
        assert_eq!(Symmetric([3.0, 3.0, 3.0, 0.0, 0.0, 0.0]).largest(), 3.0);
    }
}
