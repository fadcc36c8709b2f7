//! Contact forces: one pass over the blocks evaluates each contact once and
//! sums up within the block; a second one gathers what crosses blocks.

use super::batch::Batch;
use super::kernel::{Sliding, V, add_scaled, cross, dot, scaled, shear_force};
use super::material::Law;
use super::neighbours::{Bounds, Neighbours, WallPair};
use super::pairs::Pairs;
use super::walls::Wall;
use crate::parallel::{BLOCK, Span, cut_mut, for_blocks};
use crate::{Vec3, WallId};

/// Force and torque on the second sphere of a pair that crosses blocks.
pub(super) type Wrench = [f64; 6];

/// Sums over the contacts on a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallSum {
    /// Force on the wall (N).
    pub force: Vec3,
    /// Normal stiffness (N/m).
    pub stiffness: f64,
}

impl WallSum {
    pub const ZERO: WallSum = WallSum { force: Vec3::new(0.0, 0.0, 0.0), stiffness: 0.0 };
}

/// What the contact pass writes.
#[derive(Default)]
pub(super) struct Forces {
    /// Force of the contacts on each sphere (N).
    pub force: Vec<Vec3>,
    /// Torque of the contacts on each sphere (N m).
    pub torque: Vec<Vec3>,
    /// What each outer pair does to its second sphere.
    pub sent: Vec<Wrench>,
    /// Sums on the walls, per block.
    pub wall_sums: Vec<[WallSum; 6]>,
}

/// What the contact pass reads.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    /// Centre and radius of each sphere.
    pub centre: &'a [[f64; 4]],
    pub velocity: &'a [Vec3],
    pub spin: &'a [Vec3],
    pub walls: &'a [Wall; 6],
    pub law: Law,
    /// Length of the step that the shear forces have yet to follow (s), or 0.
    pub dt: f64,
    pub rotation: bool,
}

/// Computes all contact forces; shear forces follow the last step.
pub(super) fn contact_forces(list: &mut Neighbours, out: &mut Forces, input: Input<'_>) {
    match (input.law.has_friction(), input.rotation) {
        (false, _) => run::<false, false>(list, out, input),
        (true, false) => run::<true, false>(list, out, input),
        (true, true) => run::<true, true>(list, out, input),
    }
}

fn run<const FRICTION: bool, const ROTATION: bool>(
    list: &mut Neighbours,
    out: &mut Forces,
    input: Input<'_>,
) {
    let span = PairSpan {
        first: 0,
        bounds: &list.bounds,
        pairs: &list.pairs,
        touch: &mut list.touch,
        shear: &mut list.shear,
        wall_pairs: &list.wall_pairs,
        wall_touch: &mut list.wall_touch,
        wall_shear: &mut list.wall_shear,
        force: &mut out.force,
        torque: &mut out.torque,
        sent: &mut out.sent,
        wall_sums: &mut out.wall_sums,
    };
    let arch = pulp::Arch::new();
    let work = |span: PairSpan<'_>| {
        arch.dispatch(Evaluate::<FRICTION, ROTATION> { span, input: &input });
    };
    for_blocks(span, &work, &|(), ()| ());

    let span =
        GatherSpan { start: &list.incoming_start, force: &mut out.force, torque: &mut out.torque };
    let (incoming, sent) = (&list.incoming, &out.sent);
    let work = |span: GatherSpan<'_>| span.gather::<ROTATION>(incoming, sent);
    for_blocks(span, &work, &|(), ()| ());
}

/// A run of blocks with their pairs and what the pass writes for them.
struct PairSpan<'a> {
    /// Index of the first particle.
    first: usize,
    bounds: &'a [Bounds],
    pairs: &'a [[u32; 2]],
    touch: &'a mut [bool],
    shear: &'a mut [Vec3],
    wall_pairs: &'a [WallPair],
    wall_touch: &'a mut [bool],
    wall_shear: &'a mut [Vec3],
    force: &'a mut [Vec3],
    torque: &'a mut [Vec3],
    sent: &'a mut [Wrench],
    wall_sums: &'a mut [[WallSum; 6]],
}

