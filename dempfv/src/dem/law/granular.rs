//! The granular law: a contact put together from the effects that are asked for.

use super::adhesion::Adhesion;
use super::batch::{Batch, get, put};
use super::bonds::{self, Bond};
use super::contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
use super::effects::{GranularEffects, Slots};
use super::geometry::{Geometry, Radii, SphereOnPlane};
use super::hertz;
use super::jkr::{self, Jkr};
use super::resistance::Resistance;
use super::restitution;
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::{add_scaled, cross, scaled};
use super::{dmt, pull_off, rolling, shear, springs, twisting};
use crate::Vec3;
use crate::dem::error::DemError;
use crate::dem::material::{Material, WallMaterial};

/// A law whose batches go through a loop for each effect that is on; which these are is asked once
/// a batch. Friction and shear stiffness are those of the materials.
#[derive(Clone, Copy, Debug)]
pub struct Granular {
    effects: GranularEffects,
    /// Where each effect's numbers are in the history.
    slots: Slots,
    cut_off: f64,
}

/// A contact that does not move: stiffness (N/m), force and energy of its normal spring (N, J).
struct AtRest {
    stiffness: f64,
    force: f64,
    energy: f64,
}

impl Granular {
    /// The law with these effects.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a constant that makes no sense; [`DemError::Effects`] for effects
    /// that do not go together.
    pub fn new(effects: GranularEffects) -> Result<Granular, DemError> {
        effects.check()?;
        Ok(Granular { effects, slots: Slots::of(&effects), cut_off: 0.0 })
    }

    /// What it is put together from.
    pub fn effects(&self) -> &GranularEffects {
        &self.effects
    }

    /// Factor on the damping ratio of the tangent spring: see [`restitution::resist`].
    fn shape(&self) -> f64 {
        if self.effects.hertz.is_some() { (5.0f64 / 6.0).sqrt() } else { 1.0 }
    }

    /// The adhesive contact of the theory of Johnson, Kendall and Roberts, where it is on.
    #[inline(always)]
    fn jkr(&self, p: &GranularParameters, radii: impl Radii) -> Option<Jkr> {
        match self.effects.adhesion {
            Some(Adhesion::Jkr(work)) => Some(Jkr::new(p.modulus, work, radii)),
            _ => None,
        }
    }

    fn bond_of(&self, history: &Memory) -> Bond {
        match self.effects.bonds {
            Some(_) => Bond([history.0[self.slots.bond], history.0[self.slots.bond + 1]]),
            None => Bond([0.0; 2]),
        }
    }

    /// The normal stiffness (N/m) of two bodies that act on each other.
    #[inline(always)]
    fn normal_stiffness(&self, p: &GranularParameters, radii: impl Radii, overlap: f64) -> f64 {
        if let Some(contact) = self.jkr(p, radii) {
            let exists = overlap >= contact.least_overlap();
            if exists { 2.0 * p.modulus * contact.contact_radius(overlap) } else { 0.0 }
        } else if self.effects.hertz.is_some() {
            hertz::stiffness(p.modulus, radii.reduced(1.0), overlap)
        } else if p.bondable || overlap >= 0.0 {
            radii.reduced(p.modulus)
        } else {
            0.0
        }
    }

    fn at_rest(
        &self,
        p: &GranularParameters,
        radii: impl Radii,
        overlap: f64,
        history: &Memory,
    ) -> AtRest {
        if !self.acts(overlap, history) {
            return AtRest { stiffness: 0.0, force: 0.0, energy: 0.0 };
        }
        let stiffness = self.normal_stiffness(p, radii, overlap);
        if let Some(contact) = self.jkr(p, radii) {
            let [push, pull] = contact.forces(overlap);
            return AtRest { stiffness, force: push - pull, energy: contact.energy(overlap) };
        }
        let (push, share) = if self.effects.hertz.is_some() {
            (2.0 / 3.0 * stiffness * overlap, 0.4)
        } else {
            (stiffness * self.bond_of(history).compression(overlap), 0.5)
        };
        let compression = self.bond_of(history).compression(overlap);
        let pull = match self.effects.adhesion {
            Some(Adhesion::Constant(force)) => force,
            Some(Adhesion::Dmt(work)) => dmt::pull_off(work, radii),
            Some(Adhesion::Jkr(_)) | None => 0.0,
        };
        let energy = share * push * compression - pull * overlap;
        AtRest { stiffness, force: push - pull, energy }
    }

