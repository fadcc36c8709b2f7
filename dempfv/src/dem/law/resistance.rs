//! A spring, a dashpot and a slider against one kind of turning.

use serde::Serialize;

use super::restitution::stiffening;
use crate::dem::error::DemError;

/// Resistance against rolling or against twisting, as a force on the arm of the reduced radius R*.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resistance {
    /// The largest moment over R* F_n.
    pub friction: f64,
    /// Stiffness of the spring over the normal stiffness.
    pub stiffness_ratio: f64,
    /// Damping ratio of a sphere that turns on the spring alone.
    pub damping_ratio: f64,
}

/// I / r² of a sphere over its mass.
const INERTIA: f64 = 0.4;

impl Resistance {
    pub(super) fn check(&self, names: [&'static str; 3]) -> Result<(), DemError> {
        let Resistance { friction, stiffness_ratio, damping_ratio } = *self;
        let [of_friction, of_stiffness, of_damping] = names;
        for (name, value, zero) in [
            (of_friction, friction, false),
            (of_stiffness, stiffness_ratio, false),
            (of_damping, damping_ratio, true),
        ] {
            if !(value.is_finite() && (value > 0.0 || (zero && value == 0.0))) {
                let expected = if zero { "zero or positive" } else { "positive and finite" };
                return Err(DemError::Parameter { name, value, expected });
            }
        }
        Ok(())
    }

    /// Stiffness of the spring (N/m) for the contact's normal one.
    #[inline(always)]
    pub(super) fn spring(&self, stiffness: f64) -> f64 {
        self.stiffness_ratio * stiffness
    }

    /// Coefficient of the dashpot (N s/m) for the contact's normal stiffness and reduced mass.
    #[inline(always)]
    pub(super) fn dashpot(&self, stiffness: f64, mass: f64) -> f64 {
        2.0 * self.damping_ratio * (INERTIA * mass * self.spring(stiffness)).sqrt()
    }

    /// Shear stiffness over normal stiffness that asks for the same time step.
    pub(super) fn shear_ratio(&self) -> f64 {
        self.stiffness_ratio * stiffening(self.damping_ratio)
    }
}
