//! Products with the packed factor, vector by vector, for callers that were dispatched to a
//! vector unit: blocks of rows of a pivot block's columns in 16 or 8 bits an entry, low-rank
//! blocks, and the inverse of the triangle on the diagonal.
//!
//! The factor is read from memory as it is packed and decoded in registers: what a solve takes is
//! memory traffic. Each loop asks ahead for as much as it reads.

mod decode;
mod low_rank;
pub mod mixed;
mod product;
mod triangle;

use pulp::Simd;

use super::low_rank::{EXPONENT_WORDS, power_of};
use super::packed::{BLOCK_ROWS, words as words_for};
pub use decode::CubeRoots;
pub use low_rank::{multiply_low_rank, multiply_low_rank_transposed};
pub use mixed::multiply_mixed;
pub use product::{TransposedProduct, multiply};
pub use triangle::multiply_triangle;

/// Lanes of the widest vectors.
const MAX_LANES: usize = 16;

/// Vectors of a half that are worked at together, where there are enough rows.
const UNROLLED_VECTORS: usize = 2;

/// How far ahead words are asked for: three kilobytes, which are what a thread reads while memory
/// answers. Each step asks for as much as it reads, so that few lines are on their way at a time.
pub const PREFETCH_WORDS: isize = 768;

/// The two halves of a block's rows, as the words have them.
#[derive(Clone, Copy)]
pub struct Halves {
    low: [f32; BLOCK_ROWS / 2],
    high: [f32; BLOCK_ROWS / 2],
}

impl Halves {
    #[inline(always)]
    fn zeros() -> Halves {
        Halves { low: [0.0; BLOCK_ROWS / 2], high: [0.0; BLOCK_ROWS / 2] }
    }

    /// Takes over values that lie one after the other.
    #[inline(always)]
    pub fn of(y: &[f32]) -> Halves {
        let mut halves = Halves::zeros();
        let (low, high) = y.split_at(words_for(y.len()));
        halves.low[..low.len()].copy_from_slice(low);
        halves.high[..high.len()].copy_from_slice(high);
        halves
    }

    /// Takes over values by their places.
    #[inline(always)]
    pub fn at(y: &[f32], rows: &[u32]) -> Halves {
        let mut halves = Halves::zeros();
        let (low, high) = rows.split_at(words_for(rows.len()));
        for (rows, out) in [(low, &mut halves.low), (high, &mut halves.high)] {
            for (out, &row) in out.iter_mut().zip(rows) {
                *out = y[row as usize];
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
        let halves = [low.split_at_mut(EXPONENT_WORDS), high.split_at_mut(EXPONENT_WORDS)];
        for (k, values) in halves.into_iter().flat_map(|(a, b)| [a, b]).enumerate() {
            for (v, word) in values.iter_mut().zip(exponents) {
                *v *= power_of(word >> (8 * k) & 0xff);
            }
        }
    }

    #[inline(always)]
    pub fn add_to(&self, y: &mut [f32]) {
        let (low, high) = y.split_at_mut(words_for(y.len()));
        low.iter_mut().zip(&self.low).for_each(|(y, v)| *y += v);
        high.iter_mut().zip(&self.high).for_each(|(y, v)| *y += v);
    }

    #[inline(always)]
    pub fn add_at(&self, y: &mut [f32], rows: &[u32]) {
        let (low, high) = rows.split_at(words_for(rows.len()));
        for (rows, values) in [(low, &self.low), (high, &self.high)] {
            for (&row, v) in rows.iter().zip(values) {
                y[row as usize] += v;
            }
        }
    }
}
