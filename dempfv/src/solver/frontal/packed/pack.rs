//! Takes a factored front over into its packed form, and measures each column so that nothing of
//! its sum is lost.

use rayon::prelude::*;

use super::super::block::{Block, PIVOT_BLOCK};
use super::super::low_rank::{LowRank, header_words, low_rank_words};
use super::super::shape::{Rows, Shape, TILE};
use super::quantize::{
    EIGHT_BIT_LIMIT, ROOT_LEVELS, SCALED_MAX, decode, encode, step_for, step_of,
};
use super::{
    BLOCK_ROWS, EIGHT_BIT_COLUMN_WORDS, FactorSlices, Panel, PivotBlock, header, panels,
    words as words_for,
};

/// Products take the place of a block where they have no more than this part of its words.
const LOW_RANK_WORDS_RATIO: f32 = 0.85;

/// Takes over a factored front, in which the triangles of pivot blocks on the diagonal are
/// inverted. Blocks may become low-rank sums where that is allowed.
pub fn pack(shape: Shape, l: &[f32], low_rank: bool, part: FactorSlices<'_>, parallel: bool) {
    let mut rest = part;
    let mut work = vec![];
    for (k, panel) in panels(shape).enumerate() {
        let (this, after) = rest.split(panel.words(), panel.triangles(), panel.width);
        work.push((k, panel, this));
        rest = after;
    }
    let one = |(k, panel, part)| pack_panel(shape, k, panel, l, low_rank, part);
    if parallel && work.len() > 1 {
        work.into_par_iter().for_each(one);
    } else {
        work.into_iter().for_each(one);
    }
}

fn pack_panel(
    shape: Shape,
    k: usize,
    panel: Panel,
    l: &[f32],
    low_rank: bool,
    part: FactorSlices<'_>,
) {
    let start = shape.panel_start(k);
    let w = panel.width;
    let diagonal = &l[start..start + w * w];
    let FactorSlices { words, triangles, factors, .. } = part;
    let mut columns = ColumnScaling::default();
    let (mut diagonal_words, mut triangle) = (0, 0);
    for pivot_block in panel.pivot_blocks() {
        let (from, size) = (pivot_block.first, pivot_block.width);
        let end = from + size;
        let both = &mut triangles[triangle..triangle + pivot_block.triangle()];
        for (j, both) in both.chunks_exact_mut(size + 1).enumerate() {
            let (row, column) = both.split_at_mut(j + 1);
            column.copy_from_slice(&diagonal[(from + j) * w + from..][j..size]);
            for (i, x) in row.iter_mut().enumerate() {
                *x = diagonal[(from + i) * w + from + j];
            }
        }
        triangle += pivot_block.triangle();

        // The pivot block's multipliers, run of rows by run of rows.
        let tile = |rows: Rows| {
            let at = start + shape.tile_start(k, rows.start) + from * rows.len;
            Block { data: &l[at..], rows: rows.len, stride: rows.len }
        };
        let below = Block { data: &diagonal[from * w..], rows: w, stride: w }.below(end);
        let mut sums = ColumnSums::default();
        for block in std::iter::once(below).chain(shape.below(k).map(tile)) {
            pulp::Arch::new().dispatch(SumColumns { block, size, sums: &mut sums });
        }
        columns.scales[from..end].copy_from_slice(&sums.scales()[..size]);
        columns.total[from..end].copy_from_slice(&sums.total[..size]);
        let here = panel.diagonal_words(pivot_block);
        let words = &mut words[diagonal_words..diagonal_words + here];
        pulp::Arch::new().dispatch(PackPivotBlock {
            pivot_block,
            block: below,
            words,
            columns: &mut columns,
        });
        diagonal_words += here;
    }

    // Then what is below, block by block.
    let mut low_rank = (panel.mixed && low_rank).then(LowRank::new);
    let mut tiles = shape.below(k);
    for chunk in 0..panel.chunks() {
        let (rows, mut at) = panel.chunk(chunk);
        for rows in tiles.by_ref().take(rows.len().div_ceil(TILE)) {
            let tile = &l[start + shape.tile_start(k, rows.start)..];
            for from in (0..rows.len).step_by(BLOCK_ROWS) {
                let len = BLOCK_ROWS.min(rows.len - from);
                let block = Block { data: &tile[from..], rows: len, stride: rows.len };
                let mixed = panel.mixed && len == BLOCK_ROWS;
                let low_rank = low_rank.as_mut().filter(|_| mixed);
                let words = &mut words[at..];
                let columns = &mut columns;
                at += pulp::Arch::new().dispatch(PackBlock {
                    panel,
                    block,
                    mixed,
                    words,
                    columns,
                    low_rank,
                });
            }
        }
    }
    for (j, factor) in factors[..w].iter_mut().enumerate() {
        let (total, kept) = (columns.total[j], columns.kept[j]);
        *factor = if kept > 0.0 { (total / kept) as f32 } else { 0.0 };
    }
}

