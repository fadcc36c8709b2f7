//! The inner loop of dense operations on tiles: some rows and columns of C stay in registers while
//! products are summed up for them (Goto and van de Geijn 2008). A is read where it is, for a tile
//! fits into the second cache; the few rows of B are copied together, so that they stay in the first.
//!
//! Every entry is one sum in the order of its products, subtracted at the end: its bits depend neither
//! on its place in the tile, nor on the tile's size or address.

use std::ops::Range;

use pulp::Simd;

use super::block::Block;
use super::shape::TILE;
use super::tail::Tail;

/// Most columns in registers: with four vectors of rows they are 24 sums, which keep two pipelines
/// of multiply-adds busy and leave 8 of 32 registers.
const COLUMNS: usize = 6;

/// Vectors of rows in registers: half as many where vectors have eight lanes, for processors of
/// that kind (AVX2) have 16 registers.
const fn vectors<S: Simd>() -> usize {
    if S::F32_LANES == 8 { 2 } else { 4 }
}

/// Memory for some rows of B.
pub struct RowsOfB([f32; COLUMNS * TILE]);

impl RowsOfB {
    const fn new() -> RowsOfB {
        RowsOfB([0.0; COLUMNS * TILE])
    }

    /// Copies N rows together, column by column.
    #[inline(always)]
    pub fn copy<const N: usize>(&mut self, b: Block<'_>, depth: usize) -> &[[f32; N]] {
        let rows = &mut self.0.as_chunks_mut().0[..depth];
        for (k, row) in rows.iter_mut().enumerate() {
            *row = first(&b.data[k * b.stride..]);
        }
        rows
    }
}

/// The first N entries.
#[inline(always)]
pub fn first<const N: usize>(x: &[f32]) -> [f32; N] {
    let mut out = [0.0; N];
    out.copy_from_slice(&x[..N]);
    out
}

/// A triangle on the diagonal of L, by columns, and the inverses of its diagonal.
#[derive(Clone, Copy)]
pub struct Triangle<const N: usize> {
    pub l: [[f32; N]; N],
    pub inverse: [f32; N],
}

impl<const N: usize> Triangle<N> {
    /// X = X L⁻ᵀ.
    #[inline(always)]
    fn solve<S: Simd, const V: usize>(&self, simd: S, x: &mut [[S::f32s; V]; N]) {
        for k in 0..N {
            let inverse = simd.splat_f32s(self.inverse[k]);
            for x in &mut x[k] {
                *x = simd.mul_f32s(*x, inverse);
            }
            let (solved, column) = (x[k], self.l[k]);
            for j in k + 1..N {
                let l = simd.splat_f32s(column[j]);
                for v in 0..V {
                    x[j][v] = simd.negate_mul_add_e_f32s(solved[v], l, x[j][v]);
                }
            }
        }
    }
}

/// Work that is done a few columns at a time.
pub trait ByColumns {
    /// N columns from this one on; `copy` is memory for their rows of B.
    fn columns<S: Simd, const N: usize>(&mut self, simd: S, copy: &mut RowsOfB, from: usize);
}

/// All columns, as many at a time as registers hold.
#[inline(always)]
pub fn for_each_strip<S: Simd>(simd: S, columns: usize, work: &mut impl ByColumns) {
    let mut copy = RowsOfB::new();
    for from in (0..columns).step_by(COLUMNS) {
        match columns - from {
            1 => work.columns::<S, 1>(simd, &mut copy, from),
            2 => work.columns::<S, 2>(simd, &mut copy, from),
            3 => work.columns::<S, 3>(simd, &mut copy, from),
            4 => work.columns::<S, 4>(simd, &mut copy, from),
            5 => work.columns::<S, 5>(simd, &mut copy, from),
            _ => work.columns::<S, COLUMNS>(simd, &mut copy, from),
        }
    }
}

