//! Blocks of low rank: a block of the factor as a sum of few rank-one terms, found by cross
//! approximation with column pivots (Bebendorf 2000).
//!
//! What unknowns give to others that are far from them depends little on which of them
//! gives: a block of such multipliers is nearly a sum of few rank-one terms of a column and a row
//! (Hackbusch 1999; Bebendorf 2000). They are found one by one: the column that has most left
//! is taken, and its part of all columns is subtracted, until what is left is small.
//! Both sides are whole numbers of 16 bits with a sign, and it is the rounded ones that are
//! subtracted: what rounding has left is left for the next.
//!
//! What is small is told from the sizes of an entry's row and column in the block. Rows and
//! columns of small multipliers must be right by themselves: they may be all that
//! joins two firmly joined pores to the rest.

use pulp::Simd;

use super::block::{BLOCK_ROWS, Block, PIVOT_BLOCK, words};
use super::shape::TILE;

/// Most rank-one terms of a block.
pub const MAX_RANK: usize = PIVOT_BLOCK;

/// What is left of a block's entries, at most: the root of the mean of their squares, each
/// relative to the sizes of its row and its column. With twice as much a correction leaves so
/// much more that a third is needed.
const TRUNCATION_ERROR: f32 = 1e-5;

/// The size of a row or column is the power of two below the cube root of its length: the
/// larger ones need digits most, as cube roots of single multipliers give them.
fn exponent_of(square: f32) -> u32 {
    if square > NEGLIGIBLE_SQUARE { square.cbrt().sqrt().to_bits() >> 23 } else { 0 }
}

/// Rows and columns whose squares sum up to less are none.
const NEGLIGIBLE_SQUARE: f32 = 1e-30;

/// Where a number of 16 bits is zero, and the largest one.
pub const CODE_OF_ZERO: u32 = 1 << 15;
const LARGEST_INTEGER: f32 = 32767.0;

/// Words of bytes for 64 rows or columns, of the powers of two that their sizes are. Those
/// of rows k, k + 16 and so on are in one word.
pub const EXPONENT_WORDS: usize = BLOCK_ROWS / 4;

/// The power of two by its byte: the exponent of a number in single precision, zero for
/// zero.
#[inline(always)]
pub fn power_of(byte: u32) -> f32 {
    f32::from_bits(byte << 23)
}

/// First word of a block of so many terms: zero says that a block has its multipliers one by
/// one.
fn rank_word(rank: usize) -> u32 {
    rank as u32 + 1
}

/// Number of terms by a block's first word; none if it has its multipliers one by one.
#[inline(always)]
pub fn rank_of(word: u32) -> Option<usize> {
    (word as usize).checked_sub(1)
}

/// Words before the terms of a panel of this width: their number, bytes for rows, bytes
/// for columns.
#[inline(always)]
pub fn header_words(width: usize) -> usize {
    1 + EXPONENT_WORDS * (1 + width.div_ceil(BLOCK_ROWS))
}

/// Words of so many terms for a panel of this width, with their header. Each has a unit; then
/// come what they have for the columns, those of 64 columns after those of the 64 before,
/// then what they have for the rows.
pub fn low_rank_words(rank: usize, width: usize) -> usize {
    let right = width / BLOCK_ROWS * (BLOCK_ROWS / 2) + words(width % BLOCK_ROWS);
    header_words(width) + rank * (1 + right + BLOCK_ROWS / 2)
}

/// A block's terms, and memory to find them.
pub struct LowRank {
    rank: usize,
    width: usize,
    /// Bytes of the sizes of rows and columns.
    rows: [u32; BLOCK_ROWS],
    columns: [u32; TILE],
    /// What is left of each column, relative to these sizes.
    remainder: Vec<f32>,
    /// Whole numbers for the rows and for the columns, and the unit of their product.
    left: Vec<f32>,
    right: Vec<f32>,
    units: [f32; MAX_RANK],
}

impl LowRank {
    pub fn new() -> LowRank {
        LowRank {
            rank: 0,
            width: 0,
            rows: [0; BLOCK_ROWS],
            columns: [0; TILE],
            remainder: vec![0.0; BLOCK_ROWS * TILE],
            left: vec![0.0; BLOCK_ROWS * MAX_RANK],
            right: vec![0.0; TILE * MAX_RANK],
            units: [0.0; MAX_RANK],
        }
    }

