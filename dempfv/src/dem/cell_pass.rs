//! What the contact pass reads of a periodic cell, and what it adds up there.

use super::cell::PeriodicCell;
use super::law::vector::{Vector, add_scaled, dot};
use super::law::{Batch, ContactLaw, Geometry, SpherePairs, get};
use crate::{Tensor, Vec3};

/// The copy n of a sphere as a number below 27: each of the three parts is -1, 0 or 1.
pub(super) fn image_index(n: [i32; 3]) -> u8 {
    n.into_iter().fold(0, |index, k| 3 * index + (k + 1) as u8)
}

/// What the contact pass reads of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPass {
    /// H n for each image n (m).
    shift: [Vector; 27],
    /// L (1 + Δt L)⁻¹ by rows (1/s), and Δt (s): the mean field as it was in the last step.
    gradient: [Vector; 3],
    dt: f64,
}

impl CellPass {
    /// The cell as it is.
    pub fn new(cell: &PeriodicCell) -> CellPass {
        let part = |index: i32, place: i32| index / place % 3 - 1;
        let shift = std::array::from_fn(|k| {
            let k = k as i32;
            cell.cell().shift([part(k, 9), part(k, 3), part(k, 1)]).into()
        });
        let dt = cell.last_step();
        let gradient = before_the_step(cell.velocity_gradient(), dt);
        let gradient = [0, 1, 2].map(|a| [0, 1, 2].map(|b| gradient[(a, b)]));
        CellPass { shift, gradient, dt }
    }

    /// The way from the first sphere of a pair to this image of the second (m), where `apart` is
    /// that to the second itself.
    #[inline(always)]
    pub fn image_apart(&self, image: u8, apart: Vector) -> Vector {
        add_scaled(apart, 1.0, self.shift[usize::from(image)])
    }

    /// The way to an image (m), between step and step of a whole pass.
    pub fn shift(&self, image: u8) -> Vec3 {
        self.shift[usize::from(image)].into()
    }

    /// The mean field as it was in the last step, for distances of today: L (1 + Δt L)⁻¹ (1/s).
    pub fn gradient(&self) -> Tensor {
        Tensor::from_fn(|a, b| self.gradient[a][b])
    }

    /// Velocity of a pair that is `apart` (m) whose velocities differ by `relative` (m/s): with
    /// that of the mean field, which was L times the distance of before the step.
    #[inline(always)]
    pub fn with_mean_field(&self, relative: Vector, apart: Vector) -> Vector {
        let before = add_scaled(apart, -self.dt, relative);
        let [x, y, z] = self.gradient.map(|row| dot(row, before));
        add_scaled(relative, 1.0, [x, y, z])
    }
}

/// The matrix that makes L l of (1 + Δt L) l.
fn before_the_step(gradient: &Tensor, dt: f64) -> Tensor {
    // A step that left no cell has been refused.
    let back = (Tensor::identity() + dt * gradient).try_inverse().unwrap_or_default();
    gradient * back
}

/// Sums over contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CellSum {
    /// Σ F_a l_b: the force on the partner, and the way to it (N m), by rows.
    pub moment: [f64; 9],
    /// Σ l_b² (k_n n_a² + k_s (1 − n_a²)): by how much it falls for an affine strain
    /// ∂u_a/∂x_b (N m), by rows.
    pub stiffness: [f64; 9],
}

impl CellSum {
    /// Adds the contacts of a batch.
    #[inline(always)]
    pub fn add_batch<L: ContactLaw>(
        &mut self,
        law: &L,
        batch: &Batch<SpherePairs, L::History>,
        parameters: impl Fn(usize) -> L::Parameters,
    ) {
        for l in 0..batch.count {
            let geometry = &batch.geometry;
            let (force, apart) = (get(&batch.force, l), get(&geometry.apart, l));
            let stiffness = law.stiffness(&parameters(l), geometry.radii(l), geometry.overlap(l));
            let normal = geometry.normal(l);
            let square = normal.map(|n| n * n);
            let along = square.map(|s| stiffness.normal * s + stiffness.shear * (1.0 - s));
            let (moments, _) = self.moment.as_chunks_mut::<3>();
            for (row, f) in moments.iter_mut().zip(force) {
                row.iter_mut().zip(apart).for_each(|(sum, b)| *sum += f * b);
            }
            let (stiffnesses, _) = self.stiffness.as_chunks_mut::<3>();
            for (row, k) in stiffnesses.iter_mut().zip(along) {
                row.iter_mut().zip(apart).for_each(|(sum, b)| *sum += k * (b * b));
            }
        }
    }

    /// Power of the contact forces on pairs in a mean field with this velocity gradient (1/s):
    /// Σ F_a L_ab l_b (W).
    pub fn power(&self, gradient: &Tensor) -> f64 {
        Tensor::from_row_slice(&self.moment).component_mul(gradient).sum()
    }

    /// Adds the sum of another block.
    pub fn add(&mut self, other: &CellSum) {
        let pairs = self.moment.iter_mut().zip(&other.moment);
        for (sum, part) in pairs.chain(self.stiffness.iter_mut().zip(&other.stiffness)) {
            *sum += part;
        }
    }
}
