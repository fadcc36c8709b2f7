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

/// Asks for entries that are read soon: fronts are short, and what comes after
/// one is more than the processor guesses.
#[inline(always)]
pub fn prefetch(entries: &[f32]) {
    #[cfg(target_arch = "x86_64")]
    for line in entries.chunks(16) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 has the instruction, and it reads nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = entries;
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

struct SubtractTimes<'a> {
    y: &'a mut [f32],
    a: &'a [f32],
    x: &'a [f32],
}

impl pulp::WithSimd for SubtractTimes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        inline::subtract_times(simd, self.y, self.a, self.y.len(), self.x);
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

impl pulp::WithSimd for SubtractTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        inline::subtract_transposed(simd, self.x, self.a, self.y.len(), self.y);
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
        inline::solve_lower(simd, self.x, self.l);
    }
}

/// x = L⁻ᵀ x for a packed lower triangle whose strips are inverted.
pub fn solve_upper(x: &mut [f32], l: &[f32]) {
    pulp::Arch::new().dispatch(SolveUpper { x, l });
}

struct SolveUpper<'a> {
    x: &'a mut [f32],
    l: &'a [f32],
}

impl pulp::WithSimd for SolveUpper<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        inline::solve_upper(simd, self.x, self.l);
    }
}

/// Columns whose triangle on the diagonal is kept as its inverse.
const STRIP: usize = 32;

/// The loops themselves, for callers that were dispatched to a vector unit.
pub mod inline {
    use pulp::{MemMask, Simd};

    use super::STRIP;

    /// Columns of more entries are read one after the other: several at once
    /// are more streams than the processor fetches ahead, and take twice as
    /// long from memory. Of shorter ones several share the work around them.
    const LONG: usize = 64;

