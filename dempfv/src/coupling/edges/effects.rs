//! Which forces the edges of a network carry.

use serde::{Deserialize, Serialize};

use crate::coupling::error::{CouplingError, Result, positive};

/// Forces on the edges of the triangulation; all are off unless someone asks for them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeEffects {
    /// Drag of neighbours that move past each other, over the facet between their power cells.
    pub viscous_shear: bool,
    /// Pressure in the film between two surfaces that come closer, or part.
    pub normal_lubrication: bool,
    /// Drag in the film between two surfaces that slide.
    pub shear_lubrication: bool,
    /// Couple against two spheres that roll on each other.
    pub pump_torque: bool,
    /// Couple against two spheres that twist about the line of their centres.
    pub twist_torque: bool,
    /// Height of the surfaces' roughness as a share of the radius (1). A film is no thinner than
    /// that of both together.
    pub roughness: f64,
    /// Modulus of the springs in series with the films (Pa), in the place of E in those of linear
    /// contacts; `None`: E of the bodies themselves.
    pub stiffness: Option<f64>,
}

impl Default for EdgeEffects {
    /// None, with a roughness of 10⁻⁵.
    fn default() -> EdgeEffects {
        EdgeEffects {
            viscous_shear: false,
            normal_lubrication: false,
            shear_lubrication: false,
            pump_torque: false,
            twist_torque: false,
            roughness: 1e-5,
            stiffness: None,
        }
    }
}

impl EdgeEffects {
    /// Whether any of them is on.
    pub fn any(&self) -> bool {
        self.viscous_shear || self.lubricates()
    }

    /// Whether any of them goes with the thickness of a film.
    pub fn lubricates(&self) -> bool {
        self.normal_lubrication || self.shear_lubrication || self.pump_torque || self.twist_torque
    }

    /// Whether one of them grows without bound where smooth surfaces touch.
    pub fn needs_roughness(&self) -> bool {
        self.shear_lubrication || self.pump_torque
    }

    /// Whether they turn spheres.
    pub(super) fn turns(&self) -> bool {
        self.viscous_shear || self.shear_lubrication || self.pump_torque || self.twist_torque
    }

    /// Refuses constants that make no sense.
    pub(super) fn check(&self) -> Result<()> {
        if !self.any() {
            return Ok(());
        }
        let EdgeEffects { roughness, stiffness, .. } = *self;
        let least = if self.needs_roughness() { f64::MIN_POSITIVE } else { 0.0 };
        if !(roughness >= least && roughness.is_finite()) {
            let expected = match self.needs_roughness() {
                true => "positive and finite: smooth surfaces that touch resist slip without bound",
                false => "finite, 0 or more",
            };
            return Err(CouplingError::Parameter { name: "roughness", value: roughness, expected });
        }
        stiffness.map_or(Ok(()), |modulus| positive("stiffness of lubricated surfaces", modulus))
    }
}
