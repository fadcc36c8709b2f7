//! Products with the parts of a strip, vector by vector, for callers that were dispatched
//! to a vector unit: shares by blocks of rows, and the inverse of the triangle.

use pulp::Simd;

use super::pivot::STRIP;
use super::products::{EXPONENTS, MOST, ZERO, head_words, power_of, product_words};
use super::shares::{BLOCK, OFFSET, ONES, QUARTER, SCALE, head, step_of, words as words_of};
use crate::parallel::prefetch;

/// Lanes of the widest vectors.
const WIDEST: usize = 16;

/// Vectors of a half that are worked at together, where there are enough rows.
const PAIR: usize = 2;

/// How far ahead words and triangles are asked for, in either: two to three kilobytes, which
/// are what a thread reads while memory answers. Each step asks for as much as it reads, so
/// that few lines are on their way at a time.
pub const AHEAD: isize = 768;
const AHEAD_IN_TRIANGLES: isize = 512;

/// The two halves of a block's rows, as the words have them.
#[derive(Clone, Copy)]
pub struct Halves {
    low: [f32; BLOCK / 2],
    high: [f32; BLOCK / 2],
}

impl Halves {
    #[inline(always)]
    fn zeros() -> Halves {
        Halves { low: [0.0; BLOCK / 2], high: [0.0; BLOCK / 2] }
    }

    /// Takes over values that lie one after the other.
    #[inline(always)]
    pub fn of(y: &[f32]) -> Halves {
        let mut halves = Halves::zeros();
        let (low, high) = y.split_at(words_of(y.len()));
        halves.low[..low.len()].copy_from_slice(low);
        halves.high[..high.len()].copy_from_slice(high);
        halves
    }

    /// Takes over values by their places.
    #[inline(always)]
    pub fn at(y: &[f32], places: &[u32]) -> Halves {
        let mut halves = Halves::zeros();
        let (low, high) = places.split_at(words_of(places.len()));
        for (places, out) in [(low, &mut halves.low), (high, &mut halves.high)] {
            for (out, &place) in out.iter_mut().zip(places) {
                *out = y[place as usize];
            }
        }
        halves
    }

    /// Values of both halves from one on.
    #[inline(always)]
    fn some<S: Simd, const N: usize>(&self, simd: S, from: usize) -> ([S::f32s; N], [S::f32s; N]) {
        let mut both = ([simd.splat_f32s(0.0); N], [simd.splat_f32s(0.0); N]);
        for (out, half) in [(&mut both.0, &self.low), (&mut both.1, &self.high)] {
            let (values, _) = S::as_simd_f32s(&half[from..from + N * S::F32_LANES]);
            out.copy_from_slice(values);
        }
        both
    }

    /// Each row's value times its power of two, see [`power_of`].
    #[inline(always)]
    pub fn times(&mut self, exponents: &[u32]) {
        let Halves { low, high } = self;
        let halves = [low.split_at_mut(EXPONENTS), high.split_at_mut(EXPONENTS)];
        for (k, values) in halves.into_iter().flat_map(|(a, b)| [a, b]).enumerate() {
            for (v, word) in values.iter_mut().zip(exponents) {
                *v *= power_of(word >> (8 * k) & 0xff);
            }
        }
    }

    #[inline(always)]
    pub fn add_to(&self, y: &mut [f32]) {
        let (low, high) = y.split_at_mut(words_of(y.len()));
        low.iter_mut().zip(&self.low).for_each(|(y, v)| *y += v);
        high.iter_mut().zip(&self.high).for_each(|(y, v)| *y += v);
    }

    #[inline(always)]
    pub fn add_at(&self, y: &mut [f32], places: &[u32]) {
        let (low, high) = places.split_at(words_of(places.len()));
        for (places, values) in [(low, &self.low), (high, &self.high)] {
            for (&place, v) in places.iter().zip(values) {
                y[place as usize] += v;
            }
        }
    }
}

/// Makes numbers of the halves of words.
pub trait Decode<S: Simd>: Copy {
    fn new(simd: S) -> Self;
    fn low(self, simd: S, words: S::u32s) -> S::f32s;
    fn high(self, simd: S, words: S::u32s) -> S::f32s;
}

