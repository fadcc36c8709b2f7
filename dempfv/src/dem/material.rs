//! What spheres and walls are made of.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "several materials",
    family: Family::Contacts,
    equation: "each contact by a table of the pairs of materials; what a pair does not state follows from both",
    source: "",
    keys: &[
        EffectKey {
            key: "density in [[material]]", unit: "kg/m³", default: "that of [particles]"
        },
        EffectKey {
            key: "young in [[material]] and [[pair]]",
            unit: "Pa",
            default: "likewise; from both",
        },
        EffectKey {
            key: "stiffness_ratio in [[material]] and [[pair]]",
            unit: "",
            default: "likewise",
        },
        EffectKey {
            key: "friction_angle in [[material]] and [[pair]]",
            unit: "degrees",
            default: "likewise",
        },
    ],
    needs: "",
    test: "dempfv/tests/dem_materials.rs",
};

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

/// What two materials have against each other, in the place of what follows from both of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialPair {
    /// Indices of the two materials, in either order; twice the same for spheres of one material.
    pub between: [u16; 2],
    /// Contact modulus that both have here (Pa).
    pub young: Option<f64>,
    /// Ratio of shear to normal stiffness.
    pub stiffness_ratio: Option<f64>,
    /// Friction angle (rad).
    pub friction_angle: Option<f64>,
}

impl MaterialPair {
    /// Checks that it is one of `count` materials, with values that are physical.
    pub(super) fn check(&self, materials: &[Material]) -> Result<(), DemError> {
        for index in self.between {
            match materials.get(usize::from(index)) {
                Some(material) => self.of(material).check()?,
                None => {
                    let (name, value) = ("material of a pair", f64::from(index));
                    return Err(DemError::Parameter { name, value, expected: "one that there is" });
                }
            }
        }
        Ok(())
    }

    /// Whether it is of these two.
    pub(super) fn joins(&self, first: usize, second: usize) -> bool {
        let [a, b] = self.between.map(usize::from);
        (a, b) == (first, second) || (b, a) == (first, second)
    }

    /// One of its materials as it is against the other.
    pub(super) fn of(&self, material: &Material) -> Material {
        Material {
            young: self.young.unwrap_or(material.young),
            stiffness_ratio: self.stiffness_ratio.unwrap_or(material.stiffness_ratio),
            friction_angle: self.friction_angle.unwrap_or(material.friction_angle),
            density: material.density,
        }
    }
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
