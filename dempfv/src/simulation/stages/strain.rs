//! Strain of the box.

use crate::Aabb;

/// Logarithmic strain along each axis, compression positive.
pub(super) fn logarithmic_strain(from: &Aabb, to: &Aabb) -> [f64; 3] {
    from.size().zip_map(&to.size(), |a, b| (a / b).ln()).into()
}
