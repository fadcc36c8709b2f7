//! A pressure that differs from place to place along a wall.

use serde::{Deserialize, Serialize};

use super::PfvError;
use crate::{Axis, Effect, EffectKey, Family, WallId};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "pressure profiles",
    family: Family::Fluid,
    equation: "p_i = p_wall(t) + profile(x_i), x_i the coordinate of the pore's centre",
    source: "a boundary condition",
    keys: &[EffectKey { key: "pressure in [fluid]", unit: "Pa", default: "the same all along" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_conditions.rs",
};

/// A pressure along a wall, beside the one that is the same all along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureProfile {
    /// The axis along which it changes.
    pub along: Axis,
    /// Coordinate (m) and pressure (Pa), each farther along than the one before: straight lines
    /// between them, the first and the last pressure beyond them.
    pub points: Vec<[f64; 2]>,
}

impl PressureProfile {
    /// The pressure at a coordinate (Pa); not a number without points.
    pub fn value(&self, x: f64) -> f64 {
        let after = self.points.partition_point(|[at, _]| *at <= x);
        match (after.checked_sub(1).map(|before| self.points[before]), self.points.get(after)) {
            (Some([a, p]), Some([b, q])) => p + (q - p) * ((x - a) / (b - a)),
            (Some([_, p]), None) | (None, Some(&[_, p])) => p,
            (None, None) => f64::NAN,
        }
    }

    /// What is wrong with it at a wall, and what would be right; `None` where nothing is.
    pub fn problem(&self, wall: WallId) -> Option<(&'static str, &'static str)> {
        if self.along == Axis::of(wall) {
            return Some((
                "has a profile along the axis that the wall is normal to",
                "give one of the two axes along the wall",
            ));
        }
        let finite = self.points.iter().flatten().all(|x| x.is_finite());
        let ascending = self.points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let wrong = self.points.is_empty() || !finite || !ascending;
        wrong.then_some((
            "has a profile that is no function of the coordinate",
            "give one or more points [coordinate, pressure] in finite numbers, each farther along than the one before",
        ))
    }

    /// Refuses what has a [`PressureProfile::problem`].
    pub(super) fn check(&self, wall: WallId) -> Result<(), PfvError> {
        match self.problem(wall) {
            None => Ok(()),
            Some((problem, remedy)) => {
                let problem = format!("{wall} {problem}; {remedy}");
                Err(PfvError::invalid("pressure profile", wall.index(), problem))
            }
        }
    }
}
