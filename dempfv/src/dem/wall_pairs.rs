//! The sphere-wall pairs of one block, gathered, evaluated and handed on as
//! the pairs of spheres are.

use super::contact_step::ContactStep;
use super::law::{
    Batch, CONTACTS_PER_BATCH, ContactLaw, Geometry, History, Loss, SphereOnPlane, SpheresOnWalls,
    get, put,
};
use super::neighbours::WallPair;
use super::parameters::ParameterTable;
use super::pass_input::{Input, material_of};
use super::touch_change::TouchChange;
use crate::{Effect, EffectKey, Family};
use crate::{PerWall, Vec3, WallId};

/// What this effect says of itself.
pub const WALL_FRICTION: Effect = Effect {
    name: "wall friction",
    family: Family::Boundaries,
    equation: "as friction, with tan min(φ, φ_w)",
    source: "P. A. Cundall, O. D. L. Strack: Géotechnique 29 (1979)",
    keys: &[EffectKey { key: "friction_angle in [walls]", unit: "degrees", default: "0" }],
    needs: "friction",
    test: "dempfv/tests/dem_walls.rs",
};

/// Sums over the contacts on a wall.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WallSum {
    /// Force on the wall (N).
    pub force: Vec3,
    /// Normal stiffness (N/m).
    pub stiffness: f64,
    /// Coefficient of the normal dashpots (N s/m).
    pub dashpot: f64,
}

/// A batch of spheres on walls with the lanes of a law.
type WallBatch<L> = Batch<SpheresOnWalls, <L as ContactLaw>::History>;

/// The sphere-wall pairs of one block, and what they do to its spheres.
pub(super) struct WallPairRange<'a> {
    pub pairs: &'a [WallPair],
    pub touch: &'a mut [bool],
    pub history: &'a mut [f64],
    /// Index of the block's first sphere.
    pub first: usize,
    /// The block's forces and torques.
    pub force: &'a mut [Vec3],
    pub torque: &'a mut [Vec3],
}

