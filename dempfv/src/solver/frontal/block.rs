//! Dense blocks of a front.

/// Columns whose triangle on the diagonal is kept as its inverse.
pub const PIVOT_BLOCK: usize = 32;

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
