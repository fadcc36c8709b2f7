//! The bounds on the time step of spheres and fluid together.

use serde::{Deserialize, Serialize};

use super::edges::EdgeForces;
use super::error::Result;
use super::time_step::{TimeStepBounds, viscous_time_step};
use crate::dem::{Dem, WallControl};
use crate::pfv::{Flow, ViscousMode};

/// A viscous bound of more than so many times the contacts' (1) need not be
/// known well: it takes less than this share of their step away.
const NEGLIGIBLE_BOUND_RATIO: f64 = 50.0;

/// The fastest viscous mode of the network in use, or of one before it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct FastestMode {
    mode: Option<ViscousMode>,
    /// The walls held by a servo when it was found; `None` when it is the mode
    /// of an earlier network.
    servo: Option<[bool; 6]>,
    /// Length of the steps that the network was factored for (s), where its pores store fluid.
    time_step: Option<f64>,
}

impl FastestMode {
    /// The same mode, for a new network to start from.
    pub fn outdated(self) -> FastestMode {
        FastestMode { servo: None, ..self }
    }

    /// Whether the mode is known for the network in use and these walls.
    pub fn is_current(&self, dem: &Dem) -> bool {
        self.servo == Some(servo_walls(dem))
    }

    /// Finds the mode; roughly, unless `exact`, where the contacts bound the
    /// time step anyway.
    pub fn update(&mut self, flow: &mut Flow, dem: &mut Dem, exact: bool) -> Result<()> {
        let servo = servo_walls(dem);
        let start = self.mode.as_ref().map(|m| &m.shape[..]);
        let negligible = match exact {
            true => 0.0,
            false => {
                bound_of(NEGLIGIBLE_BOUND_RATIO * dem.safe_time_step(1.0), dem.options().damping)
            }
        };
        self.mode = flow.viscous_mode(&dem.storage().mass, servo, start, negligible)?;
        self.servo = Some(servo);
        self.time_step = flow.time_step();
        Ok(())
    }

    /// The mode of the network in use, if it is known.
    pub fn current(&self) -> Option<&ViscousMode> {
        self.mode.as_ref().filter(|_| self.servo.is_some())
    }

    /// The viscous bound of the network in use (s): infinite where nothing
    /// resists, `None` where it is not known.
    fn bound(&self, damping: f64) -> Option<f64> {
        self.servo?;
        Some(bound_of(self.mode.as_ref().map_or(0.0, ViscousMode::upper_rate), damping))
    }
}

/// The bound (s) that a viscous rate (1/s) sets to the time step, or the rate
/// that sets a bound: 2/x, over 1 + the local damping. That damping makes a
/// force which brakes larger by its factor, and a viscous force always brakes.
fn bound_of(x: f64, damping: f64) -> f64 {
    2.0 / (x * (1.0 + damping))
}

/// The viscous bound (s) of a compressible fluid beside contacts with theirs, from that of a network
/// for steps of length `found_for`.
///
/// In a step Δt such a fluid resists by V(Δt) = F (G + S/Δt)⁻¹ E: less than without storage, the more
/// so the shorter the step. V(Δt) grows with Δt and V(Δt)/Δt falls, so for longer steps than that of
/// the network the rate is at most λ Δt/Δt₀: the fluid then counts as a spring. The mode that alternates
/// from step to step even sees S/Δt twice, which is left out and on the safe side.
fn compressible(contact: f64, bound: f64, found_for: f64) -> f64 {
    let (k, v) = (1.0 / contact, 1.0 / bound);
    if 2.0 / (v + v.hypot(2.0 * k)) <= found_for {
        return bound;
    }
    let step = 1.0 / k.hypot((v / found_for).sqrt());
    bound * found_for / step
}

/// The walls that a servo holds.
fn servo_walls(dem: &Dem) -> [bool; 6] {
    dem.walls().map(|w| matches!(w.control, WallControl::Servo { .. })).0
}

/// The bounds of spheres with or without a fluid of this viscosity (Pa·s).
pub(super) fn bounds(
    dem: &mut Dem,
    viscosity: Option<f64>,
    fastest: Option<&FastestMode>,
    edges: Option<&mut EdgeForces>,
) -> TimeStepBounds {
    let smallest = dem.storage().radius.iter().copied().fold(f64::INFINITY, f64::min);
    let lightest = dem.materials().iter().map(|m| m.density).fold(f64::INFINITY, f64::min);
    let contact = dem.safe_time_step(1.0);
    let viscous = fastest.and_then(|f| {
        let bound = f.bound(dem.options().damping)?;
        Some(f.time_step.map_or(bound, |found_for| compressible(contact, bound, found_for)))
    });
    let edges = edges.map_or(0.0, |edges| edges.rate(dem, contact));
    // Rates of two drags on one motion add up, at most.
    let with_edges =
        |bound: f64| 1.0 / (1.0 / bound + 1.0 / bound_of(edges, dem.options().damping));
    TimeStepBounds {
        contact,
        viscous_estimate: viscosity.map(|mu| with_edges(viscous_time_step(smallest, lightest, mu))),
        viscous: viscous.map(with_edges),
        collision: (dem.options().damping == 0.0).then(|| dem.collision_time_step()),
    }
}
