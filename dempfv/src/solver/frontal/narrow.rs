//! Fronts of few columns, as solves use them: one block in place of a triangle and what
//! is below it.
//!
//! Of the columns of L the triangle on the diagonal is inverted, and what is below it is
//! multiplied with that inverse, once for all solves. With T the two, one upon the other,
//! the front's part of the way forward is `-T x` and that of the way back `-Tᵀ y`: one
//! pass over one block, whose sums stay in registers. Nothing cancels in T: the inverse
//! has no negative entry, and what is below it no positive one.

use pulp::Simd;

use super::lanes;
use super::pivot::STRIP;
use super::shape::{Shape, TILE};

/// Blocks of no more rows than this many vectors are kept in registers.
const VECTORS: usize = 4;

/// Columns that are summed up together on the way back.
const TOGETHER: usize = 4;

/// Lanes of the widest vectors.
const WIDEST: usize = 16;

/// Entries of the longest column that is kept in registers.
const LONGEST: usize = VECTORS * WIDEST;

/// So many entries after a block may be read, and have no effect as long as they are finite.
pub const SLACK: usize = TOGETHER * LONGEST;

/// Part of a vector that belongs to a front.
pub type Column = [f32; LONGEST];

/// Zeros.
pub const NOTHING: Column = [0.0; LONGEST];

/// True for fronts whose entries are made into one block.
pub fn is_narrow(shape: Shape) -> bool {
    shape.width <= STRIP
}

/// True for such a front whose columns fit into registers.
#[inline(always)]
pub fn is_small<S: Simd>(shape: Shape) -> bool {
    is_narrow(shape) && shape.height() <= VECTORS * S::F32_LANES
}

/// Makes the columns of a factored front into one block, by columns.
pub fn stack(shape: Shape, l: &mut [f32]) {
    pulp::Arch::new().dispatch(Stack { shape, l });
}

struct Stack<'a> {
    shape: Shape,
    l: &'a mut [f32],
}

impl pulp::NullaryFnOnce for Stack<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Stack { shape, l } = self;
        let (width, height) = (shape.width, shape.height());
        let (triangle, below) = l.split_at_mut(width * width);
        for tile in below.chunks_mut(TILE * width) {
            let rows = tile.len() / width;
            for k in 0..width {
                let (this, later) = tile[k * rows..].split_at_mut(rows);
                let inverse = &triangle[k * width + k..(k + 1) * width];
                this.iter_mut().for_each(|x| *x *= inverse[0]);
                for (column, &factor) in later.chunks_exact(rows).zip(&inverse[1..]) {
                    this.iter_mut().zip(column).for_each(|(x, l)| *x += factor * *l);
                }
            }
        }
        let mut block = vec![0.0; width * height];
        for (k, column) in block.chunks_exact_mut(height).enumerate() {
            let (top, edge) = column.split_at_mut(width);
            top.copy_from_slice(&triangle[k * width..(k + 1) * width]);
            for (rows, tile) in edge.chunks_mut(TILE).zip(below.chunks(TILE * width)) {
                rows.copy_from_slice(&tile[k * rows.len()..(k + 1) * rows.len()]);
            }
        }
        l.copy_from_slice(&block);
    }
}

/// x = L₁⁻¹ x, edge = edge - L₂ x for the two parts of a front's columns.
#[inline(always)]
pub fn forward<S: Simd>(simd: S, shape: Shape, l: &[f32], x: &mut [f32], edge: &mut [f32]) {
    let (width, height) = (shape.width, shape.height());
    lanes::subtract_times(simd, edge, &l[width..], height, x);
    let mut solved = [0.0; STRIP];
    lanes::subtract_times(simd, &mut solved[..width], l, height, x);
    x.iter_mut().zip(&solved).for_each(|(x, v)| *x = -v);
}