    /// Finds the terms for a full block, whose entries times the columns' scales are its
    /// multipliers with their signs turned; false if there would be more than so many.
    #[inline(always)]
    pub fn compress<S: Simd>(
        &mut self,
        simd: S,
        block: Block<'_>,
        scales: &[f32],
        most: usize,
    ) -> bool {
        let width = scales.len();
        (self.rank, self.width) = (0, width);
        let remainder = &mut self.remainder.as_chunks_mut::<BLOCK_ROWS>().0[..width];
        let mut of_rows = [0.0f32; BLOCK_ROWS];
        let mut weights = [0.0f32; TILE];
        for (k, (column, &scale)) in remainder.iter_mut().zip(scales).enumerate() {
            let mut squares = [0.0f32; 16];
            let entries = block.data[k * block.stride..][..BLOCK_ROWS].as_chunks::<16>().0;
            let parts = column.as_chunks_mut::<16>().0.iter_mut();
            for ((to, from), of_rows) in parts.zip(entries).zip(of_rows.as_chunks_mut::<16>().0) {
                for (((to, &v), square), of_row) in
                    to.iter_mut().zip(from).zip(&mut squares).zip(of_rows)
                {
                    *to = -v * scale;
                    *square += *to * *to;
                    *of_row += *to * *to;
                }
            }
            let byte = exponent_of(squares.iter().sum());
            self.columns[k] = byte;
            weights[k] = weight_of(byte);
        }
        let mut of_row = [0.0f32; BLOCK_ROWS];
        for ((weight, byte), &square) in of_row.iter_mut().zip(&mut self.rows).zip(&of_rows) {
            *byte = exponent_of(square);
            *weight = weight_of(*byte);
        }
        let mut norms = [0.0f32; TILE];
        for ((column, &weight), norm) in remainder.iter_mut().zip(&weights).zip(&mut norms) {
            *norm = scale(simd, weight, &of_row, column);
        }
        let enough = TRUNCATION_ERROR * TRUNCATION_ERROR * (BLOCK_ROWS * width) as f32;
        loop {
            let mut pivot = (0, 0.0);
            for (k, &norm) in norms[..width].iter().enumerate() {
                if norm > pivot.1 {
                    pivot = (k, norm);
                }
            }
            if norms[..width].iter().sum::<f32>() <= enough {
                return true;
            }
            if self.rank == most.min(MAX_RANK) {
                return false;
            }
            let left = &mut self.left.as_chunks_mut::<BLOCK_ROWS>().0[self.rank];
            let right = &mut self.right[self.rank * TILE..][..width];
            left.copy_from_slice(&remainder[pivot.0]);
            round_to_integers(left);
            let square: f32 = left.iter().map(|v| v * v).sum();
            for (right, column) in right.iter_mut().zip(&*remainder) {
                *right = product(simd, left, column) / square;
            }
            let unit = round_to_integers(right);
            for ((column, &right), norm) in remainder.iter_mut().zip(&*right).zip(&mut norms) {
                *norm = subtract(simd, left, unit * right, column);
            }
            self.units[self.rank] = unit;
            self.rank += 1;
        }
    }

    /// Writes the terms where the block's words start, and adds up what they keep of each
    /// column; returns how many words that took.
    #[inline(always)]
    pub fn write(&self, out: &mut [u32], kept: &mut [f64]) -> usize {
        let (rank, width) = (self.rank, self.width);
        let len = low_rank_words(rank, width);
        let out = &mut out[..len];
        out[0] = rank_word(rank);
        let (header, out) = out.split_at_mut(header_words(width));
        let mut bytes = header[1..].chunks_exact_mut(EXPONENT_WORDS);
        for of in std::iter::once(&self.rows[..]).chain(self.columns[..width].chunks(BLOCK_ROWS)) {
            bytes.next().into_iter().for_each(|out| put_bytes(of, out));
        }
        let (units, mut out) = out.split_at_mut(rank);
        for (out, unit) in units.iter_mut().zip(&self.units) {
            *out = unit.to_bits();
        }
        let mut put = |numbers: &[f32]| {
            let (this, after) = std::mem::take(&mut out).split_at_mut(words(numbers.len()));
            put_integers(numbers, this);
            out = after;
        };
        let lefts = self.left.chunks_exact(BLOCK_ROWS).take(rank);
        let rights = self.right.chunks_exact(TILE).take(rank);
        for from in (0..width).step_by(BLOCK_ROWS) {
            rights.clone().for_each(|right| put(&right[from..width.min(from + BLOCK_ROWS)]));
        }
        lefts.clone().for_each(put);
        for ((left, right), &unit) in lefts.zip(rights).zip(&self.units) {
            let parts = left.iter().zip(&self.rows).map(|(v, &byte)| v * power_of(byte));
            let sum = parts.map(f64::from).sum::<f64>() * f64::from(unit);
            for ((kept, &v), &byte) in kept.iter_mut().zip(right).zip(&self.columns) {
                *kept += sum * f64::from(v * power_of(byte));
            }
        }
        len
    }
}

/// One over the power of two by its byte; zero for zero.
#[inline(always)]
fn weight_of(byte: u32) -> f32 {
    if byte > 0 { 1.0 / power_of(byte) } else { 0.0 }
}

