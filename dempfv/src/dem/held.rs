//! Spheres that do not move on their own: members of clumps, and those whose motion is given.

use super::clump::Clump;
use super::clumps::Clumps;
use super::integrate::{Loads, Step};
use super::ledger::MotionWork;
use super::motion::{Driven, Motions, Stroke, drive};
use super::particles::Particles;

/// All that is held. Takes no memory and costs nothing where nothing is.
#[derive(Debug, Default)]
pub(super) struct Held {
    pub motions: Motions,
    pub clumps: Clumps,
    /// Whether each sphere is held, by place in storage; empty where none is.
    mask: Vec<bool>,
    /// The single spheres with a motion.
    driven: Vec<Driven>,
    /// What each motion does in the step.
    strokes: Vec<Stroke>,
}

impl Held {
    /// `place` leads from the user's numbers to storage.
    pub fn new(motions: Motions, clumps: Vec<Clump>, place: &[u32]) -> Held {
        let clumps = Clumps::new(clumps, place, |number| motions.of(number));
        let mut held = Held { motions, clumps, ..Held::default() };
        if held.motions.is_empty() && held.clumps.is_empty() {
            return held;
        }
        held.mask = (0..place.len()).map(|k| held.clumps.of(k).is_some()).collect();
        for number in held.motions.numbers() {
            let (k, motion) = (place[number as usize], held.motions.of(number));
            if held.clumps.of(k as usize).is_none() {
                held.mask[k as usize] = true;
                held.driven.extend(motion.map(|motion| (k, motion)));
            }
        }
        held
    }

    /// Whether each sphere is held; empty where none is.
    pub fn mask(&self) -> &[bool] {
        &self.mask
    }

    /// Whether the sphere at a place in storage is given its motion.
    pub fn is_driven(&self, place: usize) -> bool {
        !self.mask.is_empty() && self.mask[place] && self.clumps.of(place).is_none()
    }

    /// Moves what is held by one time step. Returns the farthest way that a sphere went (m), not a
    /// number where one went nowhere finite.
    pub fn advance(
        &mut self,
        particles: &mut Particles,
        centre: &mut [[f64; 4]],
        (loads, step): (Loads<'_>, &Step),
        mut work: Option<&mut MotionWork>,
    ) -> f64 {
        let Held { motions, clumps, driven, strokes, mask } = self;
        if mask.is_empty() {
            return 0.0;
        }
        motions.advance(step.dt, strokes);
        let of_singles =
            drive(driven, strokes, particles, centre, (loads, step), work.as_deref_mut());
        let of_clumps = clumps.advance(particles, centre, (loads, step), strokes, work);
        if of_clumps.is_nan() || of_singles.is_nan() { f64::NAN } else { of_singles.max(of_clumps) }
    }
}
