//! The triangle on a panel's diagonal: factored without cancellation (Grassmann, Taksar and Heyman
//! 1985), and the inverses of its diagonal blocks that solves use.

use super::block::{Block, PIVOT_BLOCK};
use super::dense::total;
use super::product::Product;

/// Replaces the triangles of pivot blocks on the diagonal of a packed lower triangle
/// (w by w) by their inverses, and what is above the diagonal there by zero.
/// What cannot cancel in the factor cannot in the inverses.
pub fn invert_pivot_blocks(t: &mut [f32], w: usize) {
    pulp::Arch::new().dispatch(InvertPivotBlocks { t, w });
}

struct InvertPivotBlocks<'a> {
    t: &'a mut [f32],
    w: usize,
}

impl pulp::NullaryFnOnce for InvertPivotBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let InvertPivotBlocks { t, w } = self;
        for from in (0..w).step_by(PIVOT_BLOCK) {
            let size = PIVOT_BLOCK.min(w - from);
            let mut inverse = [[0.0f32; PIVOT_BLOCK]; PIVOT_BLOCK];
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
/// row excess over its off-diagonal entries, and the sizes of the entries of
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
    for from in (0..w).step_by(PIVOT_BLOCK) {
        let to = (from + PIVOT_BLOCK).min(w);
        if from > 0 {
            let (done, pivot_block) = t.split_at_mut(from * w);
            let height = w - from;
            let a = Block { data: &done[from..], rows: height, stride: w };
            let b = Block { data: &done[from..], rows: to - from, stride: w };
            let product = Product { a, b, depth: from, lower: true, fresh: false };
            product.subtract_from(&mut pivot_block[from..], w);
            for k in 0..from {
                let y = rest[k];
                for (z, l) in rest[from..to].iter_mut().zip(&done[k * w + from..]) {
                    *z -= y * l;
                }
            }
        }
        pulp::Arch::new().dispatch(FactorPivotBlock { t, rest, inverse, from, to })?;
    }
    Ok(())
}

struct FactorPivotBlock<'a> {
    t: &'a mut [f32],
    rest: &'a mut [f32],
    inverse: &'a mut [f32],
    from: usize,
    to: usize,
}

impl pulp::NullaryFnOnce for FactorPivotBlock<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn call(self) -> Result<(), usize> {
        let FactorPivotBlock { t, rest, inverse, from, to } = self;
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