/// Makes whole numbers of numbers; returns their unit.
#[inline(always)]
fn round_to_integers(numbers: &mut [f32]) -> f32 {
    let most = numbers.iter().fold(0.0f32, |most, v| if v.abs() > most { v.abs() } else { most });
    let to_unit = if most > 0.0 { LARGEST_INTEGER / most } else { 0.0 };
    numbers.iter_mut().for_each(|v| *v = (*v * to_unit).round_ties_even());
    most / LARGEST_INTEGER
}

/// Puts whole numbers into the halves of words.
#[inline(always)]
fn put_integers(numbers: &[f32], out: &mut [u32]) {
    let code = |v: f32| (v as i32 + CODE_OF_ZERO as i32) as u32;
    let (low, high) = numbers.split_at(out.len());
    out.iter_mut().zip(low).for_each(|(word, &v)| *word = code(v));
    out.iter_mut().zip(high).for_each(|(word, &v)| *word |= code(v) << 16);
}

/// Puts bytes of up to 64 rows where [`super::kernels::Halves::times`] finds them.
#[inline(always)]
fn put_bytes(bytes: &[u32], out: &mut [u32]) {
    out.fill(0);
    let (low, high) = bytes.split_at(words(bytes.len()));
    for (half, bytes) in [low, high].into_iter().enumerate() {
        for (k, byte) in bytes.iter().enumerate() {
            out[k % EXPONENT_WORDS] |= byte << (16 * half + 8 * (k / EXPONENT_WORDS));
        }
    }
}

/// A column's entries times their weights; returns the sum of its squares.
#[inline(always)]
fn scale<S: Simd>(simd: S, weight: f32, of_row: &[f32], column: &mut [f32]) -> f32 {
    let weight = simd.splat_f32s(weight);
    let mut norm = simd.splat_f32s(0.0);
    for (v, &of_row) in S::as_mut_simd_f32s(column).0.iter_mut().zip(S::as_simd_f32s(of_row).0) {
        *v = simd.mul_f32s(*v, simd.mul_f32s(weight, of_row));
        norm = simd.mul_add_e_f32s(*v, *v, norm);
    }
    simd.reduce_sum_f32s(norm)
}

#[inline(always)]
fn product<S: Simd>(simd: S, a: &[f32], b: &[f32]) -> f32 {
    let mut sum = simd.splat_f32s(0.0);
    for (&a, &b) in S::as_simd_f32s(a).0.iter().zip(S::as_simd_f32s(b).0) {
        sum = simd.mul_add_e_f32s(a, b, sum);
    }
    simd.reduce_sum_f32s(sum)
}

/// Subtracts a part of a vector from a column; returns the sum of squares of what is left.
#[inline(always)]
fn subtract<S: Simd>(simd: S, left: &[f32], part: f32, column: &mut [f32]) -> f32 {
    let part = simd.splat_f32s(part);
    let mut norm = simd.splat_f32s(0.0);
    for (v, &left) in S::as_mut_simd_f32s(column).0.iter_mut().zip(S::as_simd_f32s(left).0) {
        *v = simd.negate_mul_add_e_f32s(left, part, *v);
        norm = simd.mul_add_e_f32s(*v, *v, norm);
    }
    simd.reduce_sum_f32s(norm)
}

#[cfg(test)]
mod tests {
    use super::super::kernels::{
        Halves, TransposedProduct, multiply_low_rank, multiply_low_rank_transposed,
    };
    use super::*;

    fn number(k: usize) -> f64 {
        ((k * 7919 + 13) % 101) as f64 / 101.0
    }

    /// Multipliers that fall with the square of a distance, in rows that differ by six decades and
    /// columns that differ by three, by columns and with the sign that the factor's entries have.
    fn far(width: usize) -> Vec<f32> {
        let share = |row: usize, column: usize| {
            let distance = 4.0 + (row + column) as f64 / 16.0;
            let decades = 6.0 * number(row) + 3.0 * number(7 * column + 3);
            distance.powi(-2) * 10f64.powf(-decades)
        };
        (0..width * BLOCK_ROWS).map(|k| -share(k % BLOCK_ROWS, k / BLOCK_ROWS) as f32).collect()
    }