impl Span for PairSpan<'_> {
    fn blocks(&self) -> usize {
        self.wall_sums.len()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let (from, to) = (self.bounds[0], self.bounds[blocks]);
        let pairs = to.inner - from.inner;
        let walls = to.wall - from.wall;
        let particles = blocks * BLOCK;
        let pair = self.pairs.split_at(pairs);
        let touch = self.touch.split_at_mut(pairs);
        let shear = self.shear.split_at_mut(pairs);
        let wall_pair = self.wall_pairs.split_at(walls);
        let wall_touch = self.wall_touch.split_at_mut(walls);
        let wall_shear = self.wall_shear.split_at_mut(walls);
        let force = cut_mut(self.force, particles);
        let torque = cut_mut(self.torque, particles);
        let sent = self.sent.split_at_mut(to.sent - from.sent);
        let sums = self.wall_sums.split_at_mut(blocks);
        (
            PairSpan {
                first: self.first,
                bounds: &self.bounds[..=blocks],
                pairs: pair.0,
                touch: touch.0,
                shear: shear.0,
                wall_pairs: wall_pair.0,
                wall_touch: wall_touch.0,
                wall_shear: wall_shear.0,
                force: force.0,
                torque: torque.0,
                sent: sent.0,
                wall_sums: sums.0,
            },
            PairSpan {
                first: self.first + particles,
                bounds: &self.bounds[blocks..],
                pairs: pair.1,
                touch: touch.1,
                shear: shear.1,
                wall_pairs: wall_pair.1,
                wall_touch: wall_touch.1,
                wall_shear: wall_shear.1,
                force: force.1,
                torque: torque.1,
                sent: sent.1,
                wall_sums: sums.1,
            },
        )
    }
}

/// The evaluation of a run of blocks, compiled once more for processors with
/// wider vector units. Lanes do not mix, so the bits are the same.
struct Evaluate<'a, const FRICTION: bool, const ROTATION: bool> {
    span: PairSpan<'a>,
    input: &'a Input<'a>,
}

impl<const FRICTION: bool, const ROTATION: bool> pulp::NullaryFnOnce
    for Evaluate<'_, FRICTION, ROTATION>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.span.evaluate::<FRICTION, ROTATION>(self.input);
    }
}

