//! Bounds on the conductances.

use std::fmt;
use std::str::FromStr;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::throat::Throat;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "conductance clamp",
    family: Family::Fluid,
    equation: "g within two factors of a mean conductance",
    source: "docs/scene.md; YADE clamps by default",
    keys: &[EffectKey { key: "clamp in [fluid]", unit: "", default: "\"none\"" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_network.rs",
};

/// Bounds on the conductances, relative to a mean one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clamp {
    /// Conductances as the geometry gives them: of closed throats zero, and where the formulas
    /// leave geometry, within its limits.
    #[default]
    None,
    /// Between 1e-4 and 100 times the mean conductance
    /// `g = mean(A_f) (2 V_fluid / A_solid)² / (8 μ mean(l))`.
    Relative,
    /// Conductances as the formulas give them, without the limits that geometry sets, for
    /// comparisons with YADE: where spheres overlap so much that a throat's fluid area or volume
    /// falls below zero, its size counts.
    Unlimited,
    /// As [`Clamp::Unlimited`], between 1e-4 and 100 times `K = mean(l) V_fluid / (8 μ A_solid)`, for
    /// comparisons with YADE. `K` is in m²/(Pa·s) where a conductance is in
    /// m³/(Pa·s), so what this clamps depends on the unit of length.
    Yade,
}

impl Clamp {
    /// All clamps, by name.
    pub const ALL: [Clamp; 4] = [Clamp::None, Clamp::Relative, Clamp::Unlimited, Clamp::Yade];

    /// Name in scenes and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Clamp::None => "none",
            Clamp::Relative => "relative",
            Clamp::Unlimited => "unlimited",
            Clamp::Yade => "yade",
        }
    }

    /// Whether geometry limits the throats.
    pub(super) const fn is_limited(self) -> bool {
        matches!(self, Clamp::None | Clamp::Relative)
    }

    /// Smallest and largest conductance allowed (m³/(Pa·s)).
    pub(super) fn bounds(self, throats: &[Throat], viscosity: f64) -> (f64, f64) {
        if matches!(self, Clamp::None | Clamp::Unlimited) {
            return (0.0, f64::INFINITY);
        }
        let count = throats.len() as f64;
        let length = sum(throats, |t| t.length) / count;
        let radius = sum(throats, |t| t.fluid_volume) / sum(throats, |t| t.solid_area);
        let mean = match self {
            Clamp::Yade => length * radius / (8.0 * viscosity),
            _ => {
                sum(throats, |t| t.fluid_area) / count * (2.0 * radius).powi(2)
                    / (8.0 * viscosity * length)
            }
        };
        (1e-4 * mean, 100.0 * mean)
    }
}

impl fmt::Display for Clamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no clamp has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown clamp `{0}`; the clamps are none, relative, unlimited and yade")]
pub struct UnknownClamp(pub String);

impl FromStr for Clamp {
    type Err = UnknownClamp;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        Clamp::ALL.into_iter().find(|c| c.name() == s).ok_or_else(|| UnknownClamp(s.to_owned()))
    }
}

/// A sum in chunks of fixed size, so that its bits do not depend on threads.
fn sum(throats: &[Throat], value: impl Fn(&Throat) -> f64 + Sync) -> f64 {
    let parts: Vec<f64> =
        throats.par_chunks(4096).map(|chunk| chunk.iter().map(&value).sum()).collect();
    parts.iter().sum()
}
