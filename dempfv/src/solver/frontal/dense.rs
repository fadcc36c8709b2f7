//! Operations of a front on vectors, in single precision.

use super::microkernel;

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
        microkernel::subtract_times(simd, self.y, self.a, self.y.len(), self.x);
    }
}

/// x = L⁻¹ x for a packed lower triangle whose pivot blocks are inverted.
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
        microkernel::solve_lower(simd, self.x, self.l);
    }
}