/// Shares of their third roots.
#[derive(Clone, Copy)]
pub struct Roots<S: Simd> {
    half: S::u32s,
    mask: S::u32s,
    ones: S::u32s,
    scale: S::f32s,
    offset: S::f32s,
}

impl<S: Simd> Decode<S> for Roots<S> {
    #[inline(always)]
    fn new(simd: S) -> Roots<S> {
        Roots {
            half: simd.splat_u32s(16),
            mask: simd.splat_u32s(0xffff),
            ones: simd.splat_u32s(ONES.to_bits()),
            scale: simd.splat_f32s(SCALE),
            offset: simd.splat_f32s(OFFSET),
        }
    }

    #[inline(always)]
    fn low(self, simd: S, words: S::u32s) -> S::f32s {
        self.share(simd, simd.and_u32s(words, self.mask))
    }

    #[inline(always)]
    fn high(self, simd: S, words: S::u32s) -> S::f32s {
        self.share(simd, simd.wrapping_dyn_shr_u32s(words, self.half))
    }
}

impl<S: Simd> Roots<S> {
    /// The third power of a byte.
    #[inline(always)]
    fn byte(self, simd: S, words: S::u32s, byte: usize) -> S::f32s {
        let words = simd.wrapping_dyn_shr_u32s(words, simd.splat_u32s(8 * byte as u32));
        let bits = simd.or_u32s(simd.and_u32s(words, simd.splat_u32s(0xff)), self.ones);
        let root = simd.sub_f32s(simd.transmute_f32s_u32s(bits), simd.splat_f32s(ONES));
        simd.mul_f32s(simd.mul_f32s(root, root), root)
    }

    #[inline(always)]
    fn share(self, simd: S, half: S::u32s) -> S::f32s {
        let number = simd.transmute_f32s_u32s(simd.or_u32s(half, self.ones));
        let root = simd.mul_add_e_f32s(number, self.scale, self.offset);
        simd.mul_f32s(simd.mul_f32s(root, root), root)
    }
}

/// Whole numbers with a sign.
#[derive(Clone, Copy)]
pub struct Whole<S: Simd> {
    half: S::u32s,
    mask: S::u32s,
    ones: S::u32s,
    zero: S::f32s,
}

impl<S: Simd> Decode<S> for Whole<S> {
    #[inline(always)]
    fn new(simd: S) -> Whole<S> {
        Whole {
            half: simd.splat_u32s(16),
            mask: simd.splat_u32s(0xffff),
            ones: simd.splat_u32s(ONES.to_bits()),
            zero: simd.splat_f32s(f32::from_bits(ONES.to_bits() | ZERO)),
        }
    }

    #[inline(always)]
    fn low(self, simd: S, words: S::u32s) -> S::f32s {
        self.number(simd, simd.and_u32s(words, self.mask))
    }

    #[inline(always)]
    fn high(self, simd: S, words: S::u32s) -> S::f32s {
        self.number(simd, simd.wrapping_dyn_shr_u32s(words, self.half))
    }
}

impl<S: Simd> Whole<S> {
    #[inline(always)]
    fn number(self, simd: S, half: S::u32s) -> S::f32s {
        let bits = simd.or_u32s(half, self.ones);
        simd.sub_f32s(simd.transmute_f32s_u32s(bits), self.zero)
    }
}

/// What the columns of a strip give to one block of rows: the shares times `x`, which
/// are the columns' values times their factors.
#[inline(always)]
pub fn spread<S: Simd, D: Decode<S>>(simd: S, half: usize, words: &[u32], x: &[f32]) -> Halves {
    let mut out = Halves::zeros();
    let mut from = 0;
    while half - from > S::F32_LANES {
        spread_some::<S, D, PAIR>(simd, (half, from), words, x, &mut out);
        from += PAIR * S::F32_LANES;
        if from >= half {
            return out;
        }
    }
    spread_some::<S, D, 1>(simd, (half, from), words, x, &mut out);
    out
}