/// x = L₁⁻ᵀ (x - L₂ᵀ edge) for the two parts of a front's columns.
#[inline(always)]
pub fn backward<S: Simd>(simd: S, shape: Shape, l: &[f32], x: &mut [f32], edge: &[f32]) {
    let (width, height) = (shape.width, shape.height());
    let mut solved = [0.0; STRIP];
    let solved = &mut solved[..width];
    x.iter_mut().for_each(|x| *x = -*x);
    lanes::subtract_transposed(simd, solved, l, height, x);
    lanes::subtract_transposed(simd, solved, &l[width..], height, edge);
    x.copy_from_slice(solved);
}

/// `-T x` for a small front; `l` starts with T, and has [`SLACK`] more entries.
#[inline(always)]
pub fn forward_small<S: Simd>(simd: S, height: usize, l: &[f32], x: &[f32]) -> Column {
    let mut out = NOTHING;
    match height.div_ceil(S::F32_LANES) {
        0 | 1 => times::<S, 1>(simd, height, l, x, &mut out),
        2 => times::<S, 2>(simd, height, l, x, &mut out),
        3 => times::<S, 3>(simd, height, l, x, &mut out),
        _ => times::<S, 4>(simd, height, l, x, &mut out),
    }
    out
}

#[inline(always)]
fn times<S: Simd, const N: usize>(simd: S, height: usize, l: &[f32], x: &[f32], out: &mut [f32]) {
    let lanes = N * S::F32_LANES;
    let mut sums = [[simd.splat_f32s(0.0); N]; 2];
    let pairs = x.chunks_exact(2);
    let last = pairs.remainder();
    let mut at = 0;
    for pair in pairs {
        for (sum, &x) in sums.iter_mut().zip(pair) {
            let (column, _) = S::as_simd_f32s(&l[at..at + lanes]);
            let x = simd.splat_f32s(x);
            for (sum, &l) in sum.iter_mut().zip(column) {
                *sum = simd.negate_mul_add_e_f32s(l, x, *sum);
            }
            at += height;
        }
    }
    for &x in last {
        let (column, _) = S::as_simd_f32s(&l[at..at + lanes]);
        let x = simd.splat_f32s(x);
        for (sum, &l) in sums[0].iter_mut().zip(column) {
            *sum = simd.negate_mul_add_e_f32s(l, x, *sum);
        }
    }
    let (out, _) = S::as_mut_simd_f32s(&mut out[..lanes]);
    for (k, out) in out.iter_mut().enumerate().take(N) {
        *out = simd.add_f32s(sums[0][k], sums[1][k]);
    }
}

/// `-Tᵀ y` for a small front, of which `x` gets its part; `l` starts with T, and has
/// [`SLACK`] more entries, which meet zeros of y or sums that are not used.
#[inline(always)]
pub fn backward_small<S: Simd>(simd: S, height: usize, l: &[f32], y: &Column, x: &mut [f32]) {
    match height.div_ceil(S::F32_LANES) {
        0 | 1 => transposed::<S, 1>(simd, height, l, y, x),
        2 => transposed::<S, 2>(simd, height, l, y, x),
        3 => transposed::<S, 3>(simd, height, l, y, x),
        _ => transposed::<S, 4>(simd, height, l, y, x),
    }
}

