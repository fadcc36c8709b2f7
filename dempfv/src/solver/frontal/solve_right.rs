//! B = B L⁻ᵀ for a tile B and the lower triangle L of its panel: some columns at a time, which those
//! before have been subtracted from, are solved in registers.

use pulp::{Simd, WithSimd};

use super::block::Block;
use super::register_tile::{ByColumns, RowsOfB, Strip, Triangle, first, for_each_strip};

/// B = B L⁻ᵀ for the lower triangle L (w by w, packed), the inverses of its diagonal and `rows`
/// rows of B.
pub fn solve_right(b: &mut [f32], rows: usize, l: &[f32], inverse: &[f32]) {
    if rows > 0 {
        pulp::Arch::new().dispatch(SolveRight { b, rows, l, inverse });
    }
}

struct SolveRight<'a> {
    b: &'a mut [f32],
    rows: usize,
    l: &'a [f32],
    inverse: &'a [f32],
}

impl WithSimd for SolveRight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for_each_strip(simd, self.inverse.len(), &mut self);
    }
}

impl ByColumns for SolveRight<'_> {
    #[inline(always)]
    fn columns<S: Simd, const N: usize>(&mut self, simd: S, copy: &mut RowsOfB, from: usize) {
        let (rows, w) = (self.rows, self.inverse.len());
        let l = Block::packed(self.l, w).below(from);
        let mut triangle = Triangle { l: [[0.0; N]; N], inverse: first(&self.inverse[from..]) };
        for (k, column) in triangle.l.iter_mut().enumerate() {
            *column = first(&l.data[(from + k) * w..]);
        }
        let (solved, c) = self.b.split_at_mut(from * rows);
        let (a, b) = (Block::packed(solved, rows), copy.copy::<N>(l, from));
        let strip = Strip { c, stride: rows, a, b, fresh: false, triangle: Some(triangle) };
        strip.run(simd, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signs are those of a front: a positive diagonal, nothing positive beside it and in B. Nothing
    /// cancels then, and each entry of X is right to half a unit in the last place for each
    /// operation that it or one before it came from; against substitution in double precision.
    #[test]
    fn every_entry_is_right_to_round_off() {
        for (rows, w) in [(1, 1), (5, 6), (17, 7), (64, 12), (100, 13), (256, 32), (61, 256)] {
            let number = |k: usize| 0.5 + ((k + 1) * 7919 % 65_521) as f32 / 65_521.0;
            let mut l: Vec<f32> = (0..w * w).map(|k| -number(k) / w as f32).collect();
            (0..w).for_each(|k| l[k * w + k] = 1.0 + number(k));
            let inverse: Vec<f32> = (0..w).map(|k| 1.0 / l[k * w + k]).collect();
            let b: Vec<f32> = (0..rows * w).map(|k| -number(3 * k)).collect();
            let mut x = b.clone();
            solve_right(&mut x, rows, &l, &inverse);
            for row in 0..rows {
                let mut exact = vec![0.0f64; w];
                for j in 0..w {
                    let before = |k: usize| exact[k] * f64::from(l[k * w + j]);
                    let sum: f64 = (0..j).map(before).sum();
                    exact[j] = (f64::from(b[j * rows + row]) - sum) / f64::from(l[j * w + j]);
                    let error = (f64::from(x[j * rows + row]) / exact[j] - 1.0).abs();
                    let bound = (j * j / 2 + 3 * j + 3) as f64 * f64::from(f32::EPSILON) / 2.0;
                    assert!(error <= bound, "{rows} {w}: ({row}, {j}) is off by {error:e}");
                }
            }
        }
    }
}
