//! Matrix Market files (Boisvert, Pozo and Remington 1996): symmetric matrices
//! and vectors.
//!
//! Read are `coordinate` and `array` files with `real` or `integer` values that
//! are `symmetric`, or `general` with a symmetric content. Rows and columns
//! are counted from 1 in the file and in messages about it.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use super::atomic;
use super::number::number;
use crate::excerpt::excerpt;
use crate::input::InputError;
use crate::io::IoError;
use crate::io::error::Result;
use crate::solver::SymmetricCsc;

const FIRST_LINE: &str = "the first line must be `%%MatrixMarket matrix \
                          coordinate|array real|integer symmetric|general`";

/// Two mirrored entries of a `general` file may differ by this part of the
/// larger one: what printing leaves of a symmetric matrix.
const SYMMETRY_TOLERANCE: f64 = 1e-12;

/// Reads a symmetric matrix. Entries that a file leaves out are zero, on the
/// diagonal too. Of a `general` file the lower triangle is taken.
///
/// # Errors
/// An [`InputError`] with file and line if the file cannot be read or is not as
/// described, the matrix is not square or not symmetric.
pub fn read_matrix(path: &Path) -> Result<SymmetricCsc> {
    let file = File::read(path)?;
    if file.rows != file.columns {
        let what = format!("the matrix has {} rows and {} columns", file.rows, file.columns);
        return Err(file.wrong(file.size_line, what, "a symmetric matrix is square"));
    }
    let lower = if file.symmetric { file.mirrored_down()? } else { file.symmetric_part()? };
    Ok(compress(file.rows, &lower))
}

/// Reads a vector of `n` entries: a matrix of one column. Entries that a `coordinate` file leaves
/// out are zero.
///
/// # Errors
/// As [`read_matrix`], and if the file has another size.
pub fn read_vector(path: &Path, n: usize) -> Result<Vec<f64>> {
    let file = File::read(path)?;
    if file.rows != n || file.columns != 1 {
        let what = format!("the right-hand side is {} x {}", file.rows, file.columns);
        return Err(file.wrong(
            file.size_line,
            what,
            &format!("it must be {n} x 1, as the matrix is"),
        ));
    }
    let mut vector = vec![0.0; n];
    for entry in file.sorted_entries()? {
        vector[entry.row] = entry.value;
    }
    Ok(vector)
}

/// Writes a matrix as `coordinate real symmetric`; reading it again gives the
/// same bits.
///
/// # Errors
/// [`IoError::File`] if the file cannot be written; an [`InputError`] for a matrix that is none
/// ([`SymmetricCsc::validate`]).
pub fn write_matrix(path: &Path, a: &SymmetricCsc) -> Result<()> {
    a.validate().map_err(|e| InputError::new(format!("no matrix to write: {e}"), ""))?;
    atomic::write_with(path, |file| {
        writeln!(file, "%%MatrixMarket matrix coordinate real symmetric")?;
        writeln!(file, "{} {} {}", a.n, a.n, a.nnz())?;
        for j in 0..a.n {
            for k in a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize {
                writeln!(file, "{} {} {:e}", a.row_idx[k] + 1, j + 1, a.values[k])?;
            }
        }
        Ok(())
    })
}

/// Writes a vector as `array real general`; reading it again gives the same
/// bits.
///
/// # Errors
/// [`IoError::File`] if the file cannot be written; an [`InputError`] for a vector that is empty
/// or has an entry that is not finite, which would not read back.
pub fn write_vector(path: &Path, vector: &[f64]) -> Result<()> {
    if vector.is_empty() {
        return Err(
            InputError::new("the vector to write is empty", "give one entry or more").into()
        );
    }
    if let Some(k) = vector.iter().position(|v| !v.is_finite()) {
        let what = format!("entry {k} of the vector to write is {}", vector[k]);
        return Err(InputError::new(what, "give finite numbers").into());
    }
    atomic::write_with(path, |file| {
        writeln!(file, "%%MatrixMarket matrix array real general")?;
        writeln!(file, "{} 1", vector.len())?;
        vector.iter().try_for_each(|value| writeln!(file, "{value:e}"))
    })
}

/// One entry, counted from 0, and the line it stands on, counted from 1.
#[derive(Clone, Copy)]
struct Entry {
    column: usize,
    row: usize,
    value: f64,
    line: usize,
}

/// What a file says, unsorted.
struct File<'a> {
    path: &'a Path,
    symmetric: bool,
    rows: usize,
    columns: usize,
    size_line: usize,
    entries: Vec<Entry>,
}