    /// Energy of the springs against rolling and twisting (J).
    fn turning_energy(&self, stiffness: f64, history: &Memory) -> f64 {
        let energy = |resistance: Option<Resistance>, numbers: &[f64]| {
            let force2: f64 = numbers.iter().map(|x| x * x).sum();
            match resistance {
                Some(resistance) if force2 > 0.0 && stiffness > 0.0 => {
                    0.5 * force2 / resistance.spring(stiffness)
                }
                _ => 0.0,
            }
        };
        let Slots { rolling, twisting, .. } = self.slots;
        energy(self.effects.rolling, &history.0[rolling..rolling + 3])
            + energy(self.effects.twisting, &history.0[twisting..=twisting])
    }
}

fn parameters(
    (modulus, shear_ratio): (f64, f64),
    angles: [f64; 2],
    densities: [f64; 2],
    restitution: Option<f64>,
    bondable: bool,
) -> GranularParameters {
    GranularParameters {
        modulus,
        shear_ratio,
        friction: angles[0].min(angles[1]).tan(),
        densities,
        damping_ratio: restitution.map_or(0.0, restitution::damping_ratio),
        bondable,
    }
}

impl ContactLaw for Granular {
    type History = Memory;
    type Parameters = GranularParameters;
    type Scratch = Terms;
    const GENERAL_KERNELS: bool = true;