#[inline(always)]
fn spread_some<S: Simd, D: Decode<S>, const N: usize>(
    simd: S,
    (half, from): (usize, usize),
    words: &[u32],
    x: &[f32],
    out: &mut Halves,
) {
    let decoder = D::new(simd);
    let lanes = N * S::F32_LANES;
    let zero = simd.splat_f32s(0.0);
    // Of columns by turns: twice as many sums in flight.
    let mut even = ([zero; N], [zero; N]);
    let mut odd = ([zero; N], [zero; N]);
    let mut at = from;
    let pairs = x.chunks_exact(2);
    let last = pairs.remainder();
    for pair in pairs {
        step(simd, decoder, &words[at..at + lanes], pair[0], &mut even);
        at += half;
        step(simd, decoder, &words[at..at + lanes], pair[1], &mut odd);
        at += half;
    }
    for &x in last {
        step(simd, decoder, &words[at..at + lanes], x, &mut even);
    }
    let halves = [(&mut out.low, &even.0, &odd.0), (&mut out.high, &even.1, &odd.1)];
    for (out, even, odd) in halves {
        let (out, _) = S::as_mut_simd_f32s(&mut out[from..from + lanes]);
        for k in 0..N {
            out[k] = simd.add_f32s(even[k], odd[k]);
        }
    }
}

/// Adds one column's part.
#[inline(always)]
fn step<S: Simd, D: Decode<S>, const N: usize>(
    simd: S,
    decoder: D,
    words: &[u32],
    x: f32,
    (low, high): &mut ([S::f32s; N], [S::f32s; N]),
) {
    prefetch(words, AHEAD);
    let (column, _) = S::as_simd_u32s(words);
    let x = simd.splat_f32s(x);
    for k in 0..N {
        low[k] = simd.mul_add_e_f32s(decoder.low(simd, column[k]), x, low[k]);
        high[k] = simd.mul_add_e_f32s(decoder.high(simd, column[k]), x, high[k]);
    }
}

/// The columns of a full block with a head, see [`head`].
pub struct Columns<'a> {
    /// Which are short, and which are long.
    pub short: u32,
    long: u32,
    /// Bytes of the short ones' steps.
    steps: &'a [u32],
    /// The long columns' words, then the short ones'.
    words: &'a [u32],
}

impl<'a> Columns<'a> {
    #[inline(always)]
    pub fn of(words: &'a [u32], width: usize) -> Columns<'a> {
        let short = words[0];
        let (head, words) = words.split_at(head(short));
        let all = u32::MAX >> (STRIP - width);
        Columns { short, long: all & !short, steps: &head[1..], words }
    }

    /// The long columns, each with where its words start.
    #[inline(always)]
    fn long(&self) -> impl Iterator<Item = (usize, usize)> {
        Bits(self.long).zip((0..).step_by(BLOCK / 2))
    }

    /// The short columns, each with where its words start and its factor.
    #[inline(always)]
    fn short(&self) -> impl Iterator<Item = (usize, usize, f32)> {
        let start = self.long.count_ones() as usize * (BLOCK / 2);
        Bits(self.short).enumerate().map(move |(n, k)| {
            let step = step_of(self.steps[n / 4] >> (8 * (n % 4)) & 0xff);
            (k, start + n * QUARTER, step * step * step)
        })
    }

    /// Number of words, the head's among them.
    #[inline(always)]
    pub fn len(&self) -> usize {
        let (long, short) = (self.long.count_ones() as usize, self.short.count_ones() as usize);
        head(self.short) + long * (BLOCK / 2) + short * QUARTER
    }
}

/// The places of ones.
struct Bits(u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let k = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (k < STRIP).then_some(k)
    }
}

/// [`spread`] for a full block with a head, and how many words that took.
#[inline(always)]
pub fn spread_packed<S: Simd>(
    simd: S,
    words: &[u32],
    x: &[f32; STRIP],
    width: usize,
) -> (Halves, usize) {
    let columns = Columns::of(words, width);
    let decoder = Roots::<S>::new(simd);
    let lanes = PAIR * S::F32_LANES;
    let mut given = Halves::zeros();
    for from in (0..BLOCK / 2).step_by(lanes) {
        let mut sums = ([simd.splat_f32s(0.0); PAIR], [simd.splat_f32s(0.0); PAIR]);
        for (column, at) in columns.long() {
            let words = &columns.words[at + from..][..lanes];
            step(simd, decoder, words, x[column], &mut sums);
        }
        let (low, high) = &mut sums;
        for (column, at, factor) in columns.short() {
            let x = simd.splat_f32s(factor * x[column]);
            let quarters = Quarters::of(&columns.words[at..at + QUARTER], from);
            for k in 0..PAIR {
                let (lower, upper) = quarters.shares(simd, decoder, from + k * S::F32_LANES);
                low[k] = simd.mul_add_e_f32s(lower, x, low[k]);
                high[k] = simd.mul_add_e_f32s(upper, x, high[k]);
            }
        }
        for (out, sums) in [(&mut given.low, sums.0), (&mut given.high, sums.1)] {
            S::as_mut_simd_f32s(&mut out[from..from + lanes]).0.copy_from_slice(&sums);
        }
    }
    (given, columns.len())
}