/// What the columns of a panel are kept with.
struct ColumnScaling {
    /// What makes multipliers of their entries.
    scales: [f32; TILE],
    /// Sums of their entries, and of the multipliers that are kept.
    total: [f64; TILE],
    kept: [f64; TILE],
}

impl Default for ColumnScaling {
    fn default() -> ColumnScaling {
        ColumnScaling { scales: [0.0; TILE], total: [0.0; TILE], kept: [0.0; TILE] }
    }
}

/// Largest multipliers and sums of a pivot block's columns.
#[derive(Default)]
struct ColumnSums {
    largest: [f32; PIVOT_BLOCK],
    total: [f64; PIVOT_BLOCK],
}

impl ColumnSums {
    /// What brings each column's largest multiplier to [`SCALED_MAX`].
    fn scales(&self) -> [f32; PIVOT_BLOCK] {
        let mut scales = [0.0; PIVOT_BLOCK];
        for (scale, &largest) in scales.iter_mut().zip(&self.largest) {
            // A column so small that nothing of it would be left has no multipliers.
            *scale = if largest > f32::MIN_POSITIVE { SCALED_MAX / largest } else { 0.0 };
        }
        scales
    }
}

struct SumColumns<'a> {
    block: Block<'a>,
    size: usize,
    sums: &'a mut ColumnSums,
}

impl pulp::NullaryFnOnce for SumColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SumColumns { block, size, sums } = self;
        let ColumnSums { largest, total } = sums;
        for (k, (largest, total)) in largest.iter_mut().zip(total).enumerate().take(size) {
            let mut most = [0.0f32; 16];
            let mut sum = [0.0f64; 16];
            let column = &block.data[k * block.stride..][..block.rows];
            let chunks = column.chunks_exact(16);
            for (k, &v) in chunks.remainder().iter().enumerate() {
                most[k] = -v;
                sum[k] = f64::from(v);
            }
            for chunk in chunks {
                for ((most, sum), &v) in most.iter_mut().zip(&mut sum).zip(chunk) {
                    *most = if -v > *most { -v } else { *most };
                    *sum += f64::from(v);
                }
            }
            *largest = most.iter().fold(*largest, |m, &v| m.max(v));
            *total -= sum.iter().sum::<f64>();
        }
    }
}

/// Puts a pivot block's later rows of its panel into words, and sums up what was kept.
struct PackPivotBlock<'a> {
    pivot_block: PivotBlock,
    block: Block<'a>,
    words: &'a mut [u32],
    columns: &'a mut ColumnScaling,
}

impl pulp::NullaryFnOnce for PackPivotBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let PackPivotBlock { pivot_block, block, words, columns } = self;
        let mut at = 0;
        for from in (0..block.rows).step_by(BLOCK_ROWS) {
            let len = BLOCK_ROWS.min(block.rows - from);
            let rows = Block { data: &block.data[from..], rows: len, ..block };
            at += pack_columns(rows, pivot_block, false, &mut words[at..], columns);
        }
    }
}

/// The same for up to 64 rows below a panel, and all its columns. A packed block says which of
/// its columns are 8-bit, or is a sum of rank-one terms if there is memory to find these.
struct PackBlock<'a> {
    panel: Panel,
    block: Block<'a>,
    mixed: bool,
    words: &'a mut [u32],
    columns: &'a mut ColumnScaling,
    low_rank: Option<&'a mut LowRank>,
}

impl pulp::WithSimd for PackBlock<'_> {
    /// How many words that took.
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> usize {
        let PackBlock { panel, block, mixed, words, columns, low_rank } = self;
        let mut at = 0;
        if let Some(low_rank) = low_rank {
            let scales = &columns.scales[..panel.width];
            let column = |k: usize| &block.data[k * block.stride..][..BLOCK_ROWS];
            let is_eight_bit =
                |(k, scale): (usize, &f32)| largest_of(column(k)) * scale <= EIGHT_BIT_LIMIT;
            let eight_bit =
                scales.iter().enumerate().filter(|&column| is_eight_bit(column)).count();
            let plain_words = panel.width * (BLOCK_ROWS / 2) - eight_bit * EIGHT_BIT_COLUMN_WORDS;
            let width = panel.width;
            let header = header_words(width);
            let each = low_rank_words(1, width) - header;
            let most = ((plain_words as f32 * LOW_RANK_WORDS_RATIO) as usize)
                .saturating_sub(header)
                / each;
            if low_rank.compress(simd, block, scales, most) {
                return low_rank.write(words, &mut columns.kept[..width]);
            }
        }
        if mixed {
            words[0] = 0;
            at = 1;
        }
        for pivot_block in panel.pivot_blocks() {
            let rows = Block { data: &block.data[pivot_block.first * block.stride..], ..block };
            at += pack_columns(rows, pivot_block, mixed, &mut words[at..], columns);
        }
        at
    }
}

