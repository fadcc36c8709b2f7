//! What spheres and walls are made of.

use serde::{Deserialize, Serialize};

use super::error::DemError;

/// What the spheres are made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Contact modulus E (Pa): two spheres of radii r₁, r₂ have the normal
    /// stiffness k_n = 2 E r₁ r₂ / (r₁ + r₂).
    pub young: f64,
    /// Ratio of shear to normal stiffness, k_s / k_n.
    pub stiffness_ratio: f64,
    /// Friction angle between spheres (rad).
    pub friction_angle: f64,
    /// Density of the solid (kg/m³).
    pub density: f64,
}

/// What the walls are made of. The shear stiffness of a sphere on a wall has
/// the spheres' ratio to its normal stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallMaterial {
    /// Contact modulus (Pa): a sphere on a wall has the stiffness that it
    /// would have on a sphere of its own radius and this modulus.
    pub young: f64,
    /// Friction angle of the walls (rad); a contact takes the smaller of its
    /// sphere's and its wall's.
    pub friction_angle: f64,
}

impl Material {
    /// Checks that the values are physical.
    pub(super) fn check(&self) -> Result<(), DemError> {
        positive("young", self.young)?;
        positive("density", self.density)?;
        if !(self.stiffness_ratio >= 0.0 && self.stiffness_ratio.is_finite()) {
            return Err(DemError::Parameter {
                name: "stiffness_ratio",
                value: self.stiffness_ratio,
                expected: "zero or positive",
            });
        }
        check_friction(self.friction_angle)
    }
}

impl WallMaterial {
    /// Checks that the values are physical.
    pub(super) fn check(&self) -> Result<(), DemError> {
        positive("wall young", self.young)?;
        check_friction(self.friction_angle)
    }
}

/// Refuses what is not a positive finite number.
pub(super) fn positive(name: &'static str, value: f64) -> Result<(), DemError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(DemError::Parameter { name, value, expected: "positive and finite" })
    }
}

/// Refuses what is infinite or no number.
pub(super) fn finite(name: &'static str, value: f64) -> Result<(), DemError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(DemError::Parameter { name, value, expected: "finite" })
    }
}

/// Refuses what is no friction angle.
pub(super) fn check_friction(angle: f64) -> Result<(), DemError> {
    if (0.0..std::f64::consts::FRAC_PI_2).contains(&angle) {
        Ok(())
    } else {
        Err(DemError::Parameter {
            name: "friction_angle",
            value: angle,
            expected: "from 0 to less than π/2 rad",
        })
    }
}