/// The words of a short column.
#[derive(Clone, Copy)]
struct Quarters<'a>(&'a [u32]);

impl<'a> Quarters<'a> {
    /// Asks ahead in the first of several rounds: each has other bytes of the same words.
    #[inline(always)]
    fn of(words: &'a [u32], from: usize) -> Quarters<'a> {
        if from == 0 {
            prefetch(words, AHEAD);
        }
        Quarters(words)
    }

    /// Shares, in units of the column's factor, of a row of the lower half and those after
    /// it, and of the same of the upper half.
    #[inline(always)]
    fn shares<S: Simd>(self, simd: S, decoder: Roots<S>, row: usize) -> (S::f32s, S::f32s) {
        let (first, quarter) = (row % QUARTER, row / QUARTER);
        let words = S::as_simd_u32s(&self.0[first..first + S::F32_LANES]).0[0];
        (decoder.byte(simd, words, quarter), decoder.byte(simd, words, 2 + quarter))
    }
}

/// Adds one column's shares times the rows' values.
#[inline(always)]
fn collect<S: Simd, D: Decode<S>, const N: usize>(
    simd: S,
    decoder: D,
    words: &[u32],
    ahead: isize,
    (low, high): &([S::f32s; N], [S::f32s; N]),
    sum: &mut S::f32s,
) {
    prefetch(words, ahead);
    let (words, _) = S::as_simd_u32s(words);
    let mut other = simd.splat_f32s(0.0);
    for k in 0..N {
        *sum = simd.mul_add_e_f32s(decoder.low(simd, words[k]), low[k], *sum);
        other = simd.mul_add_e_f32s(decoder.high(simd, words[k]), high[k], other);
    }
    *sum = simd.add_f32s(*sum, other);
}

/// Sums of a strip's columns while its blocks are gone through, lane by lane.
pub struct Collected {
    lanes: [f32; STRIP * WIDEST],
}

impl Collected {
    pub const fn new() -> Collected {
        Collected { lanes: [0.0; STRIP * WIDEST] }
    }

    /// Starts with another strip.
    #[inline(always)]
    pub fn begin<S: Simd>(&mut self, width: usize) {
        self.lanes[..width * S::F32_LANES].fill(0.0);
    }

    /// Adds the shares of one block times the rows' values. Words are asked for so far
    /// `ahead`, or behind if what comes next lies there.
    #[inline(always)]
    pub fn add<S: Simd, D: Decode<S>>(
        &mut self,
        simd: S,
        width: usize,
        words: &[u32],
        ahead: isize,
        rows: usize,
        y: &Halves,
    ) {
        let half = words_of(rows);
        let mut from = 0;
        while half - from > S::F32_LANES {
            self.add_some::<S, D, PAIR>(simd, width, words, ahead, (half, from), y);
            from += PAIR * S::F32_LANES;
            if from >= half {
                break;
            }
        }
        if from < half {
            self.add_some::<S, D, 1>(simd, width, words, ahead, (half, from), y);
        }
    }

    #[inline(always)]
    fn add_some<S: Simd, D: Decode<S>, const N: usize>(
        &mut self,
        simd: S,
        width: usize,
        words: &[u32],
        ahead: isize,
        (half, from): (usize, usize),
        y: &Halves,
    ) {
        let decoder = D::new(simd);
        let lanes = N * S::F32_LANES;
        let values = y.some::<S, N>(simd, from);
        let (sums, _) = S::as_mut_simd_f32s(&mut self.lanes[..width * S::F32_LANES]);
        let mut at = from;
        for sum in sums {
            collect(simd, decoder, &words[at..at + lanes], ahead, &values, sum);
            at += half;
        }
    }

