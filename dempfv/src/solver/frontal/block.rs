//! Dense blocks of a front.

/// Columns whose triangle on the diagonal is kept as its inverse.
pub const PIVOT_BLOCK: usize = 32;

/// Rows of a block: what a solve keeps in registers while it goes through a pivot block.
pub const BLOCK_ROWS: usize = 64;

/// Words that a column takes for so many rows. Word k of a block of n words holds rows k
/// and k + n.
#[inline(always)]
pub fn words(rows: usize) -> usize {
    rows.div_ceil(2)
}

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
