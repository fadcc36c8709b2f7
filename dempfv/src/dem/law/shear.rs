//! The shear force of the granular law: a spring that follows the contact, with Coulomb's limit.

use super::batch::{Batch, get, put};
use super::geometry::Geometry;
use super::terms::{GranularParameters, Memory, Terms};
use super::turn::turn;
use super::vector::{add_scaled, cut, scaled};

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
        terms.ratio[l] *= terms.shrinkage[l];
    }
}

/// The shear forces after the step: spring and dashpot together are cut at the limit, and the
/// spring keeps what the dashpot does not take.
#[inline(always)]
pub(super) fn slide<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let limit = terms.strength[l] + parameters(l).friction * terms.grip[l];
        let drag = get(&terms.drag, l);
        let s = scaled(terms.ratio[l].sqrt(), get(&terms.turned, l));
        let s = add_scaled(add_scaled(s, -1.0, get(&terms.loss, l)), 1.0, drag);
        let s = add_scaled(cut(s, limit), -1.0, drag);
        for k in 0..3 {
            batch.history[k][l] = s[k];
        }
    }
}

/// What the dashpots may add to the springs: both together stay within the limit, also where the
/// springs have not followed the velocities of the moment.
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