    /// [`Collected::add`] for a full block with a head; returns how many words that took.
    #[inline(always)]
    pub fn add_packed<S: Simd>(
        &mut self,
        simd: S,
        width: usize,
        words: &[u32],
        y: &Halves,
    ) -> usize {
        let columns = Columns::of(words, width);
        let decoder = Roots::<S>::new(simd);
        let lanes = PAIR * S::F32_LANES;
        let (sums, _) = S::as_mut_simd_f32s(&mut self.lanes[..width * S::F32_LANES]);
        for from in (0..BLOCK / 2).step_by(lanes) {
            let values = y.some::<S, PAIR>(simd, from);
            for (column, at) in columns.long() {
                let words = &columns.words[at + from..][..lanes];
                collect(simd, decoder, words, AHEAD, &values, &mut sums[column]);
            }
            let (low, high) = &values;
            for (column, at, factor) in columns.short() {
                let quarters = Quarters::of(&columns.words[at..at + QUARTER], from);
                let (mut one, mut other) = (simd.splat_f32s(0.0), simd.splat_f32s(0.0));
                for k in 0..PAIR {
                    let (lower, upper) = quarters.shares(simd, decoder, from + k * S::F32_LANES);
                    one = simd.mul_add_e_f32s(lower, low[k], one);
                    other = simd.mul_add_e_f32s(upper, high[k], other);
                }
                let (both, factor) = (simd.add_f32s(one, other), simd.splat_f32s(factor));
                sums[column] = simd.mul_add_e_f32s(both, factor, sums[column]);
            }
        }
        columns.len()
    }

    /// The sums.
    #[inline(always)]
    pub fn total<S: Simd>(&self, simd: S, out: &mut [f32]) {
        let (sums, _) = S::as_simd_f32s(&self.lanes[..out.len() * S::F32_LANES]);
        for (out, &sum) in out.iter_mut().zip(sums) {
            *out = simd.reduce_sum_f32s(sum);
        }
    }
}

/// The words of a full block that is a sum of products.
struct Sum<'a> {
    rank: usize,
    /// Bytes of the powers of two of rows, and of columns.
    rows: &'a [u32],
    columns: &'a [u32],
    units: &'a [u32],
    /// What the products have for the columns, and for the rows.
    right: &'a [u32],
    left: &'a [u32],
}

