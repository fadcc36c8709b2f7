//! How often this process has called for what takes long: counted where it begins, so that what is off
//! can be seen to be off.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;

pub(crate) static TRIANGULATIONS: AtomicU64 = AtomicU64::new(0);
pub(crate) static ANALYSES: AtomicU64 = AtomicU64::new(0);
pub(crate) static FACTORIZATIONS: AtomicU64 = AtomicU64::new(0);
pub(crate) static NEIGHBOUR_LISTS: AtomicU64 = AtomicU64::new(0);

/// Notes a call.
pub(crate) fn count(calls: &AtomicU64) {
    calls.fetch_add(1, Ordering::Relaxed);
}

/// Calls of this process, of all that it simulates together.
///
/// ```
/// use dempfv::Calls;
/// use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
/// use dempfv::{Aabb, Vec3};
///
/// let material =
///     Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
/// let sphere = Particles::new(vec![Vec3::repeat(0.5)], vec![0.4], material.density);
/// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
/// let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
/// Dem::new(sphere, bounds, material, walls, DemOptions::default())?;
/// assert!(Calls::so_far().neighbour_lists > 0);
/// # Ok::<(), dempfv::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Calls {
    /// Triangulations by CGAL, one for each network.
    pub triangulations: u64,
    /// Orderings and symbolic analyses of matrices, by CHOLMOD and METIS or the frontal solver.
    pub analyses: u64,
    /// Factorizations, by CHOLMOD or the frontal solver.
    pub factorizations: u64,
    /// Neighbour lists of the contacts.
    pub neighbour_lists: u64,
}

impl Calls {
    /// Those since the process began.
    pub fn so_far() -> Calls {
        let number = |calls: &AtomicU64| calls.load(Ordering::Relaxed);
        Calls {
            triangulations: number(&TRIANGULATIONS),
            analyses: number(&ANALYSES),
            factorizations: number(&FACTORIZATIONS),
            neighbour_lists: number(&NEIGHBOUR_LISTS),
        }
    }
}
