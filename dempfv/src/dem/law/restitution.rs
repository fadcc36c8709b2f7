//! Viscous damping of contacts by a coefficient of restitution.

use serde::Serialize;

use super::batch::{Batch, ZERO_LANE, get, put};
use super::geometry::{Geometry, Radii};
use super::loss::Loss;
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::{add_scaled, dot, scaled, tangential};
use crate::dem::error::DemError;
use crate::effect::{Effect, EffectKey, Family};

/// Viscous damping, as an effect.
pub const EFFECT: Effect = Effect {
    name: "viscous contact damping",
    family: Family::Contacts,
    equation: "F_d = 2 s ζ √(m* k) v along the normal and across it, s = 1 for linear springs and √(5/6) with \
               Hertz, k the tangent stiffness; ζ from e = exp(−2 ζ acos ζ / √(1 − ζ²)); spring and dashpot never \
               pull",
    source: "linear: T. Schwager, T. Pöschel: Granular Matter 9 (2007); Hertz: Y. Tsuji et al.: Powder \
             Technology 71 (1992), D. Antypov, J. A. Elliott: EPL 94 (2011)",
    keys: &[
        EffectKey { key: "restitution in [contacts]", unit: "", default: "none" },
        EffectKey { key: "wall_restitution in [contacts]", unit: "", default: "the spheres'" },
    ],
    needs: "",
    test: "dempfv/tests/dem_restitution.rs",
};

/// Speed after a head-on collision over the speed before, whatever that is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Restitution {
    /// Of two spheres.
    pub spheres: f64,
    /// Of a sphere and a wall.
    pub walls: f64,
}

impl Restitution {
    pub(super) fn check(&self) -> Result<(), DemError> {
        for (name, value) in [("restitution", self.spheres), ("wall_restitution", self.walls)] {
            if !(LEAST..=1.0).contains(&value) {
                // A dashpot that takes all of a collision never lets go.
                let expected = "from 0.001 to 1";
                return Err(DemError::Parameter { name, value, expected });
            }
        }
        Ok(())
    }
}

/// The least restitution, for which the dashpot asks for a thirtieth of the time step.
const LEAST: f64 = 1e-3;

/// Restitution of a linear spring with this damping ratio that does not pull: the collision is
/// over where the force has come down to zero. A Hertzian contact with a dashpot that goes with
/// the root of its stiffness is the same oscillator in the variable δ^(5/4).
fn restitution(ratio: f64) -> f64 {
    let frequency = (1.0 - ratio * ratio).abs().sqrt();
    let angle = if ratio < 1.0 { ratio.acos() } else { ratio.acosh() };
    // acos ζ / √(1 − ζ²) tends to 1.
    let quotient = if frequency > 1e-6 { angle / frequency } else { 1.0 };
    (-2.0 * ratio * quotient).exp()
}

/// The damping ratio of a restitution, by bisection.
pub(super) fn damping_ratio(wanted: f64) -> f64 {
    if wanted >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while restitution(high) > wanted {
        high *= 2.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if restitution(middle) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The factor on a stiffness with which an undamped spring has the time step that the damped one
/// needs: (ω Δt)² + 4 ζ ω Δt ≤ 4, since the dashpot feels the velocity half a step late.
pub(super) fn stiffening(ratio: f64) -> f64 {
    (ratio + (1.0 + ratio * ratio).sqrt()).powi(2)
}

/// The dashpots along the normals; `shape` is √(5/6) for Hertz's contact.
#[inline(always)]
pub(super) fn resist<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    shape: f64,
) {
    for l in batch.lanes() {
        let p = parameters(l);
        let mass = batch.geometry.radii(l).reduced_mass(p.densities);
        let coefficient = 2.0 * shape * p.damping_ratio * (mass * terms.stiffness[l]).sqrt();
        let separation = dot(batch.geometry.velocity(l), batch.geometry.normal(l));
        terms.dashpot[l] = coefficient;
        terms.viscous[l] = -coefficient * separation;
    }
}

/// Spring and dashpot together, which may not pull but where a bond holds.
#[inline(always)]
pub(super) fn join<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms) {
    for l in batch.lanes() {
        let elastic = terms.push[l];
        terms.push[l] = (elastic + terms.viscous[l]).max(terms.floor[l]);
        terms.damped[l] = terms.push[l] - elastic;
    }
}

