//! What energy a step loses in which two bodies begin or cease to touch.

use super::contact_step::ContactStep;
use super::law::{ContactLaw, History, Loss, Losses, Radii};
use crate::Vec3;

/// A contact that begins or ends in a step.
pub(super) struct TouchChange<'a, R> {
    pub radii: R,
    pub step: ContactStep,
    pub history: &'a [f64],
}

impl<R: Radii> TouchChange<'_, R> {
    /// Books what the step takes from the motion or adds to it.
    ///
    /// A force F(δ₀) acts over half the way of the steps before and after, ½ (δ₁ − δ₋₁). Of a
    /// contact that has just begun the part from δ₋₁ < 0 to 0 is spent on nothing; one that ends
    /// goes on pushing to δ₁ < 0. Shear that is left at the end, after half the slip of the step,
    /// is lost to friction. Dashpots act over half the last way. Laws that act
    /// across a gap book what their springs lose themselves.
    pub fn book<L: ContactLaw>(&self, law: &L, parameters: &L::Parameters, losses: &mut Losses) {
        let TouchChange { radii, ref step, history } = *self;
        let (now, before) = (step.now.overlap, step.before.overlap);
        let slip = step.slip(&step.before);
        let history = L::History::read(history);
        losses.add(Loss::ContactDamping, -0.5 * law.viscous_force(&history).dot(&slip));
        let force = |overlap| law.force(parameters, radii, overlap, &history);
        if law.cut_off() > 0.0 {
            return;
        }
        if now > before {
            losses.add(Loss::TouchChange, -0.5 * force(now).normal * before.min(0.0));
        } else {
            let last = force(before);
            losses.add(Loss::TouchChange, 0.5 * last.normal * now.min(0.0));
            losses.add(Loss::Turning, step.lost_by_turning([last.normal, 0.0]));
            let left = law.elastic_energy(parameters, radii, 0.0, &history);
            losses.add(Loss::Friction, left - 0.5 * last.shear.dot(&slip));
        }
    }
}

/// Slip (m) of the second body of a contact with this unit `normal` in a step of `dt` in which it
/// moves at `velocity` relative to the first; `rim` is the sum of their arms times spins (m/s).
pub(super) fn slip(dt: f64, velocity: &Vec3, rim: &Vec3, normal: &Vec3) -> Vec3 {
    dt * (velocity - rim.cross(normal))
}