impl PairSpan<'_> {
    #[inline(always)]
    fn evaluate<const FRICTION: bool, const ROTATION: bool>(mut self, input: &Input<'_>) {
        let origin = self.bounds[0];
        let mut batch = Batch::new();
        for block in 0..self.wall_sums.len() {
            let (from, to) = (self.bounds[block], self.bounds[block + 1]);
            let spheres = block * BLOCK..((block + 1) * BLOCK).min(self.force.len());
            let first = self.first + spheres.start;
            let force = &mut self.force[spheres.clone()];
            let torque = &mut self.torque[spheres];
            force.fill(Vec3::zeros());
            torque.fill(Vec3::zeros());
            let inner = from.inner - origin.inner..from.outer - origin.inner;
            let outer = from.outer - origin.inner..to.inner - origin.inner;
            let sent = &mut self.sent[from.sent - origin.sent..to.sent - origin.sent];
            for (range, sent) in [(inner, None), (outer, Some(sent))] {
                Pairs {
                    pairs: &self.pairs[range.clone()],
                    touch: &mut self.touch[range.clone()],
                    shear: &mut self.shear[range],
                    sent,
                    first,
                    force: &mut *force,
                    torque: &mut *torque,
                }
                .evaluate::<FRICTION, ROTATION>(&mut batch, input);
            }
            let walls = from.wall - origin.wall..to.wall - origin.wall;
            self.wall_sums[block] = self.walls::<FRICTION, ROTATION>(walls, input);
        }
    }

    /// Evaluates a range of sphere-wall pairs.
    #[inline(always)]
    fn walls<const FRICTION: bool, const ROTATION: bool>(
        &mut self,
        range: std::ops::Range<usize>,
        input: &Input<'_>,
    ) -> [WallSum; 6] {
        let mut sums = [WallSum::ZERO; 6];
        for slot in range {
            let WallPair { i, wall } = self.wall_pairs[slot];
            let (i, w) = (i as usize, wall.index());
            let centre = &input.centre[i];
            let distance = (centre[wall.axis()] - input.walls[w].position) * wall.inward();
            let overlap = centre[3] - distance;
            if overlap <= 0.0 {
                if self.wall_touch[slot] {
                    self.wall_touch[slot] = false;
                    self.wall_shear[slot] = Vec3::zeros();
                }
                continue;
            }
            self.wall_touch[slot] = true;
            let stiffness = input.law.wall * centre[3];
            let push = stiffness * overlap;
            let mut normal: V = [0.0; 3];
            normal[wall.axis()] = -wall.inward();
            let mut force = scaled(push, normal);
            if FRICTION && input.law.wall_friction > 0.0 {
                let arm = centre[3] - 0.5 * overlap;
                let mut shear = self.wall_shear[slot].into();
                if input.dt > 0.0 {
                    let motion = wall_sliding::<ROTATION>(i, wall, normal, arm, input);
                    let limit = input.law.wall_friction * push;
                    shear = shear_force(shear, &motion, input.law.ratio * stiffness, limit);
                    self.wall_shear[slot] = shear.into();
                }
                force = add_scaled(force, 1.0, shear);
                if ROTATION {
                    self.torque[i - self.first] -= arm * Vec3::from(cross(normal, shear));
                }
            }
            let force = Vec3::from(force);
            self.force[i - self.first] -= force;
            sums[w].force += force;
            sums[w].stiffness += stiffness;
        }
        sums
    }
}

/// How the contact of sphere `i` with a wall moved during the last step.
#[inline(always)]
fn wall_sliding<const ROTATION: bool>(
    i: usize,
    wall: WallId,
    normal: V,
    arm: f64,
    input: &Input<'_>,
) -> Sliding {
    // A wall moves along its normal only: it does not slide.
    let velocity: V = (-input.velocity[i]).into();
    let mut across = velocity;
    across[wall.axis()] = 0.0;
    let mut motion =
        Sliding { normal, half_turn: [0.0; 3], twist: 0.0, slip: scaled(input.dt, across) };
    if ROTATION {
        let spin: V = input.spin[i].into();
        motion.twist = 0.5 * input.dt * dot(spin, normal);
        motion.slip = add_scaled(motion.slip, -input.dt * arm, cross(spin, normal));
    }
    motion
}

/// A run of blocks that gather.
struct GatherSpan<'a> {
    /// Where each particle's incoming results start, and the end.
    start: &'a [u32],
    force: &'a mut [Vec3],
    torque: &'a mut [Vec3],
}

impl Span for GatherSpan<'_> {
    fn blocks(&self) -> usize {
        self.force.len().div_ceil(BLOCK)
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let n = blocks * BLOCK;
        let force = cut_mut(self.force, n);
        let torque = cut_mut(self.torque, n);
        (
            GatherSpan { start: &self.start[..=n], force: force.0, torque: torque.0 },
            GatherSpan { start: &self.start[n..], force: force.1, torque: torque.1 },
        )
    }
}

impl GatherSpan<'_> {
    fn gather<const ROTATION: bool>(self, incoming: &[u32], sent: &[Wrench]) {
        for (k, range) in self.start.windows(2).enumerate() {
            for &slot in &incoming[range[0] as usize..range[1] as usize] {
                let [fx, fy, fz, tx, ty, tz] = sent[slot as usize];
                self.force[k] += Vec3::new(fx, fy, fz);
                if ROTATION {
                    self.torque[k] += Vec3::new(tx, ty, tz);
                }
            }
        }
    }
}
