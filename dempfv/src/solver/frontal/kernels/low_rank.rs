//! Products with low-rank blocks.

use pulp::Simd;

use super::super::low_rank::{EXPONENT_WORDS, MAX_RANK, header_words, low_rank_words};
use super::super::packed::{BLOCK_ROWS, words as words_for};
use super::decode::Integers;
use super::product::{TransposedProduct, multiply};
use super::{Halves, PREFETCH_WORDS};

/// The words of a full block that is a sum of rank-one terms.
struct LowRankBlock<'a> {
    rank: usize,
    /// Bytes of the powers of two of rows, and of columns.
    rows: &'a [u32],
    columns: &'a [u32],
    units: &'a [u32],
    /// What the terms have for the columns, and for the rows.
    right: &'a [u32],
    left: &'a [u32],
}

impl<'a> LowRankBlock<'a> {
    #[inline(always)]
    fn of(words: &'a [u32], rank: usize, width: usize) -> LowRankBlock<'a> {
        let (header, low_rank) = words.split_at(header_words(width));
        let (rows, columns) = header[1..].split_at(EXPONENT_WORDS);
        let (units, right) = low_rank.split_at(rank);
        let len = low_rank_words(rank, width) - header.len() - rank * (1 + BLOCK_ROWS / 2);
        LowRankBlock { rank, rows, columns, units, right, left: &right[len..] }
    }

    /// What has come together for each product, in the end.
    #[inline(always)]
    fn total<S: Simd>(&self, simd: S, sums_so_far: &TransposedProduct, out: &mut [f32; MAX_RANK]) {
        let out = &mut out[..self.rank];
        sums_so_far.total(simd, out);
        out.iter_mut().zip(self.units).for_each(|(sum, &unit)| *sum *= f32::from_bits(unit));
    }
}

/// What a panel's columns give to a full block of rows, by rank-one terms: `x` are the columns'
/// values times their factors. Also returns how many words that took.
#[inline(always)]
pub fn multiply_low_rank<S: Simd>(
    simd: S,
    sums_so_far: &mut TransposedProduct,
    rank: usize,
    words: &[u32],
    x: &[f32],
) -> (Halves, usize) {
    let sum = LowRankBlock::of(words, rank, x.len());
    let mut at = 0;
    sums_so_far.begin::<S>(rank);
    for (x, exponents) in x.chunks(BLOCK_ROWS).zip(sum.columns.chunks_exact(EXPONENT_WORDS)) {
        let mut values = Halves::of(x);
        values.times(exponents);
        sums_so_far.add::<S, Integers<S>>(
            simd,
            rank,
            &sum.right[at..],
            PREFETCH_WORDS,
            x.len(),
            &values,
        );
        at += rank * words_for(x.len());
    }
    let mut totals = [0.0; MAX_RANK];
    sum.total(simd, sums_so_far, &mut totals);
    let mut given = multiply::<S, Integers<S>>(simd, BLOCK_ROWS / 2, sum.left, &totals[..rank]);
    given.times(sum.rows);
    (given, low_rank_words(rank, x.len()))
}

/// What a panel's columns get from a full block of rows, by rank-one terms; returns how many
/// words that took.
#[inline(always)]
pub fn multiply_low_rank_transposed<S: Simd>(
    simd: S,
    sums_so_far: &mut TransposedProduct,
    rank: usize,
    words: &[u32],
    mut y: Halves,
    x: &mut [f32],
) -> usize {
    let sum = LowRankBlock::of(words, rank, x.len());
    y.times(sum.rows);
    sums_so_far.begin::<S>(rank);
    sums_so_far.add::<S, Integers<S>>(simd, rank, sum.left, PREFETCH_WORDS, BLOCK_ROWS, &y);
    let mut totals = [0.0; MAX_RANK];
    sum.total(simd, sums_so_far, &mut totals);
    let mut at = 0;
    for (x, exponents) in x.chunks_mut(BLOCK_ROWS).zip(sum.columns.chunks_exact(EXPONENT_WORDS)) {
        let half = words_for(x.len());
        let mut given = multiply::<S, Integers<S>>(simd, half, &sum.right[at..], &totals[..rank]);
        given.times(exponents);
        given.add_to(x);
        at += rank * half;
    }
    low_rank_words(rank, x.len())
}