impl<'a> File<'a> {
    fn read(path: &'a Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(|e| {
            InputError::new(format!("cannot be read: {e}"), "name a Matrix Market file")
                .in_file(path)
        })?;
        // Comments may be in any encoding.
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let mut file =
            File { path, symmetric: false, rows: 0, columns: 0, size_line: 0, entries: Vec::new() };
        let coordinate = file.read_first_line(text.lines().next().unwrap_or_default())?;
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
        if coordinate {
            file.read_coordinates(&mut lines)?
        } else {
            file.read_array(&mut lines)?
        }
        match lines.next() {
            None => Ok(file),
            Some((line, text)) => Err(file.wrong(
                line,
                format!("`{}` after the last entry", excerpt(text)),
                "the file must end after as many entries as its size line says",
            )),
        }
    }

    /// Reads the banner; true for a `coordinate` file.
    fn read_first_line(&mut self, line: &str) -> Result<bool> {
        let words: Vec<String> = line.split_whitespace().map(str::to_ascii_lowercase).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let &["%%matrixmarket", "matrix", layout, field, symmetry] = words.as_slice() else {
            return Err(self.wrong(1, "this is no Matrix Market file".to_owned(), FIRST_LINE));
        };
        let known = matches!(layout, "coordinate" | "array")
            && matches!(field, "real" | "integer")
            && matches!(symmetry, "symmetric" | "general");
        if !known {
            let kind = excerpt(&format!("{layout} {field} {symmetry}"));
            let what = format!("cannot solve with a `{kind}` matrix");
            return Err(self.wrong(1, what, FIRST_LINE));
        }
        self.symmetric = symmetry == "symmetric";
        Ok(layout == "coordinate")
    }

    /// Reads the sizes: as many numbers as there are names.
    fn read_sizes<'t, const N: usize>(
        &mut self,
        lines: &mut impl Iterator<Item = (usize, &'t str)>,
        names: &str,
    ) -> Result<[usize; N]> {
        let Some((line, text)) = lines.next() else {
            return Err(self.wrong(
                1,
                "the size line is missing".to_owned(),
                &format!("it must give {names}"),
            ));
        };
        self.size_line = line;
        let sizes: Option<Vec<usize>> =
            text.split_whitespace().map(|word| word.parse().ok()).collect();
        let sizes: Option<[usize; N]> = sizes.and_then(|sizes| sizes.try_into().ok());
        sizes.ok_or_else(|| {
            let what = format!("`{}` is no size line", excerpt(text));
            self.wrong(line, what, &format!("it must give {names}"))
        })
    }

    fn read_coordinates<'t>(
        &mut self,
        lines: &mut impl Iterator<Item = (usize, &'t str)>,
    ) -> Result<()> {
        let names = "the numbers of rows, columns and entries";
        let [rows, columns, count] = self.read_sizes(lines, names)?;
        (self.rows, self.columns) = (rows, columns);
        // Also keeps a wrong size from asking for memory without end. A vector may be sparse: how
        // long it must be is known.
        if count < rows && columns != 1 {
            let what = format!("{count} entries cannot fill the {rows} rows");
            return Err(self.wrong(self.size_line, what, "every row needs an entry"));
        }
        for k in 0..count {
            let (line, text) = self.next_entry(lines, k, count)?;
            let mut words = text.split_whitespace();
            let (Some(i), Some(j), Some(value), None) =
                (words.next(), words.next(), words.next(), words.next())
            else {
                let what = format!("`{}` is no entry", excerpt(text));
                return Err(self.wrong(line, what, "it must be row, column and value"));
            };
            let row = self.index(i, rows, "row", line)?;
            let column = self.index(j, columns, "column", line)?;
            let value = self.value(value, line)?;
            self.entries.push(Entry { column, row, value, line });
        }
        Ok(())
    }

    fn read_array<'t>(&mut self, lines: &mut impl Iterator<Item = (usize, &'t str)>) -> Result<()> {
        let [rows, columns] = self.read_sizes(lines, "the numbers of rows and columns")?;
        (self.rows, self.columns) = (rows, columns);
        if rows == 0 || columns == 0 || (self.symmetric && rows != columns) {
            let what = format!("{rows} rows and {columns} columns");
            let remedy = "a symmetric matrix is square, and none is empty";
            return Err(self.wrong(self.size_line, what, remedy));
        }
        let count = if self.symmetric {
            rows.saturating_mul(rows.saturating_add(1)) / 2
        } else {
            rows.saturating_mul(columns)
        };
        for column in 0..columns {
            for row in if self.symmetric { column } else { 0 }..rows {
                let (line, text) = self.next_entry(lines, self.entries.len(), count)?;
                let value = self.value(text, line)?;
                self.entries.push(Entry { column, row, value, line });
            }
        }
        Ok(())
    }

    /// The line of entry `k` of `count`.
    fn next_entry<'t>(
        &self,
        lines: &mut impl Iterator<Item = (usize, &'t str)>,
        k: usize,
        count: usize,
    ) -> Result<(usize, &'t str)> {
        lines.next().ok_or_else(|| {
            let last = self.entries.last().map_or(self.size_line, |entry| entry.line);
            self.wrong(
                last,
                format!("the file ends after {k} entries"),
                &format!("its size line says {count}"),
            )
        })
    }

    fn index(&self, word: &str, size: usize, name: &str, line: usize) -> Result<usize> {
        match word.parse::<usize>() {
            Ok(index) if (1..=size).contains(&index) => Ok(index - 1),
            _ => Err(self.wrong(
                line,
                format!("{name} {} does not exist", excerpt(word)),
                &format!("{name}s count from 1 to {size}"),
            )),
        }
    }

    fn value(&self, word: &str, line: usize) -> Result<f64> {
        number(word, "").map_err(|_| {
            let what = format!("the value `{}`", excerpt(word));
            self.wrong(line, what, "it must be one finite number")
        })
    }

    fn wrong(&self, line: usize, what: String, remedy: &str) -> IoError {
        InputError::new(what, remedy).in_file(self.path).at_line(line).into()
    }

    /// The entries by columns and rows, each at most once.
    fn sorted_entries(&self) -> Result<Vec<Entry>> {
        sort_unique(self, self.entries.clone())
    }

    /// The lower triangle of a `symmetric` file, which may hold either half of
    /// each pair.
    fn mirrored_down(&self) -> Result<Vec<Entry>> {
        let down =
            |e: &Entry| Entry { column: e.column.min(e.row), row: e.column.max(e.row), ..*e };
        sort_unique(self, self.entries.iter().map(down).collect())
    }

    /// The lower triangle of a `general` file, after a look at the upper one.
    fn symmetric_part(&self) -> Result<Vec<Entry>> {
        let entries = self.sorted_entries()?;
        for e in &entries {
            let mirror = entries
                .binary_search_by_key(&(e.row, e.column), |m| (m.column, m.row))
                .map_or(0.0, |k| entries[k].value);
            if (e.value - mirror).abs() > SYMMETRY_TOLERANCE * e.value.abs().max(mirror.abs()) {
                let (i, j) = (e.row + 1, e.column + 1);
                let what =
                    format!("entry ({i}, {j}) is {} but entry ({j}, {i}) is {mirror}", e.value);
                return Err(self.wrong(e.line, what, "the matrix must be symmetric"));
            }
        }
        Ok(entries.into_iter().filter(|e| e.row >= e.column).collect())
    }
}

