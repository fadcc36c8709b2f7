//! What a mean pressure gradient puts on the spheres of a periodic cell.

use crate::Vec3;

/// A mean gradient and what follows from it.
#[derive(Clone, Debug, Default)]
pub(super) struct GradientLoad {
    pub gradient: Vec3,
    /// What it drives through all throats together (m³/s), to measure round-off by: in a lattice what
    /// it drives into a pore is round-off.
    pub through: f64,
    /// Its force on each sphere (N).
    pub force: Vec<Vec3>,
}

impl GradientLoad {
    /// Adds its forces (N); none where there is no gradient.
    pub fn add_to(&self, force: &mut [Vec3]) {
        force.iter_mut().zip(&self.force).for_each(|(f, load)| *f += load);
    }
}