impl<'a> Sum<'a> {
    #[inline(always)]
    fn of(words: &'a [u32], rank: usize, width: usize) -> Sum<'a> {
        let (head, products) = words.split_at(head_words(width));
        let (rows, columns) = head[1..].split_at(EXPONENTS);
        let (units, right) = products.split_at(rank);
        let len = product_words(rank, width) - head.len() - rank * (1 + BLOCK / 2);
        Sum { rank, rows, columns, units, right, left: &right[len..] }
    }

    /// What has come together for each product, in the end.
    #[inline(always)]
    fn total<S: Simd>(&self, simd: S, collected: &Collected, out: &mut [f32; MOST]) {
        let out = &mut out[..self.rank];
        collected.total(simd, out);
        out.iter_mut().zip(self.units).for_each(|(sum, &unit)| *sum *= f32::from_bits(unit));
    }
}

/// What a panel's columns give to a full block of rows, by products: `x` are the columns'
/// values times their factors. Also returns how many words that took.
#[inline(always)]
pub fn spread_products<S: Simd>(
    simd: S,
    collected: &mut Collected,
    rank: usize,
    words: &[u32],
    x: &[f32],
) -> (Halves, usize) {
    let sum = Sum::of(words, rank, x.len());
    let mut at = 0;
    collected.begin::<S>(rank);
    for (x, exponents) in x.chunks(BLOCK).zip(sum.columns.chunks_exact(EXPONENTS)) {
        let mut values = Halves::of(x);
        values.times(exponents);
        collected.add::<S, Whole<S>>(simd, rank, &sum.right[at..], AHEAD, x.len(), &values);
        at += rank * words_of(x.len());
    }
    let mut totals = [0.0; MOST];
    sum.total(simd, collected, &mut totals);
    let mut given = spread::<S, Whole<S>>(simd, BLOCK / 2, sum.left, &totals[..rank]);
    given.times(sum.rows);
    (given, product_words(rank, x.len()))
}

/// What a panel's columns get from a full block of rows, by products; returns how many
/// words that took.
#[inline(always)]
pub fn collect_products<S: Simd>(
    simd: S,
    collected: &mut Collected,
    rank: usize,
    words: &[u32],
    mut y: Halves,
    x: &mut [f32],
) -> usize {
    let sum = Sum::of(words, rank, x.len());
    y.times(sum.rows);
    collected.begin::<S>(rank);
    collected.add::<S, Whole<S>>(simd, rank, sum.left, AHEAD, BLOCK, &y);
    let mut totals = [0.0; MOST];
    sum.total(simd, collected, &mut totals);
    let mut at = 0;
    for (x, exponents) in x.chunks_mut(BLOCK).zip(sum.columns.chunks_exact(EXPONENTS)) {
        let half = words_of(x.len());
        let mut given = spread::<S, Whole<S>>(simd, half, &sum.right[at..], &totals[..rank]);
        given.times(exponents);
        given.add_to(x);
        at += rank * half;
    }
    product_words(rank, x.len())
}

/// From the 32nd on all bits, before it none; and the other way round.
const FROM: [u32; 2 * STRIP] = window(true);
const UP_TO: [u32; 2 * STRIP] = window(false);

const fn window(from: bool) -> [u32; 2 * STRIP] {
    let mut bits = [0; 2 * STRIP];
    let mut k = 0;
    while k < 2 * STRIP {
        if (k >= STRIP) == from {
            bits[k] = u32::MAX;
        }
        k += 1;
    }
    bits
}

/// x = T x for the columns of a strip, or x = Tᵀ x.
#[inline(always)]
pub fn turn<S: Simd, const BACK: bool>(simd: S, triangle: &[f32], x: &mut [f32]) {
    let size = x.len();
    let mut out = [0.0; STRIP];
    let mut from = 0;
    while from < size {
        if size - from > S::F32_LANES {
            turn_some::<S, BACK, 2>(simd, from, triangle, x, &mut out);
        } else {
            turn_some::<S, BACK, 1>(simd, from, triangle, x, &mut out);
        }
        from += 2 * S::F32_LANES;
    }
    x.copy_from_slice(&out[..size]);
}

#[inline(always)]
fn turn_some<S: Simd, const BACK: bool, const N: usize>(
    simd: S,
    from: usize,
    triangle: &[f32],
    x: &[f32],
    out: &mut [f32; STRIP],
) {
    let lanes = N * S::F32_LANES;
    let size = x.len();
    let mut even = [simd.splat_f32s(0.0); N];
    let mut odd = even;
    let mut at = from + usize::from(!BACK);
    let mut window = from + STRIP;
    let pairs = x.chunks_exact(2);
    let last = pairs.remainder();
    for pair in pairs {
        turn_step::<S, BACK, N>(simd, &triangle[at..at + lanes], window, pair[0], &mut even);
        at += size + 1;
        window -= 1;
        turn_step::<S, BACK, N>(simd, &triangle[at..at + lanes], window, pair[1], &mut odd);
        at += size + 1;
        window -= 1;
    }
    for &x in last {
        turn_step::<S, BACK, N>(simd, &triangle[at..at + lanes], window, x, &mut even);
    }
    let (out, _) = S::as_mut_simd_f32s(&mut out[from..from + lanes]);
    for k in 0..N {
        out[k] = simd.add_f32s(even[k], odd[k]);
    }
}

/// Adds one column's part, without what is on the other side of the diagonal.
#[inline(always)]
fn turn_step<S: Simd, const BACK: bool, const N: usize>(
    simd: S,
    column: &[f32],
    window: usize,
    x: f32,
    sums: &mut [S::f32s; N],
) {
    let lanes = N * S::F32_LANES;
    prefetch(column, if BACK { -AHEAD_IN_TRIANGLES } else { AHEAD_IN_TRIANGLES });
    // Rows 0 to k on the way back, k and later ones on the way forward.
    let bits = if BACK { &UP_TO[window - 1..] } else { &FROM[window..] };
    let (bits, _) = S::as_simd_u32s(&bits[..lanes]);
    let (column, _) = S::as_simd_u32s(bytemuck::cast_slice(column));
    let x = simd.splat_f32s(x);
    for k in 0..N {
        let entries = simd.transmute_f32s_u32s(simd.and_u32s(column[k], bits[k]));
        sums[k] = simd.mul_add_e_f32s(entries, x, sums[k]);
    }
}