    fn name(&self) -> &'static str {
        self.effects.name()
    }

    #[inline(always)]
    fn history_length(&self) -> usize {
        self.slots.length
    }

    fn between_spheres(&self, first: &Material, second: &Material) -> GranularParameters {
        let stiffness = match self.effects.hertz {
            Some(hertz) => hertz.between_spheres(first, second),
            None => springs::between_spheres(first, second),
        };
        let angles = [first.friction_angle, second.friction_angle];
        let restitution = self.effects.restitution.map(|r| r.spheres);
        let densities = [first.density, second.density];
        parameters(stiffness, angles, densities, restitution, self.effects.bonds.is_some())
    }

    fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> GranularParameters {
        let stiffness = match self.effects.hertz {
            Some(hertz) => hertz.on_wall(sphere, wall),
            None => springs::on_wall(sphere, wall),
        };
        let angles = [sphere.friction_angle, wall.friction_angle];
        let restitution = self.effects.restitution.map(|r| r.walls);
        parameters(stiffness, angles, [sphere.density; 2], restitution, false)
    }

    fn needs(&self, parameters: &GranularParameters) -> Needs {
        let GranularEffects { rolling, twisting, adhesion, bonds, .. } = self.effects;
        if parameters.friction > 0.0 || rolling.is_some() || twisting.is_some() || bonds.is_some() {
            Needs::Torques
        } else if parameters.damping_ratio > 0.0 || matches!(adhesion, Some(Adhesion::Jkr(_))) {
            Needs::Motion
        } else {
            Needs::Overlap
        }
    }

    fn cut_off(&self) -> f64 {
        self.cut_off
    }

    fn fit_cut_off<'p>(
        &mut self,
        parameters: impl Iterator<Item = &'p GranularParameters>,
        largest_radius: f64,
    ) {
        let (jkr, bonds) = (self.jkr_work(), self.effects.bonds);
        let reach = |p: &GranularParameters| {
            // The reach grows with the reduced radius, which is largest on a wall.
            let radii = SphereOnPlane(REACH_MARGIN * largest_radius);
            let adhesive = jkr.map_or(0.0, |w| -Jkr::new(p.modulus, w, radii).least_overlap());
            let bonds = bonds.filter(|_| p.bondable);
            adhesive.max(bonds.map_or(0.0, |b| b.reach(p.modulus, largest_radius)))
        };
        self.cut_off = parameters.map(reach).fold(0.0, f64::max);
    }

    fn acts(&self, overlap: f64, history: &Memory) -> bool {
        match (self.jkr_work(), self.effects.bonds) {
            (Some(_), _) => history.0[self.slots.contact] > 0.0,
            (None, Some(_)) => self.bond_of(history).acts(overlap),
            (None, None) => true,
        }
    }

    fn stiffens(&self) -> bool {
        self.effects.hertz.is_some()
    }

    fn expected_overlap(
        &self,
        parameters: &GranularParameters,
        radii: impl Radii,
        energy: f64,
        usual: f64,
    ) -> f64 {
        match self.effects.hertz {
            Some(_) => {
                let radius = radii.reduced(1.0);
                usual.max(hertz::overlap_of_energy(parameters.modulus, radius, energy))
            }
            None => usual,
        }
    }

    #[inline(always)]
    fn stiffness(&self, p: &GranularParameters, radii: impl Radii, overlap: f64) -> Stiffness {
        let normal = self.normal_stiffness(p, radii, overlap);
        let slides = p.friction > 0.0 || p.bondable;
        let mut result =
            Stiffness { normal, shear: if slides { p.shear_ratio * normal } else { 0.0 } };
        if p.damping_ratio > 0.0 {
            let ratio = self.shape() * p.damping_ratio;
            result.normal *= restitution::stiffening(ratio);
            // What slides has 2/7 of the mass of what approaches, where spheres turn.
            result.shear *= restitution::stiffening(3.5f64.sqrt() * ratio);
        }
        if let Some(rolling) = self.effects.rolling {
            result.shear += rolling.shear_ratio() * normal;
        }
        if let Some(twisting) = self.effects.twisting {
            // About the normal, where a shear stiffness turns nothing: it counts against the mass,
            // of which I / r² is 0.4.
            result.shear += 2.5 * twisting.shear_ratio() * normal;
        }
        result
    }

    #[inline(always)]
    fn dashpot(&self, p: &GranularParameters, radii: impl Radii, overlap: f64) -> f64 {
        if p.damping_ratio == 0.0 {
            return 0.0;
        }
        let stiffness = self.normal_stiffness(p, radii, overlap);
        let mass = radii.reduced_mass(p.densities);
        2.0 * self.shape() * p.damping_ratio * (mass * stiffness).sqrt()
    }

    fn force(
        &self,
        p: &GranularParameters,
        radii: impl Radii,
        overlap: f64,
        history: &Memory,
    ) -> ContactForce {
        let [x, y, z] = [0, 1, 2].map(|k| history.0[k]);
        let normal = self.at_rest(p, radii, overlap, history).force;
        ContactForce { normal, shear: Vec3::new(x, y, z) }
    }

    /// Of the normal spring, that of adhesion counted against it; F² / 2k of the others.
    fn elastic_energy(
        &self,
        p: &GranularParameters,
        radii: impl Radii,
        overlap: f64,
        history: &Memory,
    ) -> f64 {
        let AtRest { stiffness, energy, .. } = self.at_rest(p, radii, overlap, history);
        let shear: f64 = history.0[..3].iter().map(|x| x * x).sum();
        // What no longer touches holds nothing.
        let held = shear > 0.0 && stiffness > 0.0;
        let sheared = if held { 0.5 * shear / (p.shear_ratio * stiffness) } else { 0.0 };
        energy + sheared + self.turning_energy(stiffness, history)
    }

    fn viscous_force(&self, history: &Memory) -> Vec3 {
        match self.effects.restitution {
            Some(_) => Vec3::from_column_slice(&history.0[self.slots.viscous..][..3]),
            None => Vec3::zeros(),
        }
    }

    /// Rolling and twisting are the same seen from either body.
    fn reversed(&self, mut history: Memory) -> Memory {
        history.0[..3].iter_mut().for_each(|x| *x = -*x);
        if self.effects.restitution.is_some() {
            history.0[self.slots.viscous..][..3].iter_mut().for_each(|x| *x = -*x);
        }
        history
    }

    fn bond(&self, overlap: f64, radii: [f64; 2], history: &mut [f64]) -> bool {
        let Some(bonds) = self.effects.bonds else { return false };
        if !bonds.joins(overlap, radii) {
            return false;
        }
        let Bond(made) = Bond::made(overlap);
        history[self.slots.bond..][..2].copy_from_slice(&made);
        true
    }

    fn is_bonded(&self, history: &Memory) -> bool {
        self.bond_of(history).intact()
    }

    #[inline(always)]
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &mut Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        self.press::<G, MOTION>(batch, terms, parameters);
        if MOTION && self.effects.restitution.is_some() {
            restitution::resist(batch, terms, parameters, self.shape());
            restitution::join(batch, terms);
            restitution::drag::<G, TORQUES>(batch, terms, parameters);
        }
        match (self.effects.bonds, self.effects.adhesion) {
            (Some(_), _) if MOTION => bonds::grip(batch, terms, parameters),
            (None, Some(Adhesion::Jkr(_))) => jkr::grip(batch, terms),
            _ => terms.grip = terms.push,
        }
        if MOTION && batch.dt != 0.0 {
            if self.effects.hertz.is_some() && self.jkr_work().is_none() {
                hertz::grow(batch, terms);
            }
            if TORQUES && batch.tracks_energy {
                self.lose_by_turning(batch, terms, parameters);
            }
            self.follow::<G, TORQUES>(batch, terms, parameters);
        }
        if MOTION && self.effects.restitution.is_some() {
            shear::limit_drag(batch, terms, parameters);
        }
        if MOTION && batch.dt != 0.0 && batch.tracks_energy {
            self.lose::<G, TORQUES>(batch, terms, parameters);
        }
        if MOTION && batch.tracks_energy && self.effects.restitution.is_some() {
            restitution::keep(batch, terms, self.slots.viscous);
        }
        sum::<G, MOTION, TORQUES>(batch, terms);
        if TORQUES && let Some(rolling) = &self.effects.rolling {
            rolling::turn_back(batch, terms, parameters, rolling, self.slots.rolling);
        }
        if TORQUES && let Some(twisting) = &self.effects.twisting {
            twisting::turn_back(batch, terms, parameters, twisting, self.slots.twisting);
        }
    }
}

