//! The fluid and what it meets at the walls.

use serde::{Deserialize, Serialize};

use super::Clamp;

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

/// What the fluid does at each wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// Imposed pressure of each wall (Pa); `None` lets nothing through.
    pub pressure: [Option<f64>; 6],
}
