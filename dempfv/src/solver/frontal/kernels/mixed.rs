//! Products with full blocks whose columns have 8 or 16 bits an entry, each as its header says.

use pulp::Simd;

use super::super::block::PIVOT_BLOCK;
use super::super::packed::{BLOCK_ROWS, EIGHT_BIT_COLUMN_WORDS, header, step_of};
use super::decode::{CubeRoots, Decode};
use super::product::{TransposedProduct, multiply_column, multiply_column_transposed};
use super::{Halves, PREFETCH_WORDS, UNROLLED_VECTORS};
use crate::parallel::prefetch;

/// The columns of a full block with a header, see [`header`].
pub struct MixedColumns<'a> {
    /// Which are 8-bit, and which are 16-bit.
    pub eight_bit: u32,
    sixteen_bit: u32,
    /// Bytes of the 8-bit ones' steps.
    steps: &'a [u32],
    /// The 16-bit columns' words, then the 8-bit ones'.
    words: &'a [u32],
}

impl<'a> MixedColumns<'a> {
    #[inline(always)]
    pub fn of(words: &'a [u32], width: usize) -> MixedColumns<'a> {
        let eight_bit = words[0];
        let (header, words) = words.split_at(header(eight_bit));
        let all = u32::MAX >> (PIVOT_BLOCK - width);
        MixedColumns { eight_bit, sixteen_bit: all & !eight_bit, steps: &header[1..], words }
    }

    /// The 16-bit columns, each with where its words start.
    #[inline(always)]
    fn sixteen_bit(&self) -> impl Iterator<Item = (usize, usize)> {
        SetBits(self.sixteen_bit).zip((0..).step_by(BLOCK_ROWS / 2))
    }

    /// The 8-bit columns, each with where its words start and its factor.
    #[inline(always)]
    fn eight_bit(&self) -> impl Iterator<Item = (usize, usize, f32)> {
        let start = self.sixteen_bit.count_ones() as usize * (BLOCK_ROWS / 2);
        SetBits(self.eight_bit).enumerate().map(move |(n, k)| {
            let step = step_of(self.steps[n / 4] >> (8 * (n % 4)) & 0xff);
            (k, start + n * EIGHT_BIT_COLUMN_WORDS, step * step * step)
        })
    }

    /// Number of words, the header's among them.
    #[inline(always)]
    pub fn len(&self) -> usize {
        let (sixteen_bit, eight_bit) =
            (self.sixteen_bit.count_ones() as usize, self.eight_bit.count_ones() as usize);
        header(self.eight_bit) + sixteen_bit * (BLOCK_ROWS / 2) + eight_bit * EIGHT_BIT_COLUMN_WORDS
    }
}

/// The places of ones.
struct SetBits(u32);

impl Iterator for SetBits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let k = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (k < PIVOT_BLOCK).then_some(k)
    }
}

/// [`multiply`] for a full block with a header, and how many words that took.
#[inline(always)]
pub fn multiply_mixed<S: Simd>(
    simd: S,
    words: &[u32],
    x: &[f32; PIVOT_BLOCK],
    width: usize,
) -> (Halves, usize) {
    let columns = MixedColumns::of(words, width);
    let decoder = CubeRoots::<S>::new(simd);
    let lanes = UNROLLED_VECTORS * S::F32_LANES;
    let mut given = Halves::zeros();
    for from in (0..BLOCK_ROWS / 2).step_by(lanes) {
        let mut sums =
            ([simd.splat_f32s(0.0); UNROLLED_VECTORS], [simd.splat_f32s(0.0); UNROLLED_VECTORS]);
        for (column, at) in columns.sixteen_bit() {
            let words = &columns.words[at + from..][..lanes];
            multiply_column(simd, decoder, words, x[column], &mut sums);
        }
        let (low, high) = &mut sums;
        for (column, at, factor) in columns.eight_bit() {
            let x = simd.splat_f32s(factor * x[column]);
            let quarters =
                EightBitColumn::of(&columns.words[at..at + EIGHT_BIT_COLUMN_WORDS], from);
            for k in 0..UNROLLED_VECTORS {
                let (lower, upper) = quarters.multipliers(simd, decoder, from + k * S::F32_LANES);
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

/// The words of a 8-bit column.
#[derive(Clone, Copy)]
struct EightBitColumn<'a>(&'a [u32]);

impl<'a> EightBitColumn<'a> {
    /// Asks ahead in the first of several rounds: each has other bytes of the same words.
    #[inline(always)]
    fn of(words: &'a [u32], from: usize) -> EightBitColumn<'a> {
        if from == 0 {
            prefetch(words, PREFETCH_WORDS);
        }
        EightBitColumn(words)
    }

    /// Multipliers, in units of the column's factor, of a row of the lower half and those after
    /// it, and of the same of the upper half.
    #[inline(always)]
    fn multipliers<S: Simd>(
        self,
        simd: S,
        decoder: CubeRoots<S>,
        row: usize,
    ) -> (S::f32s, S::f32s) {
        let (first, quarter) = (row % EIGHT_BIT_COLUMN_WORDS, row / EIGHT_BIT_COLUMN_WORDS);
        let words = S::as_simd_u32s(&self.0[first..first + S::F32_LANES]).0[0];
        (decoder.byte(simd, words, quarter), decoder.byte(simd, words, 2 + quarter))
    }
}

impl TransposedProduct {
    /// [`TransposedProduct::add`] for a full block with a header; returns how many words that took.
    #[inline(always)]
    pub fn add_mixed<S: Simd>(
        &mut self,
        simd: S,
        width: usize,
        words: &[u32],
        y: &Halves,
    ) -> usize {
        let columns = MixedColumns::of(words, width);
        let decoder = CubeRoots::<S>::new(simd);
        let lanes = UNROLLED_VECTORS * S::F32_LANES;
        let (sums, _) = S::as_mut_simd_f32s(&mut self.lanes[..width * S::F32_LANES]);
        for from in (0..BLOCK_ROWS / 2).step_by(lanes) {
            let values = y.some::<S, UNROLLED_VECTORS>(simd, from);
            for (column, at) in columns.sixteen_bit() {
                let words = &columns.words[at + from..][..lanes];
                multiply_column_transposed(
                    simd,
                    decoder,
                    words,
                    PREFETCH_WORDS,
                    &values,
                    &mut sums[column],
                );
            }
            let (low, high) = &values;
            for (column, at, factor) in columns.eight_bit() {
                let quarters =
                    EightBitColumn::of(&columns.words[at..at + EIGHT_BIT_COLUMN_WORDS], from);
                let (mut one, mut other) = (simd.splat_f32s(0.0), simd.splat_f32s(0.0));
                for k in 0..UNROLLED_VECTORS {
                    let (lower, upper) =
                        quarters.multipliers(simd, decoder, from + k * S::F32_LANES);
                    one = simd.mul_add_e_f32s(lower, low[k], one);
                    other = simd.mul_add_e_f32s(upper, high[k], other);
                }
                let (both, factor) = (simd.add_f32s(one, other), simd.splat_f32s(factor));
                sums[column] = simd.mul_add_e_f32s(both, factor, sums[column]);
            }
        }
        columns.len()
    }
}
