//! The pairs of spheres of one block: those within reach are gathered into
//! batches, evaluated, and their forces handed to the spheres.

use super::cell_pass::CellSum;
use super::contact_step::ContactStep;
use super::law::vector::dot;
use super::law::{
    Batch, CONTACTS_PER_BATCH, ContactLaw, Geometry, History, Loss, SpherePairs, TwoSpheres, get,
    put,
};
use super::parameters::ParameterTable;
use super::pass_input::{Input, material_of};
use super::touch_change::TouchChange;
use crate::Vec3;

/// Force and torque on the second sphere of a pair that crosses blocks.
pub(super) type Wrench = [f64; 6];

/// A batch of pairs with the lanes of a law.
type PairBatch<L> = Batch<SpherePairs, <L as ContactLaw>::History>;

/// A range of pairs of one block, and what they do to its spheres.
pub(super) struct SpherePairRange<'a> {
    pub pairs: &'a [[u32; 2]],
    /// Which copy of the second sphere is meant; empty without a periodic cell.
    pub image: &'a [u8],
    pub touch: &'a mut [bool],
    pub history: &'a mut [f64],
    /// Where the forces on second spheres go if these belong to other blocks.
    pub sent: Option<&'a mut [Wrench]>,
    /// Index of the block's first sphere.
    pub first: usize,
    /// The block's forces and torques.
    pub force: &'a mut [Vec3],
    pub torque: &'a mut [Vec3],
    /// The block's sums, in a periodic cell.
    pub cell_sum: Option<&'a mut CellSum>,
}

