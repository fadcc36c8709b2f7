//! Forward and backward substitution through one front with its packed factor: column by column
//! forward and dot products backward, by the inverted triangles of pivot blocks (Raghavan 1998).

use std::ops::Range;

use pulp::Simd;
use rayon::prelude::*;

use super::block::PIVOT_BLOCK;
use super::kernels::{
    CubeRoots, Halves, PREFETCH_WORDS, TransposedProduct, multiply, multiply_low_rank,
    multiply_low_rank_transposed, multiply_mixed, multiply_triangle,
};
use super::low_rank::rank_of;
use super::packed::{BLOCK_ROWS, CHUNK_ROWS, Panel, PivotBlock, panels, words as words_for};
use super::shape::{Shape, TILE};
use super::tail::Tail;

/// The factor of one front; words and entries of triangles may go on after it.
#[derive(Clone, Copy)]
pub struct Front<'a> {
    pub shape: Shape,
    pub words: &'a [u32],
    pub triangles: &'a [f32],
    pub factors: &'a [f32],
}

/// What the columns of a pivot block have for the rows below: values times factors, and zeros
/// after them.
#[inline(always)]
fn scaled<S: Simd>(simd: S, x: &[f32], factors: &[f32], out: &mut [f32; PIVOT_BLOCK]) {
    let (out, _) = S::as_mut_simd_f32s(out);
    let mut from = 0;
    for out in out {
        let rest = x.len().saturating_sub(from).min(S::F32_LANES);
        let tail = Tail::new(simd, rest);
        let (x, factors) = (&x[from.min(x.len())..], &factors[from.min(x.len())..]);
        *out = simd.mul_f32s(tail.load(simd, x), tail.load(simd, factors));
        from += S::F32_LANES;
    }
}

/// Forward substitution through a narrow front: x = T x, and each block of its border is given
/// its part of -L₂ x.
#[inline(always)]
pub fn forward_narrow<S: Simd>(
    simd: S,
    front: Front<'_>,
    x: &mut [f32],
    mut give: impl FnMut(Range<usize>, &Halves),
) {
    multiply_triangle::<S, false>(simd, front.triangles, x);
    let mut values = [0.0; PIVOT_BLOCK];
    scaled(simd, x, front.factors, &mut values);
    let values = &values[..x.len()];
    let mut at = 0;
    for from in (0..front.shape.border).step_by(BLOCK_ROWS) {
        let to = front.shape.border.min(from + BLOCK_ROWS);
        let half = words_for(to - from);
        give(from..to, &multiply::<S, CubeRoots<S>>(simd, half, &front.words[at..], values));
        at += half * values.len();
    }
}

/// Backward substitution through a narrow front, x = Tᵀ (x - L₂ᵀ border), with the values of each
/// block of its border.
#[inline(always)]
pub fn backward_narrow<S: Simd>(
    simd: S,
    front: Front<'_>,
    sums_so_far: &mut TransposedProduct,
    x: &mut [f32],
    take: impl Fn(Range<usize>) -> Halves,
) {
    let width = x.len();
    sums_so_far.begin::<S>(width);
    let mut at = 0;
    for from in (0..front.shape.border).step_by(BLOCK_ROWS) {
        let to = front.shape.border.min(from + BLOCK_ROWS);
        sums_so_far.add::<S, CubeRoots<S>>(
            simd,
            width,
            &front.words[at..],
            -PREFETCH_WORDS,
            to - from,
            &take(from..to),
        );
        at += words_for(to - from) * width;
    }
    let mut sums = [0.0; PIVOT_BLOCK];
    sums_so_far.total(simd, &mut sums[..width]);
    add_scaled(x, front.factors, &sums);
    multiply_triangle::<S, true>(simd, front.triangles, x);
}

/// x = x + f s for the factors f of a pivot block's columns and what came together for them.
#[inline(always)]
fn add_scaled(x: &mut [f32], factors: &[f32], sums: &[f32]) {
    for ((x, factor), sum) in x.iter_mut().zip(factors).zip(sums) {
        *x += factor * sum;
    }
}

/// What the pivot blocks of a panel have for the rows below, see [`scaled`].
type ScaledBlocks = [[f32; PIVOT_BLOCK]; TILE / PIVOT_BLOCK];

