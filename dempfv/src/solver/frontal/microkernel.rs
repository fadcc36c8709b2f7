//! Products with tiles and triangular solves, vector by vector, for callers that were dispatched to a
//! vector unit: sums stay in registers, as in the microkernels of Goto and van de Geijn (2008).

use pulp::Simd;

use super::block::PIVOT_BLOCK;
use super::tail::Tail;

/// Columns of more entries are read one after the other: several at once
/// are more streams than the processor fetches ahead, and take twice as
/// long from memory. Of shorter ones several share the work around them.
const LONG_COLUMN_ROWS: usize = 64;

/// y = y - A x for columns that are `stride` apart.
#[inline(always)]
pub fn subtract_times<S: Simd>(simd: S, y: &mut [f32], a: &[f32], stride: usize, x: &[f32]) {
    if y.is_empty() {
        return;
    }
    if y.len() > LONG_COLUMN_ROWS {
        for (k, &x) in x.iter().enumerate() {
            let column = &a[k * stride..k * stride + y.len()];
            subtract_column(simd, y, column, x);
        }
        return;
    }
    let eights = x.chunks_exact(8);
    let fours = eights.remainder().chunks_exact(4);
    let ones = fours.remainder();
    let mut at = 0;
    for x in eights {
        subtract_columns::<S, 8>(simd, y, &a[at..], stride, x);
        at += 8 * stride;
    }
    for x in fours {
        subtract_columns::<S, 4>(simd, y, &a[at..], stride, x);
        at += 4 * stride;
    }
    for x in ones {
        subtract_columns::<S, 1>(simd, y, &a[at..], stride, std::slice::from_ref(x));
        at += stride;
    }
}

#[inline(always)]
fn subtract_column<S: Simd>(simd: S, y: &mut [f32], column: &[f32], x: f32) {
    let (y, y_rest) = S::as_mut_simd_f32s(y);
    let (a, a_rest) = S::as_simd_f32s(column);
    let x_of = simd.splat_f32s(x);
    for (y, &a) in y.iter_mut().zip(a) {
        *y = simd.negate_mul_add_e_f32s(a, x_of, *y);
    }
    for (y, &a) in y_rest.iter_mut().zip(a_rest) {
        *y -= a * x;
    }
}

#[inline(always)]
fn subtract_columns<S: Simd, const N: usize>(
    simd: S,
    y: &mut [f32],
    a: &[f32],
    stride: usize,
    x: &[f32],
) {
    let rows = y.len();
    let mut x_of = [simd.splat_f32s(0.0); N];
    for (v, &x) in x_of.iter_mut().zip(x) {
        *v = simd.splat_f32s(x);
    }
    // Not `from_fn`, which may be a function of its own that knows nothing of vectors.
    let mut columns: [&[f32]; N] = [&[]; N];
    for (k, column) in columns.iter_mut().enumerate() {
        *column = &a[k * stride..][..rows];
    }
    let mut i = 0;
    while rows - i >= S::F32_LANES {
        let (y, _) = S::as_mut_simd_f32s(&mut y[i..i + S::F32_LANES]);
        let mut sum = y[0];
        for (column, &x) in columns.iter().zip(&x_of) {
            let (a, _) = S::as_simd_f32s(&column[i..i + S::F32_LANES]);
            sum = simd.negate_mul_add_e_f32s(a[0], x, sum);
        }
        y[0] = sum;
        i += S::F32_LANES;
    }
    if i < rows {
        let tail = Tail::new(simd, rows - i);
        let mut sum = tail.load(simd, &y[i..]);
        for (column, &x) in columns.iter().zip(&x_of) {
            sum = simd.negate_mul_add_e_f32s(tail.load(simd, &column[i..]), x, sum);
        }
        tail.store(simd, &mut y[i..], sum);
    }
}

/// x = L⁻¹ x for a packed lower triangle whose pivot blocks are inverted.
#[inline(always)]
pub fn solve_lower<S: Simd>(simd: S, x: &mut [f32], l: &[f32]) {
    let w = x.len();
    for from in (0..w).step_by(PIVOT_BLOCK) {
        let to = (from + PIVOT_BLOCK).min(w);
        let (own, rest) = x[from..].split_at_mut(to - from);
        let mut solved = [0.0; PIVOT_BLOCK];
        let solved = &mut solved[..to - from];
        subtract_times(simd, solved, &l[from * w + from..], w, own);
        own.iter_mut().zip(&*solved).for_each(|(x, v)| *x = -v);
        subtract_times(simd, rest, &l[(from * w + to).min(l.len())..], w, own);
    }
}
