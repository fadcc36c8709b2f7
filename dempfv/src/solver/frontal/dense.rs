//! Dense parts in single precision: the BLAS where there is enough to do for
//! it, loops of our own where there is not.

use std::ffi::c_int;

use cholmod_sys::blas;

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
fn total(x: &[f32]) -> f32 {
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

pub struct SubtractTimes<'a> {
    pub y: &'a mut [f32],
    pub a: &'a [f32],
    pub x: &'a [f32],
}

impl pulp::NullaryFnOnce for SubtractTimes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SubtractTimes { y, a, x } = self;
        let rows = y.len();
        let (eights, rest) = (x.chunks_exact(8), x.chunks_exact(8).remainder());
        let mut at = 0;
        for x in eights {
            subtract_columns::<8>(y, &a[at..at + 8 * rows], x);
            at += 8 * rows;
        }
        let fours = rest.chunks_exact(4);
        let ones = fours.remainder();
        for x in fours {
            subtract_columns::<4>(y, &a[at..at + 4 * rows], x);
            at += 4 * rows;
        }
        for x in ones {
            subtract_columns::<1>(y, &a[at..at + rows], std::slice::from_ref(x));
            at += rows;
        }
    }
}

#[inline(always)]
fn subtract_columns<const N: usize>(y: &mut [f32], a: &[f32], x: &[f32]) {
    let rows = y.len();
    let columns: [&[f32]; N] = std::array::from_fn(|k| &a[k * rows..][..rows]);
    let x: [f32; N] = std::array::from_fn(|k| x[k]);
    for (i, y) in y.iter_mut().enumerate() {
        let mut sum = 0.0;
        for k in 0..N {
            sum += columns[k][i] * x[k];
        }
        *y -= sum;
    }
}

/// x = x - Aᵀ y for a packed block with one column per entry of x.
pub fn subtract_transposed(x: &mut [f32], a: &[f32], y: &[f32]) {
    if !x.is_empty() && !y.is_empty() {
        pulp::Arch::new().dispatch(SubtractTransposed { x, a, y });
    }
}

struct SubtractTransposed<'a> {
    x: &'a mut [f32],
    a: &'a [f32],
    y: &'a [f32],
}

impl pulp::NullaryFnOnce for SubtractTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SubtractTransposed { x, a, y } = self;
        let rows = y.len();
        let mut at = 0;
        let mut fours = x.chunks_exact_mut(4);
        for x in &mut fours {
            dots::<4>(x, &a[at..at + 4 * rows], y);
            at += 4 * rows;
        }
        for x in fours.into_remainder() {
            dots::<1>(std::slice::from_mut(x), &a[at..at + rows], y);
            at += rows;
        }
    }
}

#[inline(always)]
fn dots<const N: usize>(x: &mut [f32], a: &[f32], y: &[f32]) {
    let rows = y.len();
    let columns: [&[f32]; N] = std::array::from_fn(|k| &a[k * rows..][..rows]);
    let mut lanes = [[0.0f32; 16]; N];
    let whole = rows / 16 * 16;
    let mut i = 0;
    while i < whole {
        let v: &[f32] = &y[i..i + 16];
        for k in 0..N {
            let column: &[f32] = &columns[k][i..i + 16];
            for lane in 0..16 {
                lanes[k][lane] += column[lane] * v[lane];
            }
        }
        i += 16;
    }
    for k in 0..N {
        let mut sum = folded(lanes[k]);
        for i in whole..rows {
            sum += columns[k][i] * y[i];
        }
        x[k] -= sum;
    }
}

/// x = L⁻¹ x for a packed lower triangle and the inverses of its diagonal.
pub fn solve_lower(x: &mut [f32], l: &[f32], inverse: &[f32]) {
    pulp::Arch::new().dispatch(SolveLower { x, l, inverse });
}

struct SolveLower<'a> {
    x: &'a mut [f32],
    l: &'a [f32],
    inverse: &'a [f32],
}

