//! What bounds the time step, and how the bounds combine.

use serde::{Deserialize, Serialize};

/// Bounds on the time step (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeStepBounds {
    /// Δt_MK: stability of the contacts, eq. A.2 of Caulk 2020.
    pub contact: f64,
    /// Δt_MV: the paper's estimate of the viscous bound, eq. A.11
    /// ([`viscous_time_step`]); `None` without fluid.
    pub viscous_estimate: Option<f64>,
    /// The viscous bound of the pore network itself,
    /// 2 / (λ_max (1 + damping)), λ_max of V M⁻¹ (eq. A.9); `None` where there
    /// is no network, infinite where the fluid does not resist.
    pub viscous: Option<f64>,
    /// Step of collisions that nothing damps
    /// ([`Dem::collision_time_step`](crate::dem::Dem::collision_time_step)); `None` with local
    /// damping. A longer step is stable, but loses count of the energy.
    pub collision: Option<f64>,
}

/// Which bound makes the time step what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStepRule {
    /// The contacts' stiffness.
    Contacts,
    /// The fluid's viscosity.
    Viscosity,
    /// Both: either alone would allow a step at least a tenth longer.
    Both,
}

impl TimeStepBounds {
    /// The viscous bound that counts (s): that of the network where it is
    /// known, else the paper's estimate; infinite without fluid. The estimate
    /// may lie on either side of the truth.
    pub fn viscosity(&self) -> f64 {
        self.viscous.or(self.viscous_estimate).unwrap_or(f64::INFINITY)
    }

    /// The largest stable time step (s).
    ///
    /// A mode of frequency ω that viscosity stops at the rate γ is stable
    /// under leapfrog with the viscous force of the velocity before the step
    /// while Δt² ω² + 2 Δt γ ≤ 4. With Δt_K = 2/ω and Δt_V = 2/γ that is
    /// (Δt/Δt_K)² + Δt/Δt_V ≤ 1, and it is enough for all modes of a packing
    /// when both bounds are those of its fastest. The smaller bound is never
    /// less than this, and up to 1/0.618 of it.
    ///
    /// ```
    /// use dempfv::coupling::TimeStepBounds;
    /// let bounds = |contact, viscous| {
    ///     TimeStepBounds { contact, viscous, viscous_estimate: None, collision: None }
    /// };
    /// assert_eq!(bounds(1e-5, None).limit(), 1e-5);
    /// assert!((bounds(1.0, Some(1.0)).limit() - 0.618).abs() < 1e-3);
    /// assert!((bounds(1.0, Some(1e-6)).limit() - 1e-6).abs() < 1e-11);
    /// ```
    pub fn limit(&self) -> f64 {
        let (k, v) = (1.0 / self.contact, 1.0 / self.viscosity());
        2.0 / (v + v.hypot(2.0 * k))
    }

    /// The time step that `dt = "auto"` takes (s): this share of the limit, and no more than
    /// collisions without damping allow. Not a number where `safety` or a bound is not positive.
    pub fn automatic(&self, safety: f64) -> f64 {
        let (stable, collision) = (safety * self.limit(), self.collision.unwrap_or(f64::INFINITY));
        let makes_sense = self.contact > 0.0 && self.viscosity() > 0.0 && collision > 0.0;
        if makes_sense && stable > 0.0 { stable.min(collision) } else { f64::NAN }
    }

    /// Which bound rules.
    pub fn rule(&self) -> TimeStepRule {
        let limit = self.limit();
        if limit > 0.9 * self.contact {
            TimeStepRule::Contacts
        } else if limit > 0.9 * self.viscosity() {
            TimeStepRule::Viscosity
        } else {
            TimeStepRule::Both
        }
    }
}

/// The automatic time step between two looks at what bounds it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct AutoTimeStep {
    /// The bounds of the last look.
    bounds: Option<TimeStepBounds>,
    /// Steps left until the next.
    left: u64,
}

impl AutoTimeStep {
    /// The bounds of the last look; `None` where the next step looks anew.
    pub fn known(&self) -> Option<TimeStepBounds> {
        self.bounds.filter(|_| self.left > 0)
    }

    /// The bounds of the last look.
    pub fn last(&self) -> Option<TimeStepBounds> {
        self.bounds
    }

    /// Takes what a look has found, and in how many steps to look again.
    pub fn looked(&mut self, bounds: TimeStepBounds, steps: u64) {
        *self = AutoTimeStep { bounds: Some(bounds), left: steps };
    }

    /// A step goes by without a look.
    pub fn pass(&mut self) {
        self.left = self.left.saturating_sub(1);
    }

    /// Makes the next step look.
    pub fn refresh(&mut self) {
        self.left = 0;
    }
}

impl std::fmt::Display for TimeStepRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            TimeStepRule::Contacts => "the contacts' stiffness",
            TimeStepRule::Viscosity => "the fluid's viscosity",
            TimeStepRule::Both => "contacts and viscosity together",
        })
    }
}

/// `2 min(π ρ d² / (8000 μ))`, eq. A.11 of Caulk 2020 (s), for the smallest
/// sphere of this radius (m).
///
/// It knows sizes only, not how narrow the pores are: on dense packings the
/// true bound ([`ViscousMode`](crate::pfv::ViscousMode)) can be many times
/// less. Not a number where an argument is not positive.
pub fn viscous_time_step(smallest_radius: f64, density: f64, viscosity: f64) -> f64 {
    if !(smallest_radius > 0.0 && density > 0.0 && viscosity > 0.0) {
        return f64::NAN;
    }
    2.0 * std::f64::consts::PI * density * (2.0 * smallest_radius).powi(2) / (8000.0 * viscosity)
}