/// N columns of C = C - A Bᵀ.
pub struct Strip<'a, const N: usize> {
    pub c: &'a mut [f32],
    pub stride: usize,
    pub a: Block<'a>,
    pub b: &'a [[f32; N]],
    /// C is zero before: it is written and not read.
    pub fresh: bool,
    /// What is left of C is multiplied by the inverse of this transposed.
    pub triangle: Option<Triangle<N>>,
}

impl<const N: usize> Strip<'_, N> {
    /// From the vector of this row on to the last row.
    #[inline(always)]
    pub fn run<S: Simd>(mut self, simd: S, row: usize) {
        let rows = self.a.rows;
        let full = vectors::<S>() * S::F32_LANES;
        let mut from = row / S::F32_LANES * S::F32_LANES;
        while rows - from >= full {
            if S::F32_LANES == 8 {
                self.tile::<S, 2, false>(simd, from..from + full);
            } else {
                self.tile::<S, 4, false>(simd, from..from + full);
            }
            from += full;
        }
        match (rows - from).div_ceil(S::F32_LANES) {
            0 => {}
            1 => self.tile::<S, 1, true>(simd, from..rows),
            2 => self.tile::<S, 2, true>(simd, from..rows),
            3 => self.tile::<S, 3, true>(simd, from..rows),
            _ => self.tile::<S, 4, true>(simd, from..rows),
        }
    }

    /// Up to V vectors of rows; the last one is not full if `PARTIAL`.
    #[inline(always)]
    fn tile<S: Simd, const V: usize, const PARTIAL: bool>(&mut self, simd: S, rows: Range<usize>) {
        let len = rows.len();
        let tail = Tail::new(simd, len - (V - 1) * S::F32_LANES);
        let zero = simd.splat_f32s(0.0);
        let mut sums = [[zero; V]; N];
        let mut at = rows.start;
        for b in self.b {
            let a = load::<S, V, PARTIAL>(simd, &self.a.data[at..at + len], tail);
            for (sums, &b) in sums.iter_mut().zip(b) {
                let b = simd.splat_f32s(b);
                for (sum, &a) in sums.iter_mut().zip(&a) {
                    *sum = simd.mul_add_e_f32s(a, b, *sum);
                }
            }
            at += self.a.stride;
        }
        for (j, sums) in sums.iter_mut().enumerate() {
            let c = &self.c[j * self.stride + rows.start..][..len];
            let c = if self.fresh { [zero; V] } else { load::<S, V, PARTIAL>(simd, c, tail) };
            for (sum, &c) in sums.iter_mut().zip(&c) {
                *sum = simd.sub_f32s(c, *sum);
            }
        }
        if let Some(triangle) = &self.triangle {
            triangle.solve(simd, &mut sums);
        }
        for (j, sums) in sums.iter().enumerate() {
            let c = &mut self.c[j * self.stride + rows.start..][..len];
            store::<S, V, PARTIAL>(simd, c, tail, sums);
        }
    }
}

#[inline(always)]
fn load<S: Simd, const V: usize, const PARTIAL: bool>(
    simd: S,
    x: &[f32],
    tail: Tail<S>,
) -> [S::f32s; V] {
    let mut out = [simd.splat_f32s(0.0); V];
    let full = if PARTIAL { V - 1 } else { V };
    let (whole, rest) = x.split_at(full * S::F32_LANES);
    out[..full].copy_from_slice(S::as_simd_f32s(whole).0);
    if PARTIAL {
        out[V - 1] = tail.load(simd, rest);
    }
    out
}

#[inline(always)]
fn store<S: Simd, const V: usize, const PARTIAL: bool>(
    simd: S,
    x: &mut [f32],
    tail: Tail<S>,
    values: &[S::f32s; V],
) {
    let full = if PARTIAL { V - 1 } else { V };
    let (whole, rest) = x.split_at_mut(full * S::F32_LANES);
    S::as_mut_simd_f32s(whole).0.copy_from_slice(&values[..full]);
    if PARTIAL {
        tail.store(simd, rest, values[V - 1]);
    }
}
