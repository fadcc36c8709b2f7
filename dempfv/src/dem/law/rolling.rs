//! Rolling resistance.

use super::batch::{Batch, get, put};
use super::geometry::{Geometry, Radii};
use super::resistance::Resistance;
use super::terms::{GranularParameters, Memory, Terms};
use super::turn::turn;
use super::vector::{Vector, add_scaled, cross, cut, scaled};
use crate::effect::{Effect, EffectKey, Family};

/// Rolling resistance, as an effect.
pub const EFFECT: Effect = Effect {
    name: "rolling resistance",
    family: Family::Contacts,
    equation: "M = R* n × F_r; dF_r = −k_r v_r dt, v_r = R* (ω₁ − ω₂) × n; F_r − c_r v_r is cut at μ_r F_n",
    source: "S. Luding: Granular Matter 10 (2008); Y. Wang et al.: Acta Geotechnica 10 (2015); the spring, dashpot and \
             slider of K. Iwashita, M. Oda: J. Eng. Mech. 124 (1998)",
    keys: &[
        EffectKey { key: "rolling_friction in [contacts]", unit: "", default: "none" },
        EffectKey { key: "rolling_stiffness_ratio in [contacts]", unit: "", default: "0.5" },
        EffectKey { key: "rolling_damping_ratio in [contacts]", unit: "", default: "0.3" },
    ],
    needs: "rotation",
    test: "cargo test -p dempfv --test dem_rolling",
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

/// The springs after the step, from `slot` of the history on.
#[inline(always)]
pub(super) fn follow<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    resistance: &Resistance,
    slot: usize,
) {
    for l in batch.lanes() {
        let motion = batch.geometry.sliding::<true>(l, batch.dt);
        let old = [0, 1, 2].map(|k| batch.history[slot + k][l]);
        let (turned, ratio) = turn(old, &motion);
        let way = scaled(batch.dt, rolling_velocity(batch, l));
        let spring = scaled(ratio.sqrt(), turned);
        let spring = add_scaled(spring, -resistance.spring(terms.stiffness[l]), way);
        let drag = drag(batch, terms, &parameters(l), resistance, l);
        let force = add_scaled(spring, 1.0, drag);
        let limit = resistance.friction * terms.grip[l];
        let spring = add_scaled(cut(force, limit), -1.0, drag);
        for k in 0..3 {
            batch.history[slot + k][l] = spring[k];
        }
    }
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
        let drag = drag(batch, terms, &parameters(l), resistance, l);
        let limit = resistance.friction * terms.grip[l];
        let force = cut(add_scaled(spring, 1.0, drag), limit);
        let arm = batch.geometry.radii(l).reduced(1.0);
        let moment = scaled(arm, cross(batch.geometry.normal(l), force));
        let [first, second] = [get(&batch.torque[0], l), get(&batch.torque[1], l)];
        put(&mut batch.torque[0], l, add_scaled(first, 1.0, moment));
        put(&mut batch.torque[1], l, add_scaled(second, -1.0, moment));
    }
}