    /// Finds and writes terms, then gives each column's multiplier to the rows, and each row's
    /// to the columns.
    struct Through<'a> {
        entries: &'a [f32],
        width: usize,
    }

    /// Number of terms, words, what was kept, and the multipliers both ways.
    type Found = (usize, Vec<u32>, Vec<f64>, Vec<f32>, Vec<f32>);

    impl pulp::WithSimd for Through<'_> {
        type Output = Option<Found>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Option<Found> {
            let Through { entries, width } = self;
            let mut low_rank = LowRank::new();
            let block = Block::packed(entries, BLOCK_ROWS);
            if !low_rank.compress(simd, block, &vec![1.0; width], MAX_RANK) {
                return None;
            }
            // What comes after the words must not matter.
            let mut words = vec![0x7fff_7fff; low_rank_words(low_rank.rank, width) + BLOCK_ROWS];
            let mut kept = vec![0.0; width];
            let len = low_rank.write(&mut words, &mut kept);
            let rank = rank_of(words[0])?;
            let mut sums_so_far = TransposedProduct::new();
            let mut down = vec![0.0; width * BLOCK_ROWS];
            for (column, down) in down.chunks_exact_mut(BLOCK_ROWS).enumerate() {
                let mut x = vec![0.0; width];
                x[column] = 1.0;
                let (given, taken) = multiply_low_rank(simd, &mut sums_so_far, rank, &words, &x);
                assert_eq!(taken, len);
                given.add_to(down);
            }
            let mut back = vec![0.0; width * BLOCK_ROWS];
            for row in 0..BLOCK_ROWS {
                let mut y = [0.0; BLOCK_ROWS];
                y[row] = 1.0;
                let mut x = vec![0.0; width];
                let y = Halves::of(&y);
                let taken =
                    multiply_low_rank_transposed(simd, &mut sums_so_far, rank, &words, y, &mut x);
                assert_eq!(taken, len);
                x.iter().enumerate().for_each(|(column, v)| back[column * BLOCK_ROWS + row] = *v);
            }
            Some((rank, words, kept, down, back))
        }
    }

    /// Far multipliers are few rank-one terms, and each is right by the sizes of its row and column, in
    /// both ways and by vectors of all lengths: 1e-5 of them in the mean, 20 times that at most.
    #[test]
    fn far_blocks_have_a_low_rank() {
        for width in [33, 64, 100, 255, 256] {
            let entries = far(width);
            let through = || Through { entries: &entries, width };
            let row = |i: usize| (0..width).map(move |j| j * BLOCK_ROWS + i);
            let column = |j: usize| (0..BLOCK_ROWS).map(move |i| j * BLOCK_ROWS + i);
            let length = |sum: f64| sum.sqrt().cbrt();
            let square = |k: usize| f64::from(entries[k]).powi(2);
            let rows: Vec<f64> =
                (0..BLOCK_ROWS).map(|i| length(row(i).map(square).sum())).collect();
            let columns: Vec<f64> =
                (0..width).map(|j| length(column(j).map(square).sum())).collect();
            for found in [
                pulp::Arch::new().dispatch(through()),
                pulp::WithSimd::with_simd(through(), pulp::Scalar512b),
                pulp::WithSimd::with_simd(through(), pulp::Scalar256b),
                pulp::WithSimd::with_simd(through(), pulp::Scalar128b),
                pulp::WithSimd::with_simd(through(), pulp::Scalar),
            ] {
                let (rank, _, kept, down, back) = found.expect("few rank-one terms are enough");
                assert!(rank <= 8, "{width}: {rank}");
                let mut squares = 0.0;
                for (k, &entry) in entries.iter().enumerate() {
                    let size = rows[k % BLOCK_ROWS] * columns[k / BLOCK_ROWS];
                    let error = f64::from(down[k] + entry).abs();
                    assert!(error <= 2e-4 * size, "{width} {k}: {error:e} {size:e}");
                    assert!(f64::from(back[k] - down[k]).abs() <= 1e-6 * size, "{width} {k}");
                    squares += (error / size).powi(2);
                }
                let mean = (squares / entries.len() as f64).sqrt();
                assert!(mean <= 1.1 * f64::from(TRUNCATION_ERROR), "{width}: {mean:e}");
                for (j, kept) in kept.iter().enumerate() {
                    let sum: f64 = column(j).map(|k| f64::from(down[k])).sum();
                    let bound = 1e-6 * columns[j].powi(3);
                    assert!((kept - sum).abs() <= bound, "{width} {j}: {kept} {sum}");
                }
            }
        }
    }

    /// Numbers without order are no sum of few rank-one terms, and zeros are one of none.
    #[test]
    fn other_blocks() {
        let width = 100;
        let mixed = |k: usize| -(number(k * k % 99_991) as f32);
        let entries: Vec<f32> = (0..width * BLOCK_ROWS).map(mixed).collect();
        assert!(pulp::Arch::new().dispatch(Through { entries: &entries, width }).is_none());
        let entries = vec![0.0; width * BLOCK_ROWS];
        let found = pulp::Arch::new().dispatch(Through { entries: &entries, width });
        let (rank, _, kept, down, back) = found.expect("zeros are enough");
        assert_eq!(rank, 0);
        assert!(kept.iter().all(|&v| v == 0.0));
        assert!(down.iter().chain(&back).all(|&v| v == 0.0));
    }
}
