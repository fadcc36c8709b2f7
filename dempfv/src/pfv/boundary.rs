//! What is imposed on the fluid at the walls.

use serde::{Deserialize, Serialize};

use crate::PerWall;

/// What the fluid does at each wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// Imposed pressure of the pores at each wall (Pa); `None` lets nothing through.
    pub pressure: PerWall<Option<f64>>,
}
