//! Contact forces: one pass over the blocks evaluates each contact once and
//! sums up within the block; a second one gathers what crosses blocks.

use super::cell_pass::CellSum;
use super::law::{Batch, ContactLaw, Losses, Needs};
use super::neighbours::{Bounds, Neighbours, WallPair};
use super::parameters::ParameterTable;
use super::particles::reuse;
use super::pass_input::Input;
use super::sphere_pairs::{SpherePairRange, Wrench};
use super::wall_pairs::{WallPairRange, WallSum};
use crate::parallel::{BLOCK, Span, cut, cut_mut, for_blocks};
use crate::{PerWall, Vec3};

/// What the contact pass writes.
#[derive(Debug, Default)]
pub(super) struct Forces {
    /// Force of the contacts on each sphere (N).
    pub force: Vec<Vec3>,
    /// Torque of the contacts on each sphere (N m).
    pub torque: Vec<Vec3>,
    /// What each outer pair does to its second sphere.
    pub sent: Vec<Wrench>,
    /// Sums on the walls, per block.
    pub wall_sums: Vec<PerWall<WallSum>>,
    /// What contacts have dissipated in the step, per block; empty where that is not tracked.
    pub losses: Vec<Losses>,
    /// Sums of the contacts in a periodic cell, per block; empty without one.
    pub cell_sums: Vec<CellSum>,
}

impl Forces {
    /// Goes on in the memory of forces on as many spheres, which are of no use any more.
    pub fn move_into(&mut self, memory: Forces) {
        reuse(&mut self.force, memory.force);
        reuse(&mut self.torque, memory.torque);
    }
}

/// A law with the constants of this pass.
struct Bound<'a, L: ContactLaw> {
    law: &'a L,
    table: &'a ParameterTable<L>,
    /// Whether walls need more than overlaps.
    wall_motion: bool,
    input: Input<'a>,
}

/// Computes all contact forces; histories follow the last step.
pub(super) fn contact_forces<L: ContactLaw>(
    law: &L,
    table: &ParameterTable<L>,
    list: &mut Neighbours,
    out: &mut Forces,
    input: Input<'_>,
) {
    let bound = Bound { law, table, wall_motion: table.wall_needs() > Needs::Overlap, input };
    if L::GENERAL_KERNELS {
        return match input.cell {
            None => choose_general::<L, false>(list, out, &bound),
            Some(_) => choose_general::<L, true>(list, out, &bound),
        };
    }
    match (input.cell.is_some(), input.material.is_empty()) {
        (false, true) => choose::<L, false, false>(list, out, &bound),
        (false, false) => choose::<L, true, false>(list, out, &bound),
        (true, true) => choose::<L, false, true>(list, out, &bound),
        (true, false) => choose::<L, true, true>(list, out, &bound),
    }
}

fn choose<L: ContactLaw, const MATERIALS: bool, const PERIODIC: bool>(
    list: &mut Neighbours,
    out: &mut Forces,
    bound: &Bound<'_, L>,
) {
    match (bound.table.needs(), bound.input.rotation) {
        (Needs::Overlap, _) => run::<L, MATERIALS, false, false, PERIODIC>(list, out, bound),
        (Needs::Motion, _) | (Needs::Torques, false) => {
            run::<L, MATERIALS, true, false, PERIODIC>(list, out, bound);
        }
        (Needs::Torques, true) => run::<L, MATERIALS, true, true, PERIODIC>(list, out, bound),
    }
}

fn choose_general<L: ContactLaw, const PERIODIC: bool>(
    list: &mut Neighbours,
    out: &mut Forces,
    bound: &Bound<'_, L>,
) {
    if bound.table.needs() == Needs::Torques && bound.input.rotation {
        run::<L, true, true, true, PERIODIC>(list, out, bound);
    } else {
        run::<L, true, true, false, PERIODIC>(list, out, bound);
    }
}

fn run<
    L: ContactLaw,
    const MATERIALS: bool,
    const MOTION: bool,
    const TORQUES: bool,
    const PERIODIC: bool,
>(
    list: &mut Neighbours,
    out: &mut Forces,
    bound: &Bound<'_, L>,
) {
    let span = PairSpan {
        first: 0,
        length: bound.law.history_length(),
        bounds: &list.bounds,
        pairs: &list.pairs,
        image: &list.image,
        touch: &mut list.touch,
        history: &mut list.history,
        wall_pairs: &list.wall_pairs,
        wall_touch: &mut list.wall_touch,
        wall_history: &mut list.wall_history,
        force: &mut out.force,
        torque: &mut out.torque,
        sent: &mut out.sent,
        wall_sums: &mut out.wall_sums,
        losses: &mut out.losses,
        cell_sums: &mut out.cell_sums,
    };
    let arch = pulp::Arch::new();
    let work = |span: PairSpan<'_>| {
        arch.dispatch(Evaluate::<L, MATERIALS, MOTION, TORQUES, PERIODIC> { span, bound });
    };
    for_blocks(span, &work, &|(), ()| ());

    let span =
        GatherSpan { start: &list.incoming_start, force: &mut out.force, torque: &mut out.torque };
    let (incoming, sent) = (&list.incoming, &out.sent);
    let work = |span: GatherSpan<'_>| span.gather::<TORQUES>(incoming, sent);
    for_blocks(span, &work, &|(), ()| ());
}