/// Puts up to 64 rows of a pivot block into words, with a header or without; returns how many
/// words that took.
#[inline(always)]
fn pack_columns(
    block: Block<'_>,
    pivot_block: PivotBlock,
    mixed: bool,
    words: &mut [u32],
    columns: &mut ColumnScaling,
) -> usize {
    let scales = &columns.scales[pivot_block.first..pivot_block.first + pivot_block.width];
    let kept = &mut columns.kept[pivot_block.first..pivot_block.first + pivot_block.width];
    let column = |k: usize| &block.data[k * block.stride..][..block.rows];
    let mut at = 0;
    let eight_bit = match mixed {
        true => {
            let largest = |(k, scale): (usize, &f32)| largest_of(column(k)) * scale;
            let eight_bit = EightBitColumns::of(scales.iter().enumerate().map(largest));
            at += eight_bit.write(words);
            eight_bit
        }
        false => EightBitColumns::default(),
    };
    let half = words_for(block.rows);
    let is_eight_bit = |k: usize| eight_bit.mask >> k & 1 == 1;
    for k in (0..scales.len()).filter(|&k| !is_eight_bit(k)) {
        let (codes, sum) = encode_column(column(k), scales[k], 1.0);
        kept[k] += sum;
        let (low, high) = codes.split_at(half);
        for ((word, &low), &high) in words[at..at + half].iter_mut().zip(low).zip(high) {
            *word = low | high << 16;
        }
        at += half;
    }
    for (k, &byte) in (0..scales.len()).filter(|&k| is_eight_bit(k)).zip(&eight_bit.steps) {
        let step = step_of(byte.into());
        // Of a cube root in units of the step.
        let to_unit = 1.0 / (ROOT_LEVELS * step);
        let factor = to_unit * to_unit * to_unit;
        let (codes, sum) = encode_column(column(k), scales[k], factor);
        kept[k] += sum / f64::from(factor);
        for (i, word) in words[at..at + EIGHT_BIT_COLUMN_WORDS].iter_mut().enumerate() {
            let byte =
                |quarter: usize| codes[i + quarter * EIGHT_BIT_COLUMN_WORDS] << (8 * quarter);
            *word = byte(0) | byte(1) | byte(2) | byte(3);
        }
        at += EIGHT_BIT_COLUMN_WORDS;
    }
    at
}

/// The largest multiplier among a column's entries in a full block, before it is scaled.
#[inline(always)]
fn largest_of(column: &[f32]) -> f32 {
    let mut most = [0.0f32; 16];
    for chunk in column.as_chunks::<16>().0 {
        for (most, &v) in most.iter_mut().zip(chunk) {
            *most = if -v > *most { -v } else { *most };
        }
    }
    most.into_iter().fold(0.0, f32::max)
}

/// Roots of a column's entries in a block, and the sum of the multipliers that they stand for. The
/// scale makes multipliers of entries; the factor fits those to the step, and both together may
/// be more than a number can hold.
#[inline(always)]
fn encode_column(column: &[f32], scale: f32, factor: f32) -> ([u32; BLOCK_ROWS], f64) {
    let mut codes = [0u32; BLOCK_ROWS];
    for (code, &v) in codes.iter_mut().zip(column) {
        *code = self::encode(-v * scale * factor);
    }
    let mut sums = [0.0f32; 16];
    for codes in codes.chunks_exact(16) {
        for (sum, &code) in sums.iter_mut().zip(codes) {
            *sum += decode(code);
        }
    }
    (codes, sums.iter().map(|&v| f64::from(v)).sum())
}

/// Which columns of a block are 8-bit, and the bytes of their steps, one after the other.
#[derive(Default)]
struct EightBitColumns {
    mask: u32,
    steps: [u8; PIVOT_BLOCK],
}

impl EightBitColumns {
    /// By the largest multiplier of each column.
    #[inline(always)]
    fn of(largest: impl Iterator<Item = f32>) -> EightBitColumns {
        let mut found = EightBitColumns::default();
        let mut count = 0;
        for (k, largest) in largest.enumerate() {
            if largest <= EIGHT_BIT_LIMIT {
                found.mask |= 1 << k;
                found.steps[count] = step_for(largest) as u8;
                count += 1;
            }
        }
        found
    }

    /// Puts the block's header where its words start; returns its length.
    fn write(&self, words: &mut [u32]) -> usize {
        let len = header(self.mask);
        words[0] = self.mask;
        for (word, bytes) in words[1..len].iter_mut().zip(self.steps.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        len
    }
}
