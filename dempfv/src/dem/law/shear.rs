//! The shear force of the granular law: a spring that follows the contact, with Coulomb's limit.

use super::batch::{Batch, ZERO_LANE, get, put};
use super::geometry::Geometry;
use super::hertz::{gone_share, lost_share};
use super::loss::Loss;
use super::terms::{GranularParameters, Memory, Terms};
use super::turn::turn;
use super::vector::{add_scaled, cut, dot, scaled};

/// Turns the shear forces with the contacts and finds what slip takes.
#[inline(always)]
pub(super) fn follow<G: Geometry, const TORQUES: bool>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let motion = batch.geometry.sliding::<TORQUES>(l, batch.dt);
        let [x, y, z] = [0, 1, 2].map(|k| batch.history[k][l]);
        let (turned, ratio) = turn([x, y, z], &motion);
        put(&mut terms.turned, l, turned);
        terms.ratio[l] = ratio;
        put(
            &mut terms.loss,
            l,
            scaled(parameters(l).shear_ratio * terms.stiffness[l], motion.slip),
        );
    }
}

/// Makes the shear forces of contacts smaller whose radius has shrunk: the springs that no longer
/// touch take their share with them. Without it unloading would leave more energy than there was.
#[inline(always)]
pub(super) fn shrink<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms) {
    for l in batch.lanes() {
        terms.ratio[l] *= (terms.growth[l] * terms.growth[l]).min(1.0);
    }
}

/// The shear forces of the springs after the step, cut at the limit.
#[inline(always)]
pub(super) fn slide<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let limit = terms.strength[l] + parameters(l).friction * terms.grip[l];
        let s = scaled(terms.ratio[l].sqrt(), get(&terms.turned, l));
        let s = cut(add_scaled(s, -1.0, get(&terms.loss, l)), limit);
        for (lane, x) in batch.history.iter_mut().zip(s) {
            lane[l] = x;
        }
    }
}

/// What the dashpots may add to the springs: both together stay within the limit.
#[inline(always)]
pub(super) fn limit_drag<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let limit = terms.strength[l] + parameters(l).friction * terms.grip[l];
        let spring = [0, 1, 2].map(|k| batch.history[k][l]);
        let both = cut(add_scaled(spring, 1.0, get(&terms.drag, l)), limit);
        put(&mut terms.drag, l, add_scaled(both, -1.0, spring));
    }
}

/// What slip has dissipated, as in the linear law; with Hertz's contact also what a spring loses
/// whose stiffness changes: where it grows, the force stays, where it shrinks, the force shrinks
/// with it.
#[inline(always)]
pub(super) fn lose<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    hertz: bool,
) {
    let mut lost = ZERO_LANE;
    for l in batch.lanes() {
        let before = scaled(terms.ratio[l].sqrt(), get(&terms.turned, l));
        let trial = add_scaled(before, -1.0, get(&terms.loss, l));
        let now = [0, 1, 2].map(|k| batch.history[k][l]);
        let slid = dot(add_scaled(before, 1.0, now), add_scaled(trial, -1.0, now));
        let growth = if hertz { terms.growth[l] } else { 0.0 };
        let changed = lost_share(growth) * dot(before, before)
            - gone_share(growth) * dot(before, get(&terms.loss, l));
        let stiffness = parameters(l).shear_ratio * terms.stiffness[l];
        lost[l] = if stiffness > 0.0 { 0.5 * (slid + changed) / stiffness } else { 0.0 };
    }
    batch.book(Loss::Friction, &lost);
}
