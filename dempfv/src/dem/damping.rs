//! Local damping (Cundall 1987): takes from forces that drive a motion and
//! adds to those that brake it, without any viscosity.

use super::error::DemError;
use crate::Vec3;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "local damping",
    family: Family::Bodies,
    equation: "a_k → a_k (1 − λ sign(a_k (v_k + a_k Δt/2))), and so for spins",
    source: "P. A. Cundall: Distinct element models of rock and soil structure (1987)",
    keys: &[
        EffectKey { key: "damping in [dem]", unit: "", default: "0.2" },
        EffectKey { key: "damping in a stage", unit: "", default: "that of [dem]" },
    ],
    needs: "",
    test: "dempfv/tests/dem_energy.rs",
};

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

    /// [`LocalDamping::damp`] for a load and the mean velocity of the step that it acts with.
    pub fn damp_by(self, load: &mut Vec3, velocity: &Vec3) {
        for k in 0..3 {
            let power = load[k] * velocity[k];
            let sign = if power == 0.0 { 0.0 } else { 1f64.copysign(power) };
            load[k] *= 1.0 - self.0 * sign;
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