/// x = L₁⁻¹ x, border = border - L₂ x for the two parts of a front's columns.
pub fn forward(front: Front<'_>, x: &mut [f32], border: &mut [f32], parallel: bool) {
    let Front { shape, mut words, mut triangles, factors } = front;
    for panel in panels(shape) {
        let (own, later) = x[panel.first..].split_at_mut(panel.width);
        let mut scaled: ScaledBlocks = [[0.0; PIVOT_BLOCK]; TILE / PIVOT_BLOCK];
        let part = Front { shape, words, triangles, factors: &factors[panel.first..] };
        pulp::Arch::new().dispatch(ForwardDiagonal { panel, part, own, scaled: &mut scaled });
        let scaled = &scaled;
        let of_own = panel.later_rows.div_ceil(CHUNK_ROWS);
        let chunk = |k: usize, y: &mut [f32]| {
            let words = &words[panel.chunk(k).1..];
            pulp::Arch::new().dispatch(ForwardChunk { panel, words, scaled, y });
        };
        let in_own = |(k, y): (usize, &mut [f32])| chunk(k, y);
        let in_border = |(k, y): (usize, &mut [f32])| chunk(of_own + k, y);
        if parallel {
            rayon::join(
                || later.par_chunks_mut(CHUNK_ROWS).enumerate().for_each(in_own),
                || border.par_chunks_mut(CHUNK_ROWS).enumerate().for_each(in_border),
            );
        } else {
            later.chunks_mut(CHUNK_ROWS).enumerate().for_each(in_own);
            border.chunks_mut(CHUNK_ROWS).enumerate().for_each(in_border);
        }
        words = &words[panel.words()..];
        triangles = &triangles[panel.triangles()..];
    }
}

/// Forward substitution inside a panel.
struct ForwardDiagonal<'a> {
    panel: Panel,
    part: Front<'a>,
    own: &'a mut [f32],
    scaled: &'a mut ScaledBlocks,
}

impl pulp::WithSimd for ForwardDiagonal<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let ForwardDiagonal { panel, part, own, scaled: all } = self;
        let (mut at, mut triangle) = (0, 0);
        for (k, pivot_block) in panel.pivot_blocks().enumerate() {
            let PivotBlock { first, width } = pivot_block;
            let (x, later) = own[first..].split_at_mut(width);
            let values = &mut all[k];
            multiply_triangle::<S, false>(simd, &part.triangles[triangle..], x);
            triangle += pivot_block.triangle();
            scaled(simd, x, &part.factors[first..], values);
            at += multiply_rows(simd, &part.words[at..], values, width, later);
        }
    }
}

/// Forward substitution from a pivot block to later rows of its panel; returns how many words that took.
#[inline(always)]
fn multiply_rows<S: Simd>(
    simd: S,
    words: &[u32],
    x: &[f32; PIVOT_BLOCK],
    width: usize,
    y: &mut [f32],
) -> usize {
    let mut at = 0;
    for y in y.chunks_mut(BLOCK_ROWS) {
        let half = words_for(y.len());
        multiply::<S, CubeRoots<S>>(simd, half, &words[at..], &x[..width]).add_to(y);
        at += half * width;
    }
    at
}

/// Forward substitution from a panel to one chunk.
struct ForwardChunk<'a> {
    panel: Panel,
    words: &'a [u32],
    scaled: &'a ScaledBlocks,
    y: &'a mut [f32],
}

impl pulp::WithSimd for ForwardChunk<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let ForwardChunk { panel, mut words, scaled, y } = self;
        let mut sums_so_far = TransposedProduct::new();
        for y in y.chunks_mut(BLOCK_ROWS) {
            let mixed = panel.mixed && y.len() == BLOCK_ROWS;
            if mixed && let Some(rank) = rank_of(words[0]) {
                let x = &scaled.as_flattened()[..panel.width];
                let (scaled, taken) = multiply_low_rank(simd, &mut sums_so_far, rank, words, x);
                scaled.add_to(y);
                words = &words[taken..];
                continue;
            }
            words = &words[usize::from(mixed)..];
            for (pivot_block, values) in panel.pivot_blocks().zip(scaled) {
                let taken = if mixed {
                    let (scaled, taken) = multiply_mixed(simd, words, values, pivot_block.width);
                    scaled.add_to(y);
                    taken
                } else {
                    multiply_rows(simd, words, values, pivot_block.width, y)
                };
                words = &words[taken..];
            }
        }
    }
}

/// x = L₁⁻ᵀ (x - L₂ᵀ border) for the two parts of a front's columns.
pub fn backward(front: Front<'_>, x: &mut [f32], border: &[f32], parallel: bool) {
    let mut at: usize = panels(front.shape).map(Panel::words).sum();
    let mut triangle: usize = panels(front.shape).map(Panel::triangles).sum();
    for panel in panels(front.shape).rev() {
        at -= panel.words();
        triangle -= panel.triangles();
        let (own, later) = x[panel.first..].split_at_mut(panel.width);
        let below = PanelBelow { panel, words: &front.words[at..], later, border, parallel };
        let sums = below.collect(0..panel.chunks());
        let part = Front {
            words: below.words,
            triangles: &front.triangles[triangle..],
            factors: &front.factors[panel.first..],
            ..front
        };
        pulp::Arch::new().dispatch(BackwardDiagonal { panel, part, sums: &sums, own });
    }
}

/// What is below a panel.
struct PanelBelow<'a> {
    panel: Panel,
    words: &'a [u32],
    later: &'a [f32],
    border: &'a [f32],
    parallel: bool,
}