impl pulp::NullaryFnOnce for SolveLower<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SolveLower { x, l, inverse } = self;
        let w = x.len();
        for k in 0..w {
            let (done, rest) = x.split_at_mut(k + 1);
            done[k] *= inverse[k];
            let factor = done[k];
            for (y, l) in rest.iter_mut().zip(&l[k * w + k + 1..(k + 1) * w]) {
                *y -= factor * *l;
            }
        }
    }
}

/// x = L⁻ᵀ x for a packed lower triangle and the inverses of its diagonal.
pub fn solve_upper(x: &mut [f32], l: &[f32], inverse: &[f32]) {
    pulp::Arch::new().dispatch(SolveUpper { x, l, inverse });
}

struct SolveUpper<'a> {
    x: &'a mut [f32],
    l: &'a [f32],
    inverse: &'a [f32],
}

impl pulp::NullaryFnOnce for SolveUpper<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let SolveUpper { x, l, inverse } = self;
        let w = x.len();
        for k in (0..w).rev() {
            let (before, after) = x.split_at_mut(k + 1);
            if !after.is_empty() {
                dots::<1>(&mut before[k..], &l[k * w + k + 1..(k + 1) * w], after);
            }
            before[k] *= inverse[k];
        }
    }
}

/// Factors the diagonal tile of a panel in place (w by w, packed; the upper
/// half and the diagonal on entry are not read).
///
/// `rest` holds for each column what its row sums up to beyond the tile: the
/// row's excess over its off-diagonal entries, and the sizes of the entries of
/// the column below the tile. A pivot is the sum of sizes of what is left in its
/// column, so that nothing is ever subtracted from anything of the same sign:
/// each entry of the factor is right to nearly all its digits (Grassmann,
/// Taksar and Heyman 1985). `rest` is overwritten.
///
/// # Errors
/// The column whose pivot is not positive.
pub fn factor_diagonal(
    t: &mut [f32],
    rest: &mut [f32],
    inverse: &mut [f32],
) -> Result<(), usize> {
    let w = rest.len();
    assert!(t.len() >= w * w && inverse.len() == w);
    for from in (0..w).step_by(STRIP) {
        let to = (from + STRIP).min(w);
        if from > 0 {
            let (done, strip) = t.split_at_mut(from * w);
            let height = w - from;
            let a = Block { data: &done[from..], rows: height, stride: w };
            let b = Block { data: &done[from..], rows: to - from, stride: w };
            subtract_product(&mut strip[from..], w, a, b, from, 1.0);
            for k in 0..from {
                let y = rest[k];
                for (z, l) in rest_of(rest, from, to).iter_mut().zip(&done[k * w + from..]) {
                    *z -= y * l;
                }
            }
        }
        pulp::Arch::new().dispatch(Strip { t, rest, inverse, from, to })?;
    }
    Ok(())
}

fn rest_of(rest: &mut [f32], from: usize, to: usize) -> &mut [f32] {
    &mut rest[from..to]
}

/// Columns of a diagonal tile that are factored one by one.
const STRIP: usize = 32;

struct Strip<'a> {
    t: &'a mut [f32],
    rest: &'a mut [f32],
    inverse: &'a mut [f32],
    from: usize,
    to: usize,
}

impl pulp::NullaryFnOnce for Strip<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn call(self) -> Result<(), usize> {
        let Strip { t, rest, inverse, from, to } = self;
        let w = rest.len();
        for k in from..to {
            let (done, later) = t.split_at_mut((k + 1) * w);
            let column = &mut done[k * w + k..];
            let pivot = rest[k] - total(&column[1..]);
            if pivot.is_nan() || pivot <= 0.0 || pivot.is_infinite() {
                return Err(k);
            }
            let root = pivot.sqrt();
            let scale = 1.0 / root;
            column[0] = root;
            inverse[k] = scale;
            let column = &mut column[1..];
            column.iter_mut().for_each(|x| *x *= scale);
            rest[k] *= scale;
            let y = rest[k];
            for j in k + 1..to {
                let factor = column[j - k - 1];
                rest[j] -= y * factor;
                let target = &mut later[(j - k - 1) * w + j + 1..(j - k) * w];
                for (x, l) in target.iter_mut().zip(&column[j - k..]) {
                    *x -= factor * *l;
                }
            }
        }
        Ok(())
    }
}
