//! The pairs of spheres of one block: those that touch are gathered into
//! batches, evaluated, and their forces handed to the spheres.

use super::batch::{Batch, LANES, PairLaw, get, put};
use super::kernel::dot;
use super::pass::{Input, Wrench};
use crate::Vec3;

/// A range of pairs of one block, and what they do to its spheres.
pub(super) struct Pairs<'a> {
    pub pairs: &'a [[u32; 2]],
    pub touch: &'a mut [bool],
    pub shear: &'a mut [Vec3],
    /// Where the forces on second spheres go if these belong to other blocks.
    pub sent: Option<&'a mut [Wrench]>,
    /// Index of the block's first sphere.
    pub first: usize,
    /// The block's forces and torques.
    pub force: &'a mut [Vec3],
    pub torque: &'a mut [Vec3],
}

impl Pairs<'_> {
    /// Evaluates all the pairs.
    #[inline(always)]
    pub fn evaluate<const FRICTION: bool, const ROTATION: bool>(
        &mut self,
        batch: &mut Batch,
        input: &Input<'_>,
    ) {
        let law = PairLaw {
            pair: input.law.pair,
            ratio: input.law.ratio,
            friction: input.law.friction,
            dt: input.dt,
        };
        let mut next = 0;
        while next < self.pairs.len() {
            next = self.collect(batch, next, input.centre);
            if FRICTION {
                self.load_motion::<ROTATION>(batch, input);
            }
            batch.evaluate::<FRICTION, ROTATION>(law);
            self.scatter::<FRICTION, ROTATION>(batch);
        }
    }

    /// Fills the batch with the next touching pairs from `next` on; returns
    /// the first pair not looked at.
    #[inline(always)]
    fn collect(&mut self, batch: &mut Batch, mut next: usize, centre: &[[f64; 4]]) -> usize {
        let mut count = 0;
        let end = self.pairs.len().min(self.touch.len());
        while next < end && count < LANES {
            let [i, j] = self.pairs[next];
            let (a, b) = (centre[i as usize], centre[j as usize]);
            let apart = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let distance2 = dot(apart, apart);
            let reach = a[3] + b[3];
            let touch = distance2 < reach * reach;
            batch.slot[count] = next as u32;
            batch.pair[count] = [i, j];
            put(&mut batch.apart, count, apart);
            batch.radius[0][count] = a[3];
            batch.radius[1][count] = b[3];
            count += usize::from(touch);
            if touch != self.touch[next] {
                self.touch[next] = touch;
                if !touch {
                    self.part(next);
                }
            }
            next += 1;
        }
        batch.count = count;
        next
    }

    /// Two spheres have lost touch.
    #[cold]
    fn part(&mut self, slot: usize) {
        self.shear[slot] = Vec3::zeros();
        if let Some(sent) = &mut self.sent {
            sent[slot] = [0.0; 6];
        }
    }

    #[inline(always)]
    fn load_motion<const ROTATION: bool>(&self, batch: &mut Batch, input: &Input<'_>) {
        let (velocity, spin, shear) = (input.velocity, input.spin, &*self.shear);
        for l in 0..batch.count.min(LANES) {
            let [i, j] = batch.pair[l].map(|k| k as usize);
            put(&mut batch.shear, l, shear[batch.slot[l] as usize].into());
            put(&mut batch.velocity, l, (velocity[j] - velocity[i]).into());
            if ROTATION {
                put(&mut batch.spin[0], l, spin[i].into());
                put(&mut batch.spin[1], l, spin[j].into());
            }
        }
    }

    #[inline(always)]
    fn scatter<const FRICTION: bool, const ROTATION: bool>(&mut self, batch: &Batch) {
        for l in 0..batch.count.min(LANES) {
            let slot = batch.slot[l] as usize;
            let i = batch.pair[l][0] as usize - self.first;
            let force = Vec3::from(get(&batch.force, l));
            self.force[i] -= force;
            if FRICTION {
                self.shear[slot] = get(&batch.shear, l).into();
                if ROTATION {
                    self.torque[i] -= Vec3::from(get(&batch.torque[0], l));
                }
            }
            let torque = if FRICTION && ROTATION { get(&batch.torque[1], l) } else { [0.0; 3] };
            match &mut self.sent {
                None => {
                    let j = batch.pair[l][1] as usize - self.first;
                    self.force[j] += force;
                    if FRICTION && ROTATION {
                        self.torque[j] += Vec3::from(torque);
                    }
                }
                Some(sent) => {
                    sent[slot] = [force.x, force.y, force.z, torque[0], torque[1], torque[2]];
                }
            }
        }
    }
}
