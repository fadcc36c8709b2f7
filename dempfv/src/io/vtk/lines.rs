//! Lines between two points, as contacts are.

use std::path::Path;

use super::Cells;
use super::grid::{Array, Column, Grid};
use crate::Vec3;
use crate::io::error::Result;

/// What is known of lines; all slices have one entry per line.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineData<'a> {
    /// Numbers, by name.
    pub scalars: &'a [(&'a str, &'a [f64])],
    /// Vectors, by name.
    pub vectors: &'a [(&'a str, &'a [Vec3])],
}

/// Writes lines by their two ends (m). In ParaView: filter "Tube", its radius by one of the numbers.
///
/// # Errors
/// [`IoError::File`](crate::io::IoError::File) when the file cannot be written or the slices differ in
/// length; nothing partial remains.
pub fn write_lines(path: &Path, ends: &[[Vec3; 2]], data: &LineData) -> Result<()> {
    let scalars = data.scalars.iter().map(|&(name, v)| Column { name, array: Array::Scalars(v) });
    let vectors = data.vectors.iter().map(|&(name, v)| Column { name, array: Array::Vectors(v) });
    let cell_data: Vec<Column> = scalars.chain(vectors).collect();
    let cells = Cells::lines(ends.len());
    Grid { points: ends.as_flattened(), cells: &cells, point_data: &[], cell_data: &cell_data }
        .write(path)
}