/// A run of blocks with their pairs and what the pass writes for them.
struct PairSpan<'a> {
    /// Index of the first particle.
    first: usize,
    /// Numbers per contact in the histories.
    length: usize,
    bounds: &'a [Bounds],
    pairs: &'a [[u32; 2]],
    image: &'a [u8],
    touch: &'a mut [bool],
    history: &'a mut [f64],
    wall_pairs: &'a [WallPair],
    wall_touch: &'a mut [bool],
    wall_history: &'a mut [f64],
    force: &'a mut [Vec3],
    torque: &'a mut [Vec3],
    sent: &'a mut [Wrench],
    wall_sums: &'a mut [PerWall<WallSum>],
    losses: &'a mut [Losses],
    cell_sums: &'a mut [CellSum],
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
        let image = cut(self.image, pairs);
        let touch = self.touch.split_at_mut(pairs);
        let history = self.history.split_at_mut(pairs * self.length);
        let wall_pair = self.wall_pairs.split_at(walls);
        let wall_touch = self.wall_touch.split_at_mut(walls);
        let wall_history = self.wall_history.split_at_mut(walls * self.length);
        let force = cut_mut(self.force, particles);
        let torque = cut_mut(self.torque, particles);
        let sent = self.sent.split_at_mut(to.sent - from.sent);
        let sums = self.wall_sums.split_at_mut(blocks);
        let losses = cut_mut(self.losses, blocks);
        let cell_sums = cut_mut(self.cell_sums, blocks);
        (
            PairSpan {
                first: self.first,
                length: self.length,
                bounds: &self.bounds[..=blocks],
                pairs: pair.0,
                image: image.0,
                touch: touch.0,
                history: history.0,
                wall_pairs: wall_pair.0,
                wall_touch: wall_touch.0,
                wall_history: wall_history.0,
                force: force.0,
                torque: torque.0,
                sent: sent.0,
                wall_sums: sums.0,
                losses: losses.0,
                cell_sums: cell_sums.0,
            },
            PairSpan {
                first: self.first + particles,
                length: self.length,
                bounds: &self.bounds[blocks..],
                pairs: pair.1,
                image: image.1,
                touch: touch.1,
                history: history.1,
                wall_pairs: wall_pair.1,
                wall_touch: wall_touch.1,
                wall_history: wall_history.1,
                force: force.1,
                torque: torque.1,
                sent: sent.1,
                wall_sums: sums.1,
                losses: losses.1,
                cell_sums: cell_sums.1,
            },
        )
    }
}

/// The evaluation of a run of blocks, compiled once more for processors with
/// wider vector units. Lanes do not mix, so the bits are the same.
struct Evaluate<
    'a,
    L: ContactLaw,
    const MATERIALS: bool,
    const MOTION: bool,
    const TORQUES: bool,
    const PERIODIC: bool,
> {
    span: PairSpan<'a>,
    bound: &'a Bound<'a, L>,
}

impl<
    L: ContactLaw,
    const MATERIALS: bool,
    const MOTION: bool,
    const TORQUES: bool,
    const PERIODIC: bool,
> pulp::NullaryFnOnce for Evaluate<'_, L, MATERIALS, MOTION, TORQUES, PERIODIC>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.span.evaluate::<L, MATERIALS, MOTION, TORQUES, PERIODIC>(self.bound);
    }
}

impl PairSpan<'_> {
    #[inline(always)]
    fn evaluate<
        L: ContactLaw,
        const MATERIALS: bool,
        const MOTION: bool,
        const TORQUES: bool,
        const PERIODIC: bool,
    >(
        self,
        bound: &Bound<'_, L>,
    ) {
        let Bound { law, table, ref input, .. } = *bound;
        let origin = self.bounds[0];
        let length = law.history_length();
        let mut scratch = L::Scratch::default();
        let mut pair_batch = Batch::new(input.dt, input.tracks_energy);
        let mut wall_batch = Batch::new(input.dt, input.tracks_energy);
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
            if let (true, Some(sum)) = (PERIODIC, self.cell_sums.get_mut(block)) {
                *sum = CellSum::default();
            }
            for (range, sent) in [(inner, None), (outer, Some(sent))] {
                SpherePairRange {
                    pairs: &self.pairs[range.clone()],
                    image: if PERIODIC { &self.image[range.clone()] } else { &[] },
                    touch: &mut self.touch[range.clone()],
                    history: &mut self.history[range.start * length..range.end * length],
                    sent,
                    first,
                    force: &mut *force,
                    torque: &mut *torque,
                    cell_sum: if PERIODIC { self.cell_sums.get_mut(block) } else { None },
                }
                .evaluate::<L, MATERIALS, MOTION, TORQUES, PERIODIC>(
                    law,
                    table,
                    (&mut pair_batch, &mut scratch),
                    input,
                );
            }
            if let Some(losses) = self.losses.get_mut(block) {
                *losses = std::mem::take(&mut pair_batch.losses);
            }
            if PERIODIC {
                continue;
            }
            let range = from.wall - origin.wall..to.wall - origin.wall;
            let mut walls = WallPairRange {
                pairs: &self.wall_pairs[range.clone()],
                touch: &mut self.wall_touch[range.clone()],
                history: &mut self.wall_history[range.start * length..range.end * length],
                first,
                force,
                torque,
            };
            let lanes = (&mut wall_batch, &mut scratch);
            self.wall_sums[block] = if L::GENERAL_KERNELS || bound.wall_motion {
                walls.evaluate::<L, MATERIALS, MOTION, TORQUES>(law, table, lanes, input)
            } else {
                walls.evaluate::<L, MATERIALS, false, false>(law, table, lanes, input)
            };
            if let Some(losses) = self.losses.get_mut(block) {
                losses.join(&std::mem::take(&mut wall_batch.losses));
            }
        }
    }
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
