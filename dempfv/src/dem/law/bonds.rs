//! Brittle bonds between spheres.

use std::f64::consts::PI;

use serde::Serialize;

use super::batch::{Batch, ZERO_LANE, get, put};
use super::geometry::{Geometry, Radii};
use super::loss::Loss;
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::{add_scaled, dot, scaled};
use crate::dem::error::DemError;
use crate::effect::{Effect, EffectKey, Family};

/// Brittle bonds, as an effect.
pub const EFFECT: Effect = Effect {
    name: "brittle bonds",
    family: Family::Contacts,
    equation: "F_n = k_n (δ − δ_0) ≥ −σ_t A, |F_s| ≤ c A + F_n tan φ, A = π min(r₁, r₂)²; beyond, the bond is \
               broken for ever and friction is left, without force at an overlap of max(δ_0, 0)",
    source: "L. Scholtès, F.-V. Donzé: J. Mech. Phys. Solids 61 (2013); D. O. Potyondy, P. A. Cundall: Int. J. \
             Rock Mech. Min. Sci. 41 (2004)",
    keys: &[
        EffectKey { key: "tension in [bonds]", unit: "Pa", default: "required" },
        EffectKey { key: "cohesion in [bonds]", unit: "Pa", default: "required" },
        EffectKey { key: "interaction_range in [bonds]", unit: "", default: "1.0" },
        EffectKey { key: "from in [bonds]", unit: "", default: "the first stage" },
    ],
    needs: "",
    test: "dempfv/tests/dem_bonds.rs",
};

/// Strength of the bonds that [`Dem::bond`](crate::dem::Dem::bond) makes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bonds {
    /// Tensile strength σ_t (Pa).
    pub tension: f64,
    /// Shear strength c without normal force (Pa).
    pub cohesion: f64,
    /// Distance of the centres over the sum of the radii up to which two spheres are bonded.
    pub interaction_range: f64,
}

/// States of a bond in the history, of which 0 is that there never was one.
const INTACT: f64 = 1.0;
const BROKEN: f64 = 2.0;

/// Share by which radii may grow before the cut-off is taken again, and a bond beyond its strength
/// before it is looked at.
const MARGIN: f64 = 1.1;

impl Bonds {
    pub(super) fn check(&self) -> Result<(), DemError> {
        let named = [("bond tension", self.tension), ("bond cohesion", self.cohesion)];
        for (name, value) in named {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DemError::Parameter { name, value, expected: "zero or positive" });
            }
        }
        if !(1.0..=2.0).contains(&self.interaction_range) {
            let (name, value) = ("interaction_range", self.interaction_range);
            return Err(DemError::Parameter { name, value, expected: "from 1 to 2" });
        }
        Ok(())
    }

    /// Gap (m) up to which a bond of spheres up to this radius (m) can hold, for the least k_n over
    /// the reduced radius (Pa): that at which it was made, and σ_t A / k_n.
    pub(super) fn reach(&self, modulus: f64, largest_radius: f64) -> f64 {
        let stretch = PI * self.tension / modulus;
        2.0 * largest_radius * MARGIN * (self.interaction_range - 1.0 + MARGIN * stretch)
    }

    /// Whether two spheres with this overlap (m) are near enough.
    pub(super) fn joins(&self, overlap: f64, radii: [f64; 2]) -> bool {
        overlap >= -(self.interaction_range - 1.0) * (radii[0] + radii[1])
    }
}

/// A bond as the history has it: its state, and the overlap without force (m).
#[derive(Clone, Copy)]
pub(super) struct Bond(pub [f64; 2]);

impl Bond {
    pub(super) fn made(overlap: f64) -> Bond {
        Bond([INTACT, overlap])
    }

    #[inline(always)]
    pub(super) fn intact(self) -> bool {
        self.0[0] == INTACT
    }

    #[inline(always)]
    fn broken(self) -> Bond {
        Bond([BROKEN, self.0[1].max(0.0)])
    }

    /// How far the two spheres are pressed (m): negative only where a bond holds them.
    #[inline(always)]
    pub(super) fn compression(self, overlap: f64) -> f64 {
        let compression = overlap - self.0[1];
        if self.intact() { compression } else { compression.max(0.0) }
    }

    pub(super) fn acts(self, overlap: f64) -> bool {
        self.intact() || overlap > self.0[1]
    }
}

#[inline(always)]
fn load<G>(batch: &Batch<G, Memory>, slot: usize, l: usize) -> Bond {
    Bond([batch.history[slot][l], batch.history[slot + 1][l]])
}

#[inline(always)]
fn store<G>(batch: &mut Batch<G, Memory>, slot: usize, l: usize, Bond([state, rest]): Bond) {
    batch.history[slot][l] = state;
    batch.history[slot + 1][l] = rest;
}

