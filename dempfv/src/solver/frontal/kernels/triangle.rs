//! Products with the inverse of a pivot block's triangle, and with its transpose.

use pulp::Simd;

use super::super::block::PIVOT_BLOCK;
use crate::parallel::prefetch;

/// How far ahead entries of triangles are asked for: two kilobytes.
const PREFETCH_TRIANGLE_ENTRIES: isize = 512;

/// From the 32nd on all bits, before it none; and the other way round.
const FROM: [u32; 2 * PIVOT_BLOCK] = window(true);
const UP_TO: [u32; 2 * PIVOT_BLOCK] = window(false);

const fn window(from: bool) -> [u32; 2 * PIVOT_BLOCK] {
    let mut bits = [0; 2 * PIVOT_BLOCK];
    let mut k = 0;
    while k < 2 * PIVOT_BLOCK {
        if (k >= PIVOT_BLOCK) == from {
            bits[k] = u32::MAX;
        }
        k += 1;
    }
    bits
}

/// x = T x for the columns of a pivot block, or x = Tᵀ x.
#[inline(always)]
pub fn multiply_triangle<S: Simd, const BACK: bool>(simd: S, triangle: &[f32], x: &mut [f32]) {
    let size = x.len();
    let mut out = [0.0; PIVOT_BLOCK];
    let mut from = 0;
    while from < size {
        if size - from > S::F32_LANES {
            multiply_triangle_vectors::<S, BACK, 2>(simd, from, triangle, x, &mut out);
        } else {
            multiply_triangle_vectors::<S, BACK, 1>(simd, from, triangle, x, &mut out);
        }
        from += 2 * S::F32_LANES;
    }
    x.copy_from_slice(&out[..size]);
}

#[inline(always)]
fn multiply_triangle_vectors<S: Simd, const BACK: bool, const N: usize>(
    simd: S,
    from: usize,
    triangle: &[f32],
    x: &[f32],
    out: &mut [f32; PIVOT_BLOCK],
) {
    let lanes = N * S::F32_LANES;
    let size = x.len();
    let mut even = [simd.splat_f32s(0.0); N];
    let mut odd = even;
    let mut at = from + usize::from(!BACK);
    let mut window = from + PIVOT_BLOCK;
    let pairs = x.chunks_exact(2);
    let last = pairs.remainder();
    for pair in pairs {
        multiply_triangle_column::<S, BACK, N>(
            simd,
            &triangle[at..at + lanes],
            window,
            pair[0],
            &mut even,
        );
        at += size + 1;
        window -= 1;
        multiply_triangle_column::<S, BACK, N>(
            simd,
            &triangle[at..at + lanes],
            window,
            pair[1],
            &mut odd,
        );
        at += size + 1;
        window -= 1;
    }
    for &x in last {
        multiply_triangle_column::<S, BACK, N>(
            simd,
            &triangle[at..at + lanes],
            window,
            x,
            &mut even,
        );
    }
    let (out, _) = S::as_mut_simd_f32s(&mut out[from..from + lanes]);
    for k in 0..N {
        out[k] = simd.add_f32s(even[k], odd[k]);
    }
}

/// Adds one column's part, without what is on the other side of the diagonal.
#[inline(always)]
fn multiply_triangle_column<S: Simd, const BACK: bool, const N: usize>(
    simd: S,
    column: &[f32],
    window: usize,
    x: f32,
    sums: &mut [S::f32s; N],
) {
    let lanes = N * S::F32_LANES;
    prefetch(column, if BACK { -PREFETCH_TRIANGLE_ENTRIES } else { PREFETCH_TRIANGLE_ENTRIES });
    // Rows 0 to k in the backward substitution, k and later ones in the forward substitution.
    let bits = if BACK { &UP_TO[window - 1..] } else { &FROM[window..] };
    let (bits, _) = S::as_simd_u32s(&bits[..lanes]);
    let (column, _) = S::as_simd_u32s(bytemuck::cast_slice(column));
    let x = simd.splat_f32s(x);
    for k in 0..N {
        let entries = simd.transmute_f32s_u32s(simd.and_u32s(column[k], bits[k]));
        sums[k] = simd.mul_add_e_f32s(entries, x, sums[k]);
    }
}
