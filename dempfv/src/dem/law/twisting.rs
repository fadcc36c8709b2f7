//! Twisting resistance: against the turning of two bodies about their common normal.

use super::batch::{Batch, ZERO_LANE, get, put};
use super::geometry::{Geometry, Radii};
use super::hertz::{gone_share, kept_force, lost_share};
use super::loss::Loss;
use super::resistance::Resistance;
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::{add_scaled, dot};
use crate::effect::{Effect, EffectKey, Family};

/// Twisting resistance, as an effect.
pub const EFFECT: Effect = Effect {
    name: "twisting resistance",
    family: Family::Contacts,
    equation: "M = R* F_t n; dF_t = −k_t v_t dt, v_t = R* (ω₁ − ω₂)·n; F_t and F_t − c_t v_t are cut \
               at μ_t F_n",
    source: "S. Luding: Granular Matter 10 (2008); Y. Wang et al.: Acta Geotechnica 10 (2015)",
    keys: &[
        EffectKey { key: "twisting_friction in [contacts]", unit: "", default: "none" },
        EffectKey { key: "twisting_stiffness_ratio in [contacts]", unit: "", default: "0.5" },
        EffectKey { key: "twisting_damping_ratio in [contacts]", unit: "", default: "0.3" },
    ],
    needs: "rotation",
    test: "dempfv/tests/dem_rolling.rs",
};

/// Velocity at which the two surfaces twist on the arm R* (m/s), and the dashpot's force (N).
#[inline(always)]
fn twist<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &Terms,
    p: &GranularParameters,
    resistance: &Resistance,
    l: usize,
) -> (f64, f64) {
    let radii = batch.geometry.radii(l);
    let spin = dot(batch.geometry.relative_spin(l), batch.geometry.normal(l));
    let velocity = radii.reduced(spin);
    let mass = radii.reduced_mass(p.densities);
    (velocity, -resistance.dashpot(terms.stiffness[l], mass) * velocity)
}

/// Spring and dashpot together, which stay within the limit.
#[inline(always)]
fn force(terms: &Terms, resistance: &Resistance, (spring, drag): (f64, f64), l: usize) -> f64 {
    let limit = resistance.friction * terms.grip[l];
    (spring + drag).max(-limit).min(limit)
}

/// The springs after the step, in `slot` of the history.
#[inline(always)]
pub(super) fn follow<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    resistance: &Resistance,
    slot: usize,
) {
    for l in batch.lanes() {
        let (velocity, _) = twist(batch, terms, &parameters(l), resistance, l);
        let way = velocity * batch.dt;
        let before = kept_force(terms.growth[l]) * batch.history[slot][l];
        let spring = before - resistance.spring(terms.stiffness[l]) * way;
        batch.history[slot][l] = force(terms, resistance, (spring, 0.0), l);
    }
}

/// What slider and dashpot dissipate in the step, before the springs follow it.
#[inline(always)]
pub(super) fn lose<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    resistance: &Resistance,
    slot: usize,
) {
    let mut lost = ZERO_LANE;
    for l in batch.lanes() {
        let (velocity, drag) = twist(batch, terms, &parameters(l), resistance, l);
        let (spring, way) = (resistance.spring(terms.stiffness[l]), velocity * batch.dt);
        let before = kept_force(terms.growth[l]) * batch.history[slot][l];
        let trial = before - spring * way;
        let now = force(terms, resistance, (trial, 0.0), l);
        let drag = force(terms, resistance, (now, drag), l) - now;
        let slid = (before + now) * (trial - now);
        let growth = terms.growth[l];
        let changed =
            lost_share(growth) * before * before - gone_share(growth) * before * spring * way;
        let lost_by_spring = if spring > 0.0 { 0.5 * (slid + changed) / spring } else { 0.0 };
        lost[l] = lost_by_spring - drag * way;
    }
    batch.book(Loss::Rolling, &lost);
}

/// The moments of spring and dashpot.
#[inline(always)]
pub(super) fn turn_back<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    resistance: &Resistance,
    slot: usize,
) {
    for l in batch.lanes() {
        let (_, drag) = twist(batch, terms, &parameters(l), resistance, l);
        let force = force(terms, resistance, (batch.history[slot][l], drag), l);
        let moment = batch.geometry.radii(l).reduced(force);
        let normal = batch.geometry.normal(l);
        let [first, second] = [get(&batch.torque[0], l), get(&batch.torque[1], l)];
        put(&mut batch.torque[0], l, add_scaled(first, moment, normal));
        put(&mut batch.torque[1], l, add_scaled(second, -moment, normal));
    }
}
