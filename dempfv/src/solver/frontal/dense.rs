//! Dense parts in single precision: the BLAS where there is enough to do for
//! it, loops of our own where there is not.

use std::ffi::c_int;

use cholmod_sys::blas;

use super::lanes;

/// Below this many columns a loop beats a call of the BLAS.
const FEW: usize = 12;

/// A block by columns: `rows` entries each, `stride` from one to the next.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    pub data: &'a [f32],
    pub rows: usize,
    pub stride: usize,
}

impl<'a> Block<'a> {
    /// A block whose columns follow each other.
    pub fn packed(data: &'a [f32], rows: usize) -> Block<'a> {
        Block { data, rows, stride: rows }
    }

    /// Its rows from this one on; may be none.
    pub fn below(self, row: usize) -> Block<'a> {
        Block { data: &self.data[row..], rows: self.rows - row, ..self }
    }
}

/// C = β C - A Bᵀ over `k` columns of A and B; C has the rows of A, and as many
/// columns as B has rows.
pub fn subtract_product(
    c: &mut [f32],
    stride: usize,
    a: Block<'_>,
    b: Block<'_>,
    k: usize,
    beta: f32,
) {
    let (m, n) = (a.rows, b.rows);
    if m == 0 || n == 0 || k == 0 {
        return;
    }
    let inside = |data: usize, stride: usize, rows: usize, columns: usize| {
        rows <= stride && (columns - 1) * stride + rows <= data
    };
    assert!(inside(c.len(), stride, m, n), "C is too small");
    assert!(inside(a.data.len(), a.stride, m, k), "A is too small");
    assert!(inside(b.data.len(), b.stride, n, k), "B is too small");
    // SAFETY: the three blocks lie inside their slices, as asserted; sizes of
    // tiles fit into an int.
    unsafe {
        blas::cblas_sgemm(
            blas::COLUMNS,
            blas::PLAIN,
            blas::TRANSPOSED,
            m as c_int,
            n as c_int,
            k as c_int,
            -1.0,
            a.data.as_ptr(),
            a.stride as c_int,
            b.data.as_ptr(),
            b.stride as c_int,
            beta,
            c.as_mut_ptr(),
            stride as c_int,
        );
    }
}

/// B = B L⁻ᵀ for the lower triangle L (w by w, packed) and `rows` rows of B.
pub fn solve_right(b: &mut [f32], rows: usize, l: &[f32], w: usize, inverse: &[f32]) {
    assert!(b.len() >= rows * w && l.len() >= w * w && inverse.len() == w);
    if rows == 0 || w == 0 {
        return;
    }
    if w <= FEW {
        pulp::Arch::new().dispatch(SolveRight { b, rows, l, w, inverse });
        return;
    }
    // SAFETY: both blocks lie inside their slices, as asserted; sizes of tiles
    // fit into an int.
    unsafe {
        blas::cblas_strsm(
            blas::COLUMNS,
            blas::RIGHT,
            blas::LOWER,
            blas::TRANSPOSED,
            blas::NON_UNIT,
            rows as c_int,
            w as c_int,
            1.0,
            l.as_ptr(),
            w as c_int,
            b.as_mut_ptr(),
            rows as c_int,
        );
    }
}

struct SolveRight<'a> {
    b: &'a mut [f32],
    rows: usize,
    l: &'a [f32],
    w: usize,
    inverse: &'a [f32],
}

impl pulp::NullaryFnOnce for SolveRight<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SolveRight { b, rows, l, w, inverse } = self;
        for k in 0..w {
            let (done, rest) = b.split_at_mut((k + 1) * rows);
            let column = &mut done[k * rows..];
            column.iter_mut().for_each(|x| *x *= inverse[k]);
            for (j, later) in rest.chunks_exact_mut(rows).take(w - k - 1).enumerate() {
                let factor = l[k * w + k + 1 + j];
                for (y, x) in later.iter_mut().zip(column.iter()) {
                    *y -= factor * *x;
                }
            }
        }
    }
}

/// Sums of a block's columns, subtracted from `sums`: entries are not positive.
pub fn subtract_column_sums(block: &[f32], rows: usize, sums: &mut [f32]) {
    pulp::Arch::new().dispatch(ColumnSums { block, rows, sums });
}

struct ColumnSums<'a> {
    block: &'a [f32],
    rows: usize,
    sums: &'a mut [f32],
}

impl pulp::NullaryFnOnce for ColumnSums<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (sum, column) in self.sums.iter_mut().zip(self.block.chunks_exact(self.rows)) {
            *sum -= total(column);
        }
    }
}

/// Sum in sixteen lanes, which has the same bits whatever the vector width.
#[inline(always)]
pub fn total(x: &[f32]) -> f32 {
    let mut lanes = [0.0f32; 16];
    let chunks = x.chunks_exact(16);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += v;
        }
    }
    let mut sum = folded(lanes);
    for v in rest {
        sum += v;
    }
    sum
}

#[inline(always)]
fn folded(mut lanes: [f32; 16]) -> f32 {
    for half in [8, 4, 2, 1] {
        for k in 0..half {
            lanes[k] += lanes[k + half];
        }
    }
    lanes[0]
}

/// y = y - A x for a packed block with one column per entry of x.
pub fn subtract_times(y: &mut [f32], a: &[f32], x: &[f32]) {
    if !x.is_empty() && !y.is_empty() {
        pulp::Arch::new().dispatch(SubtractTimes { y, a, x });
    }
}

struct SubtractTimes<'a> {
    y: &'a mut [f32],
    a: &'a [f32],
    x: &'a [f32],
}

impl pulp::WithSimd for SubtractTimes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        lanes::subtract_times(simd, self.y, self.a, self.y.len(), self.x);
    }
}

/// x = L⁻¹ x for a packed lower triangle whose strips are inverted.
pub fn solve_lower(x: &mut [f32], l: &[f32]) {
    pulp::Arch::new().dispatch(SolveLower { x, l });
}

struct SolveLower<'a> {
    x: &'a mut [f32],
    l: &'a [f32],
}

impl pulp::WithSimd for SolveLower<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        lanes::solve_lower(simd, self.x, self.l);
    }
}