/// Share by which radii may grow before the cut-off is taken again.
const REACH_MARGIN: f64 = 1.2;

impl Granular {
    fn jkr_work(&self) -> Option<f64> {
        match self.effects.adhesion {
            Some(Adhesion::Jkr(work)) => Some(work),
            _ => None,
        }
    }

    /// The normal springs and what pulls.
    #[inline(always)]
    fn press<G: Geometry, const MOTION: bool>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &mut Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        match (self.effects.adhesion, &self.effects.bonds) {
            (Some(Adhesion::Jkr(work)), _) if MOTION => {
                jkr::press(batch, terms, parameters, work, self.slots.contact);
            }
            (_, Some(bonds)) if MOTION => {
                bonds::remember(batch, terms, self.slots.bond);
                bonds::hold(batch, terms, parameters, bonds, self.slots.bond);
            }
            _ if self.effects.hertz.is_some() => hertz::press(batch, terms, parameters),
            _ => springs::press(batch, terms, parameters),
        }
        match self.effects.adhesion {
            Some(Adhesion::Constant(force)) => pull_off::pull(batch, terms, force),
            Some(Adhesion::Dmt(work)) => dmt::pull(batch, terms, work),
            Some(Adhesion::Jkr(_)) | None => {}
        }
    }

    /// Takes the histories through the step.
    #[inline(always)]
    fn follow<G: Geometry, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &mut Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        shear::follow::<G, TORQUES>(batch, terms, parameters);
        if self.effects.hertz.is_some() {
            shear::shrink(batch, terms);
        }
        if self.effects.bonds.is_some() {
            bonds::shear_off(batch, terms, parameters, self.slots.bond);
        }
        shear::slide(batch, terms, parameters);
        if TORQUES && let Some(rolling) = &self.effects.rolling {
            rolling::follow(batch, terms, rolling, self.slots.rolling);
        }
        if TORQUES && let Some(twisting) = &self.effects.twisting {
            twisting::follow(batch, terms, parameters, twisting, self.slots.twisting);
        }
    }
}

impl Granular {
    /// Books what has been dissipated but by rolling and twisting.
    #[inline(always)]
    fn lose<G: Geometry, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        shear::lose(batch, terms, parameters, self.effects.hertz.is_some());
        if self.effects.restitution.is_some() {
            restitution::lose::<G, TORQUES>(batch, terms, self.slots.viscous);
        }
        if let Some(work) = self.jkr_work() {
            jkr::lose::<G, TORQUES>(batch, terms, parameters, work, self.slots.contact);
        }
        if self.effects.bonds.is_some() {
            bonds::lose::<G, TORQUES>(batch, terms, parameters, self.slots.bond);
        }
    }

    /// Books what rolling and twisting dissipate in the step that is to be followed.
    #[inline(always)]
    fn lose_by_turning<G: Geometry>(
        &self,
        batch: &mut Batch<G, Memory>,
        terms: &Terms,
        parameters: impl Fn(usize) -> GranularParameters + Copy,
    ) {
        if let Some(rolling) = &self.effects.rolling {
            rolling::lose(batch, terms, parameters, rolling, self.slots.rolling);
        }
        if let Some(twisting) = &self.effects.twisting {
            twisting::lose(batch, terms, parameters, twisting, self.slots.twisting);
        }
    }
}

/// Forces and torques.
#[inline(always)]
fn sum<G: Geometry, const MOTION: bool, const TORQUES: bool>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
) {
    for l in batch.lanes() {
        let normal = batch.geometry.normal(l);
        let mut force = scaled(terms.push[l] - terms.pull[l], normal);
        if MOTION {
            let spring = [0, 1, 2].map(|k| batch.history[k][l]);
            let shear = add_scaled(spring, 1.0, get(&terms.drag, l));
            force = add_scaled(force, 1.0, shear);
            if TORQUES {
                let moment = cross(normal, shear);
                let [first, second] = batch.geometry.arms(l);
                put(&mut batch.torque[0], l, scaled(-first, moment));
                put(&mut batch.torque[1], l, scaled(-second, moment));
            }
        }
        put(&mut batch.force, l, force);
    }
}
