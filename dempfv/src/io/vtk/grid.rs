//! One unstructured grid as VTK XML with appended raw data.

use std::io::{self, Write};
use std::path::Path;

use super::Cells;
use crate::Vec3;
use crate::io::IoError;
use crate::io::atomic;
use crate::io::error::Result;

/// An array of the file.
pub(super) enum Array<'a> {
    Scalars(&'a [f64]),
    Vectors(&'a [Vec3]),
    Ids(&'a [u32]),
    /// VTK wants cells' points and ends as signed 64-bit integers.
    Indices(&'a [u32]),
    Bytes(&'a [u8]),
}

/// A named array of point or cell data.
pub(super) struct Column<'a> {
    pub name: &'a str,
    pub array: Array<'a>,
}

/// All that a file holds.
pub(super) struct Grid<'a> {
    pub points: &'a [Vec3],
    pub cells: &'a Cells,
    pub point_data: &'a [Column<'a>],
    pub cell_data: &'a [Column<'a>],
}

impl Array<'_> {
    fn len(&self) -> usize {
        match self {
            Array::Scalars(v) => v.len(),
            Array::Vectors(v) => v.len(),
            Array::Ids(v) | Array::Indices(v) => v.len(),
            Array::Bytes(v) => v.len(),
        }
    }

    /// VTK's name of the type, number of components, bytes per entry.
    fn form(&self) -> (&'static str, usize, usize) {
        match self {
            Array::Scalars(_) => ("Float64", 1, 8),
            Array::Vectors(_) => ("Float64", 3, 24),
            Array::Ids(_) => ("UInt32", 1, 4),
            Array::Indices(_) => ("Int64", 1, 8),
            Array::Bytes(_) => ("UInt8", 1, 1),
        }
    }

    fn bytes(&self) -> u64 {
        (self.len() * self.form().2) as u64
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.bytes().to_le_bytes())?;
        match self {
            Array::Scalars(v) => v.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
            Array::Vectors(v) => {
                v.iter().flat_map(|x| x.iter()).try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }
            Array::Ids(v) => v.iter().try_for_each(|i| out.write_all(&i.to_le_bytes())),
            Array::Indices(v) => {
                v.iter().try_for_each(|&i| out.write_all(&i64::from(i).to_le_bytes()))
            }
            Array::Bytes(v) => out.write_all(v),
        }
    }
}

impl Grid<'_> {
    pub fn write(&self, path: &Path) -> Result<()> {
        self.check().map_err(|what| {
            IoError::file(path, io::Error::new(io::ErrorKind::InvalidInput, what))
        })?;
        atomic::write_with(path, |out| self.write_to(out))
    }

    /// A file whose arrays do not fit together would crash its reader.
    fn check(&self) -> Result<(), String> {
        let groups = [
            (self.point_data, self.points.len(), "points"),
            (self.cell_data, self.cells.len(), "cells"),
        ];
        for (columns, expected, of) in groups {
            if let Some(c) = columns.iter().find(|c| c.array.len() != expected) {
                return Err(format!(
                    "{} has {} values, not {expected} ({of})",
                    c.name,
                    c.array.len()
                ));
            }
        }
        match self.cells.connectivity.iter().find(|&&v| v as usize >= self.points.len()) {
            Some(v) => Err(format!("a cell names point {v} of {}", self.points.len())),
            None => Ok(()),
        }
    }

    fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let points = Column { name: "Points", array: Array::Vectors(self.points) };
        let topology = [
            Column { name: "connectivity", array: Array::Indices(&self.cells.connectivity) },
            Column { name: "offsets", array: Array::Indices(&self.cells.offsets) },
            Column { name: "types", array: Array::Bytes(&self.cells.types) },
        ];
        let sections: [(&str, &[Column]); 4] = [
            ("Points", std::slice::from_ref(&points)),
            ("Cells", &topology),
            ("PointData", self.point_data),
            ("CellData", self.cell_data),
        ];
        writeln!(out, "<?xml version=\"1.0\"?>")?;
        writeln!(
            out,
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
            self.points.len(),
            self.cells.len()
        )?;
        let mut offset = 0;
        for (section, columns) in sections {
            writeln!(out, "<{section}>")?;
            for column in columns {
                write_header(out, column, offset)?;
                offset += 8 + column.array.bytes();
            }
            writeln!(out, "</{section}>")?;
        }
        write!(out, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_")?;
        for column in sections.iter().flat_map(|(_, columns)| columns.iter()) {
            column.array.write(out)?;
        }
        writeln!(out, "\n</AppendedData>\n</VTKFile>")
    }
}

fn write_header(out: &mut impl Write, column: &Column, offset: u64) -> io::Result<()> {
    let (kind, components, _) = column.array.form();
    writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{components}\" \
         format=\"appended\" offset=\"{offset}\"/>",
        escape(column.name)
    )
}

/// Text as an XML attribute's value.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The text whose [`escape`] this is.
pub(super) fn unescape(text: &str) -> String {
    text.replace("&quot;", "\"").replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&")
}