impl SpherePairRange<'_> {
    /// Evaluates all the pairs.
    #[inline(always)]
    pub fn evaluate<
        L: ContactLaw,
        const MATERIALS: bool,
        const MOTION: bool,
        const TORQUES: bool,
        const PERIODIC: bool,
    >(
        &mut self,
        law: &L,
        table: &ParameterTable<L>,
        (batch, scratch): (&mut PairBatch<L>, &mut L::Scratch),
        input: &Input<'_>,
    ) {
        let (cut_off, length, only) = (law.cut_off(), law.history_length(), table.spheres(0, 0));
        let mut next = 0;
        while next < self.pairs.len() {
            next = self.collect::<L, PERIODIC>(batch, next, (law, table), input, cut_off);
            if MOTION {
                self.load_motion::<L, TORQUES, PERIODIC>(batch, input, length);
            }
            for l in batch.lanes() {
                batch.geometry.measure(l);
            }
            if MATERIALS {
                let (bodies, material) = (batch.bodies, input.material);
                let of = |l: usize, k: usize| material_of::<L>(material, bodies[l][k]);
                let parameters = |l: usize| table.spheres(of(l, 0), of(l, 1));
                law.evaluate::<_, MOTION, TORQUES>(batch, scratch, parameters);
                if let (true, Some(sum)) = (PERIODIC, &mut self.cell_sum) {
                    sum.add_batch(law, batch, parameters);
                }
            } else {
                law.evaluate::<_, MOTION, TORQUES>(batch, scratch, |_| only);
                if let (true, Some(sum)) = (PERIODIC, &mut self.cell_sum) {
                    sum.add_batch(law, batch, |_| only);
                }
            }
            if input.tracks_turning && batch.dt != 0.0 {
                self.book_turning::<L, MOTION, TORQUES, PERIODIC>(batch, (law, table), input);
            }
            self.scatter::<L, MOTION, TORQUES>(batch, length);
        }
    }

    /// Fills the batch with the next pairs within reach from `next` on;
    /// returns the first pair not looked at.
    #[inline(always)]
    fn collect<L: ContactLaw, const PERIODIC: bool>(
        &mut self,
        batch: &mut PairBatch<L>,
        mut next: usize,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
        cut_off: f64,
    ) -> usize {
        let centre = input.centre;
        let mut count = 0;
        let end = self.pairs.len().min(self.touch.len());
        while next < end && count < CONTACTS_PER_BATCH {
            let [i, j] = self.pairs[next];
            let (a, b) = (centre[i as usize], centre[j as usize]);
            let mut apart = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            if let (true, Some(cell)) = (PERIODIC, input.cell) {
                apart = cell.image_apart(self.image[next], apart);
            }
            let distance2 = dot(apart, apart);
            let reach = (a[3] + b[3]) + cut_off;
            let touch = distance2 < reach * reach;
            batch.slot[count] = next as u32;
            batch.bodies[count] = [i, j];
            put(&mut batch.geometry.apart, count, apart);
            batch.geometry.radius[0][count] = a[3];
            batch.geometry.radius[1][count] = b[3];
            count += usize::from(touch);
            if touch != self.touch[next] {
                self.touch[next] = touch;
                self.change::<L, PERIODIC>(batch, next, (law, table), input);
            }
            next += 1;
        }
        batch.count = count;
        next
    }

    /// Two spheres have come into touch, or lost it: what one remembers then is forgotten.
    #[cold]
    fn change<L: ContactLaw, const PERIODIC: bool>(
        &mut self,
        batch: &mut PairBatch<L>,
        slot: usize,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
    ) {
        let length = law.history_length();
        if batch.tracks_energy {
            let [first, second] = self.pairs[slot].map(|k| input.material_at(k));
            let parameters = table.spheres(first, second);
            let step = self.step::<PERIODIC>(slot, input);
            let [a, b] = self.pairs[slot].map(|k| input.centre[k as usize][3]);
            let history = &self.history[slot * length..][..length];
            let change = TouchChange { radii: TwoSpheres(a, b), step, history };
            change.book(law, &parameters, &mut batch.losses);
        }
        if !self.touch[slot] {
            self.history[slot * length..][..length].fill(0.0);
            if let Some(sent) = &mut self.sent {
                sent[slot] = [0.0; 6];
            }
        }
    }

    /// The pair in the last step.
    fn step<const PERIODIC: bool>(&self, slot: usize, input: &Input<'_>) -> ContactStep {
        let [i, j] = self.pairs[slot].map(|k| k as usize);
        let (a, b) = (input.centre[i], input.centre[j]);
        let mut apart = Vec3::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        let mut velocity = input.velocity[j] - input.velocity[i];
        if let (true, Some(cell)) = (PERIODIC, input.cell) {
            apart += cell.shift(self.image[slot]);
            velocity = cell.with_mean_field(velocity.into(), apart.into()).into();
        }
        let turns = self.pairs[slot].map(|k| input.turn(k));
        ContactStep::of_spheres([a[3], b[3]], apart, input.dt * velocity, turns)
    }

    /// Books what the batch loses by turning, after the law has evaluated it.
    #[inline(never)]
    fn book_turning<
        L: ContactLaw,
        const MOTION: bool,
        const TORQUES: bool,
        const PERIODIC: bool,
    >(
        &self,
        batch: &mut PairBatch<L>,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
    ) {
        let length = law.history_length();
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let slot = batch.slot[l] as usize;
            let step = self.step::<PERIODIC>(slot, input);
            let [first, second] = batch.bodies[l].map(|k| input.material_at(k));
            let (parameters, radii) = (table.spheres(first, second), batch.geometry.radii(l));
            let kept = L::History::read(&self.history[slot * length..][..length]);
            let history = if MOTION { L::History::of(&batch.history, l) } else { kept };
            let [before, now] = [(step.before, kept), (step.now, history)]
                .map(|(at, history)| law.force(&parameters, radii, at.overlap, &history));
            // Laws may name a force beyond their reach.
            let pushed = if step.before.overlap > -law.cut_off() { before.normal } else { 0.0 };
            let mut lost = step.lost_by_turning([pushed, now.normal]);
            if MOTION {
                let sliding = batch.geometry.sliding::<TORQUES>(l, batch.dt);
                lost += step.lost_by_turning_shear([before.shear, now.shear], &sliding);
            }
            batch.losses.add(Loss::Turning, lost);
        }
    }

    #[inline(always)]
    fn load_motion<L: ContactLaw, const TORQUES: bool, const PERIODIC: bool>(
        &self,
        batch: &mut PairBatch<L>,
        input: &Input<'_>,
        length: usize,
    ) {
        let (velocity, spin, history) = (input.velocity, input.spin, &*self.history);
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let [i, j] = batch.bodies[l].map(|k| k as usize);
            let slot = batch.slot[l] as usize;
            L::History::load(&mut batch.history, l, &history[slot * length..][..length]);
            let mut relative = (velocity[j] - velocity[i]).into();
            if let (true, Some(cell)) = (PERIODIC, input.cell) {
                relative = cell.with_mean_field(relative, get(&batch.geometry.apart, l));
            }
            put(&mut batch.geometry.velocity, l, relative);
            if TORQUES {
                put(&mut batch.geometry.spin[0], l, spin[i].into());
                put(&mut batch.geometry.spin[1], l, spin[j].into());
            }
        }
    }

    #[inline(always)]
    fn scatter<L: ContactLaw, const MOTION: bool, const TORQUES: bool>(
        &mut self,
        batch: &PairBatch<L>,
        length: usize,
    ) {
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let slot = batch.slot[l] as usize;
            let i = batch.bodies[l][0] as usize - self.first;
            let force = Vec3::from(get(&batch.force, l));
            self.force[i] -= force;
            if MOTION {
                let to = &mut self.history[slot * length..][..length];
                L::History::store(&batch.history, l, to);
                if TORQUES {
                    self.torque[i] += Vec3::from(get(&batch.torque[0], l));
                }
            }
            let torque = if TORQUES { get(&batch.torque[1], l) } else { [0.0; 3] };
            match &mut self.sent {
                None => {
                    let j = batch.bodies[l][1] as usize - self.first;
                    self.force[j] += force;
                    if TORQUES {
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
