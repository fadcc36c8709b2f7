//! Local damping (Cundall 1987): takes from forces that drive a motion and
//! adds to those that brake it, without any viscosity.

use super::error::DemError;
use crate::Vec3;

/// Local damping λ, from 0 to less than 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalDamping(f64);

impl LocalDamping {
    /// Refuses what is not from 0 to less than 1.
    pub fn new(damping: f64) -> Result<LocalDamping, DemError> {
        if (0.0..1.0).contains(&damping) {
            Ok(LocalDamping(damping))
        } else {
            Err(DemError::Parameter {
                name: "damping",
                value: damping,
                expected: "from 0 to less than 1",
            })
        }
    }

    /// Each component of the acceleration times 1 − λ sign(a (v + a Δt/2)).
    /// Signs are as good as random in a packing, so there is no branch to
    /// predict here.
    #[inline(always)]
    pub fn damp(self, a: &mut Vec3, v: &Vec3, dt: f64) {
        for k in 0..3 {
            let power = a[k] * (v[k] + 0.5 * dt * a[k]);
            let sign = if power == 0.0 { 0.0 } else { 1f64.copysign(power) };
            a[k] *= 1.0 - self.0 * sign;
        }
    }
}
