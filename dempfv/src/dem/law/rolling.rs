//! Rolling resistance.

use super::batch::{Batch, ZERO_LANE, get, put};
use super::geometry::{Geometry, Radii};
use super::hertz::{gone_share, kept_force, lost_share};
use super::loss::Loss;
use super::resistance::Resistance;
use super::terms::{GranularParameters, Memory, Terms};
use super::turn::turn;
use super::vector::{Vector, add_scaled, cross, cut, dot, scaled};
use crate::effect::{Effect, EffectKey, Family};

/// Rolling resistance, as an effect.
pub const EFFECT: Effect = Effect {
    name: "rolling resistance",
    family: Family::Contacts,
    equation: "M = R* n × F_r; dF_r = −k_r v_r dt, v_r = R* (ω₁ − ω₂) × n; F_r and F_r − c_r v_r are \
               cut at μ_r F_n",
    source: "S. Luding: Granular Matter 10 (2008); Y. Wang et al.: Acta Geotechnica 10 (2015); the spring, \
             dashpot and slider of K. Iwashita, M. Oda: J. Eng. Mech. 124 (1998)",
    keys: &[
        EffectKey { key: "rolling_friction in [contacts]", unit: "", default: "none" },
        EffectKey { key: "rolling_stiffness_ratio in [contacts]", unit: "", default: "0.5" },
        EffectKey { key: "rolling_damping_ratio in [contacts]", unit: "", default: "0.3" },
    ],
    needs: "rotation",
    test: "dempfv/tests/dem_rolling.rs",
};

/// Velocity at which the two surfaces roll over each other (m/s): R* (ω₁ − ω₂) × n.
#[inline(always)]
fn rolling_velocity<G: Geometry>(batch: &Batch<G, Memory>, l: usize) -> Vector {
    let radius = batch.geometry.radii(l).reduced(1.0);
    scaled(radius, cross(batch.geometry.relative_spin(l), batch.geometry.normal(l)))
}

/// The dashpot's force (N).
#[inline(always)]
fn drag<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &Terms,
    p: &GranularParameters,
    resistance: &Resistance,
    l: usize,
) -> Vector {
    let mass = batch.geometry.radii(l).reduced_mass(p.densities);
    scaled(-resistance.dashpot(terms.stiffness[l], mass), rolling_velocity(batch, l))
}

/// A spring before the step, as it would be without a limit, and after.
struct Step {
    before: Vector,
    trial: Vector,
    now: Vector,
}

#[inline(always)]
fn step<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &Terms,
    (resistance, slot): (&Resistance, usize),
    l: usize,
) -> Step {
    let motion = batch.geometry.sliding::<true>(l, batch.dt);
    let (turned, ratio) = turn([0, 1, 2].map(|k| batch.history[slot + k][l]), &motion);
    let before = scaled(ratio.sqrt() * kept_force(terms.growth[l]), turned);
    let way = scaled(batch.dt, rolling_velocity(batch, l));
    let trial = add_scaled(before, -resistance.spring(terms.stiffness[l]), way);
    Step { before, trial, now: cut(trial, resistance.friction * terms.grip[l]) }
}

/// Spring and dashpot together, which stay within the limit.
#[inline(always)]
fn force<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &Terms,
    p: &GranularParameters,
    (resistance, spring): (&Resistance, Vector),
    l: usize,
) -> Vector {
    let drag = drag(batch, terms, p, resistance, l);
    cut(add_scaled(spring, 1.0, drag), resistance.friction * terms.grip[l])
}

/// The springs after the step, from `slot` of the history on.
#[inline(always)]
pub(super) fn follow<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    resistance: &Resistance,
    slot: usize,
) {
    for l in batch.lanes() {
        let Step { now, .. } = step(batch, terms, (resistance, slot), l);
        for (lane, x) in batch.history[slot..].iter_mut().zip(now) {
            lane[l] = x;
        }
    }
}

/// What slider and dashpot dissipate in the step, before the springs follow it: as friction does.
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
        let Step { before, trial, now } = step(batch, terms, (resistance, slot), l);
        let force = force(batch, terms, &parameters(l), (resistance, now), l);
        let drag = add_scaled(force, -1.0, now);
        let slid = dot(add_scaled(before, 1.0, now), add_scaled(trial, -1.0, now));
        let changed = lost_share(terms.growth[l]) * dot(before, before)
            - gone_share(terms.growth[l]) * dot(before, add_scaled(before, -1.0, trial));
        let spring = resistance.spring(terms.stiffness[l]);
        let lost_by_spring = if spring > 0.0 { 0.5 * (slid + changed) / spring } else { 0.0 };
        lost[l] = lost_by_spring - batch.dt * dot(drag, rolling_velocity(batch, l));
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
        let spring = [0, 1, 2].map(|k| batch.history[slot + k][l]);
        let force = force(batch, terms, &parameters(l), (resistance, spring), l);
        let arm = batch.geometry.radii(l).reduced(1.0);
        let moment = scaled(arm, cross(batch.geometry.normal(l), force));
        let [first, second] = [get(&batch.torque[0], l), get(&batch.torque[1], l)];
        put(&mut batch.torque[0], l, add_scaled(first, 1.0, moment));
        put(&mut batch.torque[1], l, add_scaled(second, -1.0, moment));
    }
}