    /// y = y - A x for columns that are `stride` apart.
    #[inline(always)]
    pub fn subtract_times<S: Simd>(simd: S, y: &mut [f32], a: &[f32], stride: usize, x: &[f32]) {
        if y.is_empty() {
            return;
        }
        if y.len() > LONG {
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

    /// The first lanes of a vector, where fewer entries than lanes are left.
    #[derive(Clone, Copy)]
    struct Tail<S: Simd> {
        mask: MemMask<S::m32s>,
        len: usize,
    }

    impl<S: Simd> Tail<S> {
        #[inline(always)]
        fn new(simd: S, len: usize) -> Tail<S> {
            // Without the mask's own functions, which are called and not inlined.
            Tail { mask: MemMask::new(simd.mask_between_m32s(0, len as u32).mask()), len }
        }

        /// The entries, and zeros.
        #[inline(always)]
        fn load(self, simd: S, x: &[f32]) -> S::f32s {
            let x = &x[..self.len];
            // SAFETY: the mask enables the lanes of these entries only.
            unsafe { simd.mask_load_ptr_f32s(self.mask, x.as_ptr()) }
        }

        #[inline(always)]
        fn store(self, simd: S, x: &mut [f32], values: S::f32s) {
            let x = &mut x[..self.len];
            // SAFETY: as above.
            unsafe { simd.mask_store_ptr_f32s(self.mask, x.as_mut_ptr(), values) }
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
        let columns: [&[f32]; N] = std::array::from_fn(|k| &a[k * stride..][..rows]);
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

    /// x = x - Aᵀ y for columns that are `stride` apart.
    #[inline(always)]
    pub fn subtract_transposed<S: Simd>(
        simd: S,
        x: &mut [f32],
        a: &[f32],
        stride: usize,
        y: &[f32],
    ) {
        if y.is_empty() {
            return;
        }
        if y.len() > LONG {
            for (k, x) in x.iter_mut().enumerate() {
                *x -= dot(simd, &a[k * stride..k * stride + y.len()], y);
            }
            return;
        }
        let mut at = 0;
        let mut fours = x.chunks_exact_mut(4);
        for x in &mut fours {
            dots::<S, 4>(simd, x, &a[at..], stride, y);
            at += 4 * stride;
        }
        for x in fours.into_remainder() {
            dots::<S, 1>(simd, std::slice::from_mut(x), &a[at..], stride, y);
            at += stride;
        }
    }

    #[inline(always)]
    fn dot<S: Simd>(simd: S, a: &[f32], y: &[f32]) -> f32 {
        let (y, y_rest) = S::as_simd_f32s(y);
        let (a, a_rest) = S::as_simd_f32s(a);
        let mut sums = [simd.splat_f32s(0.0); 4];
        let (y, a) = (y.chunks_exact(4), a.chunks_exact(4));
        let rest = y.remainder().iter().zip(a.remainder());
        for (y, a) in y.zip(a) {
            for k in 0..4 {
                sums[k] = simd.mul_add_e_f32s(a[k], y[k], sums[k]);
            }
        }
        for ((&y, &a), sum) in rest.zip(&mut sums) {
            *sum = simd.mul_add_e_f32s(a, y, *sum);
        }
        let halves = (simd.add_f32s(sums[0], sums[2]), simd.add_f32s(sums[1], sums[3]));
        let sum = simd.reduce_sum_f32s(simd.add_f32s(halves.0, halves.1));
        y_rest.iter().zip(a_rest).fold(sum, |sum, (y, a)| sum + y * a)
    }

    #[inline(always)]
    fn dots<S: Simd, const N: usize>(simd: S, x: &mut [f32], a: &[f32], stride: usize, y: &[f32]) {
        let rows = y.len();
        let columns: [&[f32]; N] = std::array::from_fn(|k| &a[k * stride..][..rows]);
        let mut sums = [simd.splat_f32s(0.0); N];
        let mut i = 0;
        while rows - i >= S::F32_LANES {
            let v = S::as_simd_f32s(&y[i..i + S::F32_LANES]).0[0];
            for (column, sum) in columns.iter().zip(&mut sums) {
                let (a, _) = S::as_simd_f32s(&column[i..i + S::F32_LANES]);
                *sum = simd.mul_add_e_f32s(a[0], v, *sum);
            }
            i += S::F32_LANES;
        }
        if i < rows {
            let tail = Tail::new(simd, rows - i);
            let v = tail.load(simd, &y[i..]);
            for (column, sum) in columns.iter().zip(&mut sums) {
                *sum = simd.mul_add_e_f32s(tail.load(simd, &column[i..]), v, *sum);
            }
        }
        for (x, sum) in x.iter_mut().zip(sums) {
            *x -= simd.reduce_sum_f32s(sum);
        }
    }

    /// x = L⁻¹ x for a packed lower triangle whose strips are inverted.
    #[inline(always)]
    pub fn solve_lower<S: Simd>(simd: S, x: &mut [f32], l: &[f32]) {
        let w = x.len();
        for from in (0..w).step_by(STRIP) {
            let to = (from + STRIP).min(w);
            let (own, rest) = x[from..].split_at_mut(to - from);
            let mut solved = [0.0; STRIP];
            let solved = &mut solved[..to - from];
            subtract_times(simd, solved, &l[from * w + from..], w, own);
            own.iter_mut().zip(&*solved).for_each(|(x, v)| *x = -v);
            subtract_times(simd, rest, &l[(from * w + to).min(l.len())..], w, own);
        }
    }

    /// x = L⁻ᵀ x for a packed lower triangle whose strips are inverted.
    #[inline(always)]
    pub fn solve_upper<S: Simd>(simd: S, x: &mut [f32], l: &[f32]) {
        let w = x.len();
        for from in (0..w).step_by(STRIP).rev() {
            let to = (from + STRIP).min(w);
            let (own, rest) = x[from..].split_at_mut(to - from);
            subtract_transposed(simd, own, &l[(from * w + to).min(l.len())..], w, rest);
            let mut solved = [0.0; STRIP];
            let solved = &mut solved[..to - from];
            subtract_transposed(simd, solved, &l[from * w + from..], w, own);
            own.iter_mut().zip(&*solved).for_each(|(x, v)| *x = -v);
        }
    }
}

/// Replaces the triangles of strips on the diagonal of a packed lower triangle
/// (w by w) by their inverses, and what is above the diagonal there by zero.
/// What cannot cancel in the factor cannot in the inverses.
pub fn invert_strips(t: &mut [f32], w: usize) {
    pulp::Arch::new().dispatch(InvertStrips { t, w });
}

struct InvertStrips<'a> {
    t: &'a mut [f32],
    w: usize,
}

impl pulp::NullaryFnOnce for InvertStrips<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let InvertStrips { t, w } = self;
        for from in (0..w).step_by(STRIP) {
            let size = STRIP.min(w - from);
            let mut inverse = [[0.0f32; STRIP]; STRIP];
            for (j, column) in inverse.iter_mut().enumerate().take(size) {
                column[j] = 1.0;
                for k in j..size {
                    let l = &t[(from + k) * w + from..][..size];
                    let (done, rest) = column[..size].split_at_mut(k + 1);
                    done[k] /= l[k];
                    let factor = done[k];
                    for (x, l) in rest.iter_mut().zip(&l[k + 1..]) {
                        *x -= factor * *l;
                    }
                }
            }
            for (j, column) in inverse.iter().enumerate().take(size) {
                t[(from + j) * w + from..][..size].copy_from_slice(&column[..size]);
            }
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
pub fn factor_diagonal(t: &mut [f32], rest: &mut [f32], inverse: &mut [f32]) -> Result<(), usize> {
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
