//! What is imposed on the fluid at the walls, and on pores without a way to them.

use serde::{Deserialize, Serialize};

use crate::PerWall;

/// What the fluid does at each wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// Imposed pressure of the pores at each wall (Pa); `None` lets nothing through.
    pub pressure: PerWall<Option<f64>>,
    /// What holds for pores without a path to an imposed pressure.
    pub sealed_pores: SealedPoreRule,
}

/// What holds for pores without a path to an imposed pressure
/// ([`SealedPores`](super::SealedPores)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SealedPoreRule {
    /// They keep their fluid: their pressures are known but for a constant, and a motion that
    /// changes the volume of a group of them has no solution and is refused.
    #[default]
    Closed,
    /// Each is held at the mean of the imposed pressures (0 where there are none), as if it had
    /// a drain of its own: whatever it swallows or gives off comes from nowhere.
    Drained,
}

impl SealedPoreRule {
    /// Every rule.
    pub const ALL: [SealedPoreRule; 2] = [SealedPoreRule::Closed, SealedPoreRule::Drained];

    /// The rule's name in scenes.
    pub const fn name(self) -> &'static str {
        ["closed", "drained"][self as usize]
    }
}