impl PanelBelow<'_> {
    /// Multipliers times values of some chunks, by column. Halves are added up, and so the
    /// bits do not depend on who does which.
    fn collect(&self, chunks: Range<usize>) -> [f32; TILE] {
        let Range { start, end } = chunks;
        if end - start <= 1 {
            let mut sums = [0.0; TILE];
            if start < end {
                let (rows, at) = self.panel.chunk(start);
                let later = self.panel.later_rows;
                let y = if rows.start < later {
                    &self.later[rows]
                } else {
                    &self.border[rows.start - later..rows.end - later]
                };
                let words = &self.words[at..];
                pulp::Arch::new().dispatch(BackwardChunk {
                    panel: self.panel,
                    words,
                    y,
                    sums: &mut sums,
                });
            }
            return sums;
        }
        let middle = start + (end - start) / 2;
        let halves = (|| self.collect(start..middle), || self.collect(middle..end));
        let (mut sums, more) =
            if self.parallel { rayon::join(halves.0, halves.1) } else { (halves.0(), halves.1()) };
        sums.iter_mut().zip(&more).for_each(|(sum, v)| *sum += v);
        sums
    }
}

/// Backward substitution from one chunk.
struct BackwardChunk<'a> {
    panel: Panel,
    words: &'a [u32],
    y: &'a [f32],
    sums: &'a mut [f32; TILE],
}

impl pulp::WithSimd for BackwardChunk<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let BackwardChunk { panel, mut words, y, sums } = self;
        let mut of_pivot_blocks = [const { TransposedProduct::new() }; TILE / PIVOT_BLOCK];
        let mut of_low_rank = TransposedProduct::new();
        for y in y.chunks(BLOCK_ROWS) {
            let values = Halves::of(y);
            let mixed = panel.mixed && y.len() == BLOCK_ROWS;
            if mixed && let Some(rank) = rank_of(words[0]) {
                let sums = &mut sums[..panel.width];
                let taken =
                    multiply_low_rank_transposed(simd, &mut of_low_rank, rank, words, values, sums);
                words = &words[taken..];
                continue;
            }
            words = &words[usize::from(mixed)..];
            for (pivot_block, sums_so_far) in panel.pivot_blocks().zip(&mut of_pivot_blocks) {
                let taken = if mixed {
                    sums_so_far.add_mixed(simd, pivot_block.width, words, &values)
                } else {
                    let width = pivot_block.width;
                    sums_so_far.add::<S, CubeRoots<S>>(
                        simd,
                        width,
                        words,
                        PREFETCH_WORDS,
                        y.len(),
                        &values,
                    );
                    words_for(y.len()) * width
                };
                words = &words[taken..];
            }
        }
        for (pivot_block, sums_so_far) in panel.pivot_blocks().zip(&of_pivot_blocks) {
            let mut more = [0.0; PIVOT_BLOCK];
            let more = &mut more[..pivot_block.width];
            sums_so_far.total(simd, more);
            sums[pivot_block.first..].iter_mut().zip(&*more).for_each(|(sum, v)| *sum += v);
        }
    }
}

/// Backward substitution from later rows of a panel to a pivot block; returns how many words that took.
#[inline(always)]
fn multiply_rows_transposed<S: Simd>(
    simd: S,
    sums_so_far: &mut TransposedProduct,
    width: usize,
    words: &[u32],
    y: &[f32],
) -> usize {
    let mut at = 0;
    for y in y.chunks(BLOCK_ROWS) {
        let values = Halves::of(y);
        sums_so_far.add::<S, CubeRoots<S>>(
            simd,
            width,
            &words[at..],
            PREFETCH_WORDS,
            y.len(),
            &values,
        );
        at += words_for(y.len()) * width;
    }
    at
}

/// Backward substitution inside a panel.
struct BackwardDiagonal<'a> {
    panel: Panel,
    part: Front<'a>,
    sums: &'a [f32; TILE],
    own: &'a mut [f32],
}

impl pulp::WithSimd for BackwardDiagonal<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let BackwardDiagonal { panel, part, sums, own } = self;
        let mut sums_so_far = TransposedProduct::new();
        let (mut at, mut triangle) = (panel.all_diagonal_words(), panel.triangles());
        for pivot_block in panel.pivot_blocks().rev() {
            let PivotBlock { first, width } = pivot_block;
            at -= panel.diagonal_words(pivot_block);
            triangle -= pivot_block.triangle();
            let (x, later) = own[first..].split_at_mut(width);
            sums_so_far.begin::<S>(width);
            multiply_rows_transposed(simd, &mut sums_so_far, width, &part.words[at..], later);
            let mut all = [0.0; PIVOT_BLOCK];
            let all = &mut all[..width];
            sums_so_far.total(simd, all);
            all.iter_mut().zip(&sums[first..]).for_each(|(all, v)| *all += v);
            add_scaled(x, &part.factors[first..], all);
            multiply_triangle::<S, true>(simd, &part.triangles[triangle..], x);
        }
    }
}

#[cfg(test)]
mod tests;