/// The dashpots across the normals: with the stiffness k_t in the place of k.
#[inline(always)]
pub(super) fn drag<G: Geometry, const TORQUES: bool>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let coefficient = parameters(l).shear_ratio.sqrt() * terms.dashpot[l];
        let slip = batch.geometry.slip_velocity::<TORQUES>(l);
        put(&mut terms.drag, l, scaled(-coefficient, slip));
    }
}

/// What the dashpots have dissipated: their forces act over half the way of the step before them and
/// half that of the step after, of which the first is known with the forces of now, and the second
/// with those from `slot` of the history on.
#[inline(always)]
pub(super) fn lose<G: Geometry, const TORQUES: bool>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    slot: usize,
) {
    let mut lost = ZERO_LANE;
    for l in batch.lanes() {
        let (velocity, normal) = (batch.geometry.velocity(l), batch.geometry.normal(l));
        let separation = dot(velocity, normal);
        let slip = batch.geometry.slip_velocity::<TORQUES>(l);
        let now = terms.damped[l] * separation + dot(get(&terms.drag, l), slip);
        let before = [0, 1, 2].map(|k| batch.history[slot + k][l]);
        let half_turn = batch.geometry.sliding::<TORQUES>(l, batch.dt).half_turn;
        let normal_before = add_scaled(normal, -2.0, half_turn);
        // Spins feel what was across the normal of then.
        let across = add_scaled(before, -dot(before, normal_before), normal_before);
        let by_spins = add_scaled(slip, -1.0, tangential(velocity, normal));
        let then = dot(before, velocity) + dot(across, by_spins);
        lost[l] = -0.5 * batch.dt * (now + then);
    }
    batch.book(Loss::ContactDamping, &lost);
}

/// Keeps the dashpots' forces on the second bodies, for the next [`lose`].
#[inline(always)]
pub(super) fn keep<G: Geometry>(batch: &mut Batch<G, Memory>, terms: &Terms, slot: usize) {
    for l in batch.lanes() {
        let drag = get(&terms.drag, l);
        let force = add_scaled(drag, terms.damped[l], batch.geometry.normal(l));
        for (lane, x) in batch.history[slot..].iter_mut().zip(force) {
            lane[l] = x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The formula against a Hertzian collision that is integrated step by step: the mapping of
    /// one on the other holds for every ratio, below critical damping and above.
    #[test]
    fn one_formula_serves_both_springs() {
        for wanted in [0.05, 0.1, 0.3, 0.6, 0.9, 0.99] {
            let ratio = damping_ratio(wanted);
            assert!((restitution(ratio) / wanted - 1.0).abs() < 1e-12, "{wanted} {ratio}");
            let force = |x: f64, v: f64| -> f64 {
                let stiffness = 1.5 * x.max(0.0).sqrt();
                x.max(0.0).powf(1.5) + 2.0 * (5.0f64 / 6.0).sqrt() * ratio * stiffness.sqrt() * v
            };
            let (mut x, mut v, dt) = (0.0, 1.0, 1e-4);
            let mut deepest = false;
            while !deepest || force(x, v) > 0.0 {
                // Midpoint rule.
                let (mx, mv) = (x + 0.5 * dt * v, v - 0.5 * dt * force(x, v));
                (x, v) = (x + dt * mv, v - dt * force(mx, mv));
                deepest |= v < 0.0;
            }
            assert!((-v - wanted).abs() < 1e-4, "{wanted}: {v}");
        }
    }
}