fn sort_unique(file: &File<'_>, mut entries: Vec<Entry>) -> Result<Vec<Entry>> {
    entries.sort_by_key(|e| (e.column, e.row, e.line));
    let twice = entries.windows(2).find(|e| (e[0].column, e[0].row) == (e[1].column, e[1].row));
    match twice {
        None => Ok(entries),
        Some(e) => {
            let what = format!(
                "entry ({}, {}) was given on line {} already",
                e[1].row + 1,
                e[1].column + 1,
                e[0].line
            );
            Err(file.wrong(e[1].line, what, "give each entry once"))
        }
    }
}

/// Compresses a sorted lower triangle, with zeros for the diagonal entries
/// that are missing.
fn compress(n: usize, lower: &[Entry]) -> SymmetricCsc {
    let mut a = SymmetricCsc { n, ..Default::default() };
    a.col_ptr.reserve(n + 1);
    a.col_ptr.push(0);
    let mut rest = lower;
    for j in 0..n {
        let (column, after) = rest.split_at(rest.partition_point(|e| e.column == j));
        rest = after;
        if column.first().is_none_or(|e| e.row != j) {
            a.row_idx.push(j as i64);
            a.values.push(0.0);
        }
        a.row_idx.extend(column.iter().map(|e| e.row as i64));
        a.values.extend(column.iter().map(|e| e.value));
        a.col_ptr.push(a.row_idx.len() as i64);
    }
    a
}