impl WallPairRange<'_> {
    /// Evaluates all the pairs; returns what they do to the walls.
    #[inline(always)]
    pub fn evaluate<
        L: ContactLaw,
        const MATERIALS: bool,
        const MOTION: bool,
        const TORQUES: bool,
    >(
        &mut self,
        law: &L,
        table: &ParameterTable<L>,
        (batch, scratch): (&mut WallBatch<L>, &mut L::Scratch),
        input: &Input<'_>,
    ) -> PerWall<WallSum> {
        let mut sums = PerWall::default();
        let (cut_off, length, only) = (law.cut_off(), law.history_length(), table.wall(0));
        let mut next = 0;
        while next < self.pairs.len() {
            next = self.collect::<L>(batch, next, (law, table), input, cut_off);
            if MOTION {
                self.load_motion::<L, TORQUES>(batch, input, length);
            }
            if MATERIALS {
                let (bodies, material) = (batch.bodies, input.material);
                let parameters = |l: usize| table.wall(material_of::<L>(material, bodies[l][0]));
                law.evaluate::<_, MOTION, TORQUES>(batch, scratch, parameters);
                if MOTION && input.tracks_turning && batch.dt != 0.0 {
                    self.book_turning::<L, TORQUES>(batch, (law, table), input);
                }
                self.scatter::<L, MOTION, TORQUES>(law, parameters, batch, &mut sums);
            } else {
                law.evaluate::<_, MOTION, TORQUES>(batch, scratch, |_| only);
                if MOTION && input.tracks_turning && batch.dt != 0.0 {
                    self.book_turning::<L, TORQUES>(batch, (law, table), input);
                }
                self.scatter::<L, MOTION, TORQUES>(law, |_| only, batch, &mut sums);
            }
        }
        sums
    }

    /// Fills the batch with the next pairs within reach from `next` on;
    /// returns the first pair not looked at.
    #[inline(always)]
    fn collect<L: ContactLaw>(
        &mut self,
        batch: &mut WallBatch<L>,
        mut next: usize,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
        cut_off: f64,
    ) -> usize {
        let mut count = 0;
        let end = self.pairs.len().min(self.touch.len());
        while next < end && count < CONTACTS_PER_BATCH {
            let WallPair { i, wall } = self.pairs[next];
            let centre = &input.centre[i as usize];
            let distance = (centre[wall.axis()] - input.walls[wall].position) * wall.inward();
            let overlap = centre[3] - distance;
            let touch = overlap > -cut_off;
            let mut normal = [0.0; 3];
            normal[wall.axis()] = -wall.inward();
            batch.slot[count] = next as u32;
            batch.bodies[count] = [i, wall.index() as u32];
            batch.geometry.radius[count] = centre[3];
            batch.geometry.overlap[count] = overlap;
            put(&mut batch.geometry.normal, count, normal);
            count += usize::from(touch);
            if touch != self.touch[next] {
                self.touch[next] = touch;
                self.change(batch, next, (law, table), input);
            }
            next += 1;
        }
        batch.count = count;
        next
    }

    /// A sphere and a wall have come into touch, or lost it.
    #[cold]
    fn change<L: ContactLaw>(
        &mut self,
        batch: &mut WallBatch<L>,
        slot: usize,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
    ) {
        let length = law.history_length();
        if batch.tracks_energy {
            let (sphere, step) = self.step(slot, input);
            let parameters = table.wall(input.material_at(sphere));
            let radii = SphereOnPlane(input.centre[sphere as usize][3]);
            let history = &self.history[slot * length..][..length];
            let change = TouchChange { radii, step, history };
            change.book(law, &parameters, &mut batch.losses);
        }
        if !self.touch[slot] {
            self.history[slot * length..][..length].fill(0.0);
        }
    }

    /// The sphere of a pair, and the pair in the last step.
    fn step(&self, slot: usize, input: &Input<'_>) -> (u32, ContactStep) {
        let WallPair { i, wall } = self.pairs[slot];
        let (centre, plane) = (input.centre[i as usize], &input.walls[wall]);
        let distance = (centre[wall.axis()] - plane.position) * wall.inward();
        let mut velocity = -input.velocity[i as usize];
        velocity[wall.axis()] += plane.velocity;
        let place = (-wall.inward_normal(), distance);
        (i, ContactStep::on_wall(centre[3], place, input.dt * velocity, input.turn(i)))
    }

    /// Books what the batch loses by turning, after the law has evaluated it. Normals do not turn.
    #[inline(never)]
    fn book_turning<L: ContactLaw, const TORQUES: bool>(
        &self,
        batch: &mut WallBatch<L>,
        (law, table): (&L, &ParameterTable<L>),
        input: &Input<'_>,
    ) {
        let length = law.history_length();
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let slot = batch.slot[l] as usize;
            let (sphere, step) = self.step(slot, input);
            let (parameters, radii) =
                (table.wall(input.material_at(sphere)), batch.geometry.radii(l));
            let before = L::History::read(&self.history[slot * length..][..length]);
            let now = L::History::of(&batch.history, l);
            let shears = [(step.before, before), (step.now, now)]
                .map(|(at, history)| law.force(&parameters, radii, at.overlap, &history).shear);
            let sliding = batch.geometry.sliding::<TORQUES>(l, batch.dt);
            batch.losses.add(Loss::Turning, step.lost_by_turning_shear(shears, &sliding));
        }
    }

    #[inline(always)]
    fn load_motion<L: ContactLaw, const TORQUES: bool>(
        &self,
        batch: &mut WallBatch<L>,
        input: &Input<'_>,
        length: usize,
    ) {
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let (i, wall) = (batch.bodies[l][0] as usize, WallId::ALL[batch.bodies[l][1] as usize]);
            let slot = batch.slot[l] as usize;
            L::History::load(&mut batch.history, l, &self.history[slot * length..][..length]);
            // A wall moves along its normal only: it does not slide.
            let mut velocity = -input.velocity[i];
            velocity[wall.axis()] += input.walls[wall].velocity;
            put(&mut batch.geometry.velocity, l, velocity.into());
            if TORQUES {
                put(&mut batch.geometry.spin, l, input.spin[i].into());
            }
        }
    }

    #[inline(always)]
    fn scatter<L: ContactLaw, const MOTION: bool, const TORQUES: bool>(
        &mut self,
        law: &L,
        parameters: impl Fn(usize) -> L::Parameters,
        batch: &WallBatch<L>,
        sums: &mut PerWall<WallSum>,
    ) {
        for l in 0..batch.count.min(CONTACTS_PER_BATCH) {
            let [i, wall] = batch.bodies[l].map(|k| k as usize);
            let i = i - self.first;
            let force = Vec3::from(get(&batch.force, l));
            self.force[i] -= force;
            if MOTION {
                let (slot, length) = (batch.slot[l] as usize, law.history_length());
                let to = &mut self.history[slot * length..][..length];
                L::History::store(&batch.history, l, to);
            }
            if TORQUES {
                self.torque[i] += Vec3::from(get(&batch.torque[0], l));
            }
            let (radii, overlap) = (batch.geometry.radii(l), batch.geometry.overlap(l));
            let sum = &mut sums.0[wall];
            sum.force += force;
            sum.stiffness += law.stiffness(&parameters(l), radii, overlap).normal;
            sum.dashpot += law.dashpot(&parameters(l), radii, overlap);
        }
    }
}