/// Breaks bonds that are pulled too far, and sets the normal forces of the batch; from `slot` of
/// the history on are state and length of the bonds.
#[inline(always)]
pub(super) fn hold<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    bonds: &Bonds,
    slot: usize,
) {
    for l in batch.lanes() {
        let radii = batch.geometry.radii(l);
        let (stiffness, overlap) =
            (radii.reduced(parameters(l).modulus), batch.geometry.overlap(l));
        let area = PI * radii.smaller() * radii.smaller();
        let bond = load(batch, slot, l);
        let torn = stiffness * (overlap - bond.0[1]) < -bonds.tension * area;
        let bond = if bond.intact() && torn { bond.broken() } else { bond };
        let compression = bond.compression(overlap);
        let acts = bond.intact() || compression > 0.0;
        terms.push[l] = stiffness * compression;
        terms.stiffness[l] = if acts { stiffness } else { 0.0 };
        terms.floor[l] = if bond.intact() { f64::NEG_INFINITY } else { 0.0 };
        terms.strength[l] = if bond.intact() { bonds.cohesion * area } else { 0.0 };
        store(batch, slot, l, bond);
    }
}

/// Keeps what the bonds are before the step, for [`lose`].
#[inline(always)]
pub(super) fn remember<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms, slot: usize) {
    terms.before = [batch.history[slot], batch.history[slot + 1]];
}

/// What springs lose that break, or that begin or cease to act within the step: what they held, less
/// the work of the mean of their forces before and after. Friction has the shear of a pair that parts.
#[inline(always)]
pub(super) fn lose<G: Geometry, const TORQUES: bool>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    slot: usize,
) {
    let (mut torn, mut parted, mut slipped) = (ZERO_LANE, ZERO_LANE, ZERO_LANE);
    for l in batch.lanes() {
        let stiffness = batch.geometry.radii(l).reduced(parameters(l).modulus);
        let (bond, now) = (Bond([terms.before[0][l], terms.before[1][l]]), load(batch, slot, l));
        let (from, to) = (batch.geometry.overlap_before(l, batch.dt), batch.geometry.overlap(l));
        let (first, second) = (bond.compression(from), now.compression(to));
        let held = 0.5 * stiffness * (first * first - second * second);
        let pressed = held - 0.5 * stiffness * (first + second) * (from - to);
        let followed = scaled(terms.ratio[l].sqrt(), get(&terms.turned, l));
        let slip = batch.geometry.sliding::<TORQUES>(l, batch.dt).slip;
        let shear_stiffness = parameters(l).shear_ratio * stiffness;
        // A spring that still acts has been asked by friction.
        let sheared = if terms.stiffness[l] == 0.0 && shear_stiffness > 0.0 {
            0.5 * (dot(followed, followed) / shear_stiffness - dot(followed, slip))
        } else {
            0.0
        };
        if bond.intact() && !now.intact() {
            torn[l] = pressed + sheared;
        } else {
            (parted[l], slipped[l]) = (pressed, sheared);
        }
    }
    batch.book(Loss::Breakage, &torn);
    batch.book(Loss::TouchChange, &parted);
    batch.book(Loss::Friction, &slipped);
}

/// What friction goes with: not with tension, which takes from the strength.
#[inline(always)]
pub(super) fn grip<G: Geometry>(
    batch: &Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
) {
    for l in batch.lanes() {
        let push = terms.push[l];
        terms.grip[l] = push.max(0.0);
        terms.strength[l] = (terms.strength[l] + parameters(l).friction * push.min(0.0)).max(0.0);
    }
}

/// Breaks bonds that are sheared too far: what they held in tension is gone, and friction is left
/// of the shear force.
#[inline(always)]
pub(super) fn shear_off<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    slot: usize,
) {
    for l in batch.lanes() {
        let bond = load(batch, slot, l);
        let spring = scaled(terms.ratio[l].sqrt(), get(&terms.turned, l));
        let spring = add_scaled(spring, -1.0, get(&terms.loss, l));
        let limit = terms.strength[l] + parameters(l).friction * terms.grip[l];
        let shorn = bond.intact() && dot(spring, spring) > limit * limit;
        if shorn {
            let bond = bond.broken();
            let compression = bond.compression(batch.geometry.overlap(l));
            let elastic = terms.stiffness[l] * compression;
            if compression > 0.0 {
                terms.push[l] = (elastic + terms.viscous[l]).max(0.0);
            } else {
                // Nothing acts: as for a pair that does not touch.
                terms.push[l] = 0.0;
                put(&mut terms.drag, l, [0.0; 3]);
            }
            terms.damped[l] = terms.push[l] - elastic;
            terms.grip[l] = terms.push[l];
            terms.strength[l] = 0.0;
            store(batch, slot, l, bond);
        }
    }
}
