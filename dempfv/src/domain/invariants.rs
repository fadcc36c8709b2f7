//! What of a stress does not depend on the axes.

use super::Tensor;

/// Mean normal stress, tr σ / 3 (Pa).
///
/// ```
/// use dempfv::{Tensor, Vec3, deviatoric_stress, mean_stress};
/// let triaxial = Tensor::from_diagonal(&Vec3::new(1e5, 3e5, 1e5));
/// assert!((mean_stress(&triaxial) - 5e5 / 3.0).abs() < 1e-9);
/// assert!((deviatoric_stress(&triaxial) - 2e5).abs() < 1e-9);
/// ```
pub fn mean_stress(stress: &Tensor) -> f64 {
    stress.trace() / 3.0
}

/// Deviatoric stress q = √(3/2 s:s) (Pa), s the symmetric part of σ without its mean: σ₁ − σ₃ in a
/// triaxial test, √3 τ in simple shear.
pub fn deviatoric_stress(stress: &Tensor) -> f64 {
    let symmetric = 0.5 * (stress + stress.transpose());
    let deviator = symmetric - Tensor::from_diagonal_element(mean_stress(stress));
    (1.5 * deviator.norm_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simple shear: q = √3 τ (Wood 1990, Soil Behaviour and Critical State Soil Mechanics, §1.4), however
    /// the pressure.
    #[test]
    fn shear_stress_counts_by_the_root_of_three() {
        let mut stress = Tensor::from_diagonal_element(7.0);
        (stress[(0, 1)], stress[(1, 0)]) = (-2.0, -2.0);
        assert!((deviatoric_stress(&stress) - 2.0 * 3f64.sqrt()).abs() < 1e-14);
        assert_eq!(mean_stress(&stress), 7.0);
    }
}
