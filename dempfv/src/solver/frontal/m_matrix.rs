//! The matrix of a network: a symmetric diagonally dominant M-matrix, as sizes of its off-diagonal
//! entries and row sums, which determine it to full relative accuracy (Alfa, Xue and Ye 2002).

use rayon::prelude::*;

use crate::solver::{SolverError, SymmetricCsc};

/// Rows that one task works through.
const TASK_ROWS: usize = 4096;

/// The whole matrix by rows: sizes of the entries off the diagonal, and sums
/// of rows.
#[derive(Default)]
pub struct MMatrix {
    start: Vec<u32>,
    column: Vec<u32>,
    /// Which entry of the matrix each one is.
    source: Vec<u32>,
    magnitude: Vec<f64>,
    row_excess: Vec<f64>,
    /// Power of two that brings the largest diagonal entry near 1.
    pub scale: f64,
}

impl MMatrix {
    /// Takes the values of a matrix; its pattern stays that of the first one.
    ///
    /// # Errors
    /// An entry off the diagonal is positive or not finite, or the sum of a
    /// row is negative beyond round-off.
    pub fn update(&mut self, a: &SymmetricCsc) -> Result<(), SolverError> {
        a.check_finite()?;
        if self.start.is_empty() {
            self.take_pattern(a);
        }
        let mut largest = 0.0f64;
        for column in 0..a.n {
            let range = a.col_ptr[column] as usize..a.col_ptr[column + 1] as usize;
            let diagonal = a.values[range.start];
            if diagonal <= 0.0 {
                return Err(SolverError::NotPositiveDefinite { column });
            }
            largest = largest.max(diagonal);
            for k in range.start + 1..range.end {
                if a.values[k] > 0.0 {
                    let row = a.row_idx[k] as usize;
                    return Err(SolverError::PositiveOffDiagonal {
                        row,
                        column,
                        value: a.values[k],
                    });
                }
            }
        }
        self.scale = (-largest.log2().round()).exp2();
        let MMatrix { start, source, magnitude, row_excess, .. } = self;
        for (magnitude, &k) in magnitude.iter_mut().zip(&*source) {
            *magnitude = -a.values[k as usize];
        }
        for (row, row_excess) in row_excess.iter_mut().enumerate() {
            let diagonal = a.values[a.col_ptr[row] as usize];
            let off = &magnitude[start[row] as usize..start[row + 1] as usize];
            let sum = diagonal - off.iter().sum::<f64>();
            // Half a unit in the last place for each addition, of whoever summed the
            // diagonal entry up and of the sum here, and one for the difference.
            let round_off = (off.len() + 1) as f64 * f64::EPSILON * diagonal;
            if sum < -round_off {
                return Err(SolverError::NotDominant { row, sum, diagonal });
            }
            *row_excess = if sum <= round_off { 0.0 } else { sum };
        }
        Ok(())
    }

    fn take_pattern(&mut self, a: &SymmetricCsc) {
        let n = a.n;
        let mut start = vec![0u32; n + 1];
        let entries =
            |column: usize| a.col_ptr[column] as usize + 1..a.col_ptr[column + 1] as usize;
        for column in 0..n {
            for k in entries(column) {
                start[column + 1] += 1;
                start[a.row_idx[k] as usize + 1] += 1;
            }
        }
        for k in 0..n {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        let all = start[n] as usize;
        let (mut columns, mut source) = (vec![0; all], vec![0; all]);
        for column in 0..n {
            for k in entries(column) {
                let row = a.row_idx[k] as usize;
                for (from, to) in [(column, row), (row, column)] {
                    columns[next[from] as usize] = to as u32;
                    source[next[from] as usize] = k as u32;
                    next[from] += 1;
                }
            }
        }
        *self = MMatrix {
            start,
            column: columns,
            source,
            magnitude: vec![0.0; all],
            row_excess: vec![0.0; n],
            scale: 1.0,
        };
    }

    /// Values of the matrix in single precision and scaled, and the row sums
    /// in the order of elimination.
    pub fn scaled(&self, a: &SymmetricCsc, order: &[u32]) -> (Vec<f32>, Vec<f32>) {
        let scale = self.scale;
        let values = a.values.iter().map(|v| (v * scale) as f32).collect();
        let row_excess =
            order.iter().map(|&k| (self.row_excess[k as usize] * scale) as f32).collect();
        (values, row_excess)
    }

    /// r = b - A x, from differences of unknowns: a large entry between unknowns
    /// of nearly one value does not drown the small ones.
    pub fn residual(&self, b: &[f64], x: &[f64], r: &mut [f64]) {
        r.par_chunks_mut(TASK_ROWS).enumerate().for_each(|(chunk, r)| {
            for (row, r) in (chunk * TASK_ROWS..).zip(r) {
                let range = self.start[row] as usize..self.start[row + 1] as usize;
                let mut sum = b[row] - self.row_excess[row] * x[row];
                for (&column, magnitude) in
                    self.column[range.clone()].iter().zip(&self.magnitude[range])
                {
                    sum += magnitude * (x[column as usize] - x[row]);
                }
                *r = sum;
            }
        });
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        4 * (self.start.len() + self.column.len() + self.source.len())
            + 8 * (self.magnitude.len() + self.row_excess.len())
    }
}
