//! Products with blocks of rows that have one format for all columns, and with their transposes.

use pulp::Simd;

use super::super::block::PIVOT_BLOCK;
use super::super::packed::words as words_for;
use super::decode::Decode;
use super::{Halves, MAX_LANES, PREFETCH_WORDS, UNROLLED_VECTORS};
use crate::parallel::prefetch;

/// What the columns of a pivot block give to one block of rows: the multipliers times `x`, which
/// are the columns' values times their factors.
#[inline(always)]
pub fn multiply<S: Simd, D: Decode<S>>(simd: S, half: usize, words: &[u32], x: &[f32]) -> Halves {
    let mut out = Halves::zeros();
    let mut from = 0;
    while half - from > S::F32_LANES {
        multiply_vectors::<S, D, UNROLLED_VECTORS>(simd, (half, from), words, x, &mut out);
        from += UNROLLED_VECTORS * S::F32_LANES;
        if from >= half {
            return out;
        }
    }
    multiply_vectors::<S, D, 1>(simd, (half, from), words, x, &mut out);
    out
}

#[inline(always)]
fn multiply_vectors<S: Simd, D: Decode<S>, const N: usize>(
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
        multiply_column(simd, decoder, &words[at..at + lanes], pair[0], &mut even);
        at += half;
        multiply_column(simd, decoder, &words[at..at + lanes], pair[1], &mut odd);
        at += half;
    }
    for &x in last {
        multiply_column(simd, decoder, &words[at..at + lanes], x, &mut even);
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
pub(super) fn multiply_column<S: Simd, D: Decode<S>, const N: usize>(
    simd: S,
    decoder: D,
    words: &[u32],
    x: f32,
    (low, high): &mut ([S::f32s; N], [S::f32s; N]),
) {
    prefetch(words, PREFETCH_WORDS);
    let (column, _) = S::as_simd_u32s(words);
    let x = simd.splat_f32s(x);
    for k in 0..N {
        low[k] = simd.mul_add_e_f32s(decoder.low(simd, column[k]), x, low[k]);
        high[k] = simd.mul_add_e_f32s(decoder.high(simd, column[k]), x, high[k]);
    }
}

/// Adds one column's multipliers times the rows' values.
#[inline(always)]
pub(super) fn multiply_column_transposed<S: Simd, D: Decode<S>, const N: usize>(
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

/// Sums of a pivot block's columns while its blocks are gone through, lane by lane.
pub struct TransposedProduct {
    pub(super) lanes: [f32; PIVOT_BLOCK * MAX_LANES],
}

impl TransposedProduct {
    pub const fn new() -> TransposedProduct {
        TransposedProduct { lanes: [0.0; PIVOT_BLOCK * MAX_LANES] }
    }

    /// Starts with another pivot block.
    #[inline(always)]
    pub fn begin<S: Simd>(&mut self, width: usize) {
        self.lanes[..width * S::F32_LANES].fill(0.0);
    }

    /// Adds the multipliers of one block times the rows' values. Words are asked for so far
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
        let half = words_for(rows);
        let mut from = 0;
        while half - from > S::F32_LANES {
            self.add_vectors::<S, D, UNROLLED_VECTORS>(simd, width, words, ahead, (half, from), y);
            from += UNROLLED_VECTORS * S::F32_LANES;
            if from >= half {
                break;
            }
        }
        if from < half {
            self.add_vectors::<S, D, 1>(simd, width, words, ahead, (half, from), y);
        }
    }

    #[inline(always)]
    fn add_vectors<S: Simd, D: Decode<S>, const N: usize>(
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
            multiply_column_transposed(simd, decoder, &words[at..at + lanes], ahead, &values, sum);
            at += half;
        }
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
