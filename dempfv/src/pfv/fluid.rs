//! The fluid and what it meets at the walls.

use serde::{Deserialize, Serialize};

use super::throat::ThroatRules;
use super::{Boundary, Clamp};

/// An incompressible viscous fluid in the pores, and its walls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fluid {
    /// Dynamic viscosity (Pa·s).
    pub viscosity: f64,
    /// Whether the fluid slips along the walls (YADE's default) or sticks.
    pub slip_walls: bool,
    /// Bounds on the conductances.
    pub clamp: Clamp,
    /// What happens at each wall.
    pub boundary: Boundary,
}

impl Fluid {
    /// Which walls drag.
    pub(super) fn throat_rules(&self) -> ThroatRules {
        let open = self.boundary.pressure.0.map(|p| p.is_some());
        ThroatRules {
            slip: self.slip_walls,
            open,
            limited: self.clamp.is_limited(),
            balanced: false,
        }
    }
}