#[inline(always)]
fn transposed<S: Simd, const N: usize>(
    simd: S,
    height: usize,
    l: &[f32],
    y: &Column,
    x: &mut [f32],
) {
    let lanes = N * S::F32_LANES;
    let (from, _) = S::as_simd_f32s(&y[..lanes]);
    let mut y = [simd.splat_f32s(0.0); N];
    y.iter_mut().zip(from).for_each(|(y, &from)| *y = from);
    let mut at = 0;
    for x in x.chunks_mut(TOGETHER) {
        let mut sums = [simd.splat_f32s(0.0); TOGETHER];
        for sum in &mut sums {
            let (column, _) = S::as_simd_f32s(&l[at..at + lanes]);
            for (&l, &y) in column.iter().zip(&y) {
                *sum = simd.negate_mul_add_e_f32s(l, y, *sum);
            }
            at += height;
        }
        // Not `map`, which may be a function of its own that knows nothing of vectors.
        for (x, &sum) in x.iter_mut().zip(&sums) {
            *x = simd.reduce_sum_f32s(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;

    /// Both ways through a front, small or not, as vectors of [x, edge].
    struct Both<'a> {
        shape: Shape,
        l: &'a [f32],
        x: &'a [f32],
    }

    impl pulp::WithSimd for Both<'_> {
        type Output = [Vec<f32>; 2];

        fn with_simd<S: Simd>(self, simd: S) -> [Vec<f32>; 2] {
            let Both { shape, l, x } = self;
            let (width, height) = (shape.width, shape.height());
            let (mut down, mut up) = (x.to_vec(), x.to_vec());
            let ((a, edge), (b, above)) = (down.split_at_mut(width), up.split_at_mut(width));
            if is_small::<S>(shape) {
                let out = forward_small(simd, height, l, a);
                edge.iter_mut().zip(&out[width..]).for_each(|(e, v)| *e += v);
                a.iter_mut().zip(&out).for_each(|(a, v)| *a = -v);
                let mut y = NOTHING;
                y[..width].iter_mut().zip(&*b).for_each(|(y, b)| *y = -b);
                y[width..height].copy_from_slice(above);
                backward_small(simd, height, l, &y, b);
            } else {
                forward(simd, shape, l, a, edge);
                backward(simd, shape, l, b, above);
            }
            [down, up]
        }
    }

    /// Against the parts that the block is made of, in double precision: L₁⁻¹ without
    /// negative entries, L₂ without positive ones, as a network's are.
    #[test]
    fn a_block_does_what_its_parts_do() {
        for (width, edge) in [(1, 0), (3, 13), (7, 20), (10, 54), (32, 32), (5, 300), (32, 600)] {
            let shape = Shape { width, edge };
            let number = |k: usize| ((k * 7919 + 13) % 101) as f32 / 101.0;
            let mut l = vec![0.0; shape.len()];
            for column in 0..width {
                for row in column..shape.height() {
                    let sign = if row < width { 1.0 } else { -1.0 };
                    l[shape.index(row, column)] = sign * number(row * width + column);
                }
            }
            let x: Vec<f32> = (0..shape.height()).map(|k| number(k * k + 1) - 0.5).collect();
            let entry = |row, column| f64::from(l[shape.index(row, column)]);
            let of = |k: usize| f64::from(x[k]);
            let solved = |k| (0..=k).map(|j| entry(k, j) * of(j)).sum::<f64>();
            let below = |i| of(i) - (0..width).map(|k| entry(i, k) * solved(k)).sum::<f64>();
            let left = |k| of(k) - (width..width + edge).map(|i| entry(i, k) * of(i)).sum::<f64>();
            let back = |k| (k..width).map(|j| entry(j, k) * left(j)).sum::<f64>();
            let down: Vec<f64> =
                (0..width).map(solved).chain((width..width + edge).map(below)).collect();
            let up: Vec<f64> = (0..width).map(back).chain((width..width + edge).map(of)).collect();

            let mut block = l.clone();
            stack(shape, &mut block);
            // What comes after a block must not matter.
            block.resize(block.len() + SLACK, 1e30);
            let both = || Both { shape, l: &block, x: &x };
            // This processor's vectors, shorter ones, none.
            for found in [
                pulp::Arch::new().dispatch(both()),
                both().with_simd(pulp::Scalar256b),
                both().with_simd(pulp::Scalar),
            ] {
                for (expected, found) in [&down, &up].into_iter().zip(&found) {
                    let scale = expected.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                    for (e, f) in expected.iter().zip(found) {
                        // Sums of up to 600 terms in single precision, some of which cancel.
                        assert!((e - f64::from(*f)).abs() < 3e-5 * scale, "{width} {edge}");
                    }
                }
            }
        }
    }
}
