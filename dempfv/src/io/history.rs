//! The history of a run: a CSV table that grows while the run goes on.

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::excerpt::excerpt;
use crate::input::InputError;
use crate::io::IoError;
use crate::io::atomic;
use crate::io::error::Result;

/// Rows reach the file at least this often (and when the table is dropped).
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);
/// Bytes of rows kept before they are written whatever the time.
const FLUSH_BYTES: usize = 1 << 16;

/// One cell of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A number, written with the shortest decimals that read back to the
    /// same bits; NaN and infinities as `NaN`, `inf`, `-inf`.
    Float(f64),
    /// A count.
    Count(u64),
    /// A name. Commas, quotes and line breaks become blanks, so that any
    /// reader may split lines at commas.
    Text(&'a str),
}

impl From<f64> for Value<'_> {
    fn from(value: f64) -> Self {
        Value::Float(value)
    }
}

impl From<u64> for Value<'_> {
    fn from(value: u64) -> Self {
        Value::Count(value)
    }
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(value: &'a str) -> Self {
        Value::Text(value)
    }
}

/// Writes `history.csv`: a header, then one row at a time. The file can be
/// read while the run goes on, holds whole rows only, and keeps what it has
/// if the run dies.
///
/// ```
/// use dempfv::io::history::History;
/// let path = std::env::temp_dir().join("dempfv-doc-history.csv");
/// let mut history = History::create(&path, &["step", "time_s", "stage"])?;
/// history.row(&[7_u64.into(), 0.5.into(), "load".into()])?;
/// drop(history);
/// assert_eq!(std::fs::read_to_string(&path).unwrap(), "step,time_s,stage\n7,0.5,load\n");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), dempfv::Error>(())
/// ```
#[derive(Debug)]
pub struct History {
    file: File,
    path: PathBuf,
    columns: usize,
    pending: Vec<u8>,
    /// Bytes of whole rows in the file.
    written: u64,
    flushed: Instant,
    last_step: Option<u64>,
}

impl History {
    /// Starts a table; an existing file is replaced. A column's name ends in
    /// its unit where it has one (`time_s`, `wall_stress_y_max_pa`).
    ///
    /// # Errors
    /// [`IoError::File`] when the file cannot be written; [`InputError`] for
    /// names that would tear the header apart.
    pub fn create(path: &Path, columns: &[&str]) -> Result<History> {
        let torn = |name: &&str| name.is_empty() || name.contains([',', '"', '\n', '\r']);
        if columns.is_empty() || columns.iter().any(torn) {
            let what = format!("`columns` {columns:?} make no header");
            let remedy = "give one name or more, without commas, quotes and line breaks";
            return Err(InputError::new(what, remedy).into());
        }
        let head = header(columns);
        // Whoever is killed in between leaves no table without a header.
        atomic::write(path, &head)?;
        let file = OpenOptions::new().append(true).open(path);
        let file = file.map_err(|e| IoError::file(path, e))?;
        Ok(History::on(file, path, columns.len(), Kept { bytes: head.len(), last_step: None }))
    }

    /// Goes on with the table of an earlier run: drops a torn last line and
    /// all rows whose `step_column` is above `last_step` (they were written
    /// after the checkpoint that the run restarts from), then appends. Starts
    /// the table if there is no file.
    ///
    /// # Errors
    /// [`InputError`] when the file's columns are not these or a row has no
    /// step; [`IoError::File`] when the file cannot be read or written.
    pub fn resume(
        path: &Path,
        columns: &[&str],
        step_column: &str,
        last_step: u64,
    ) -> Result<History> {
        let mut file = match OpenOptions::new().read(true).write(true).open(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return History::create(path, columns);
            }
            other => other.map_err(|e| IoError::file(path, e))?,
        };
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(|e| IoError::file(path, e))?;
        let kept =
            rows_up_to(&text, columns, step_column, last_step).map_err(|e| e.in_file(path))?;
        file.set_len(kept.bytes as u64)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(|e| IoError::file(path, e))?;
        Ok(History::on(file, path, columns.len(), kept))
    }

    fn on(file: File, path: &Path, columns: usize, kept: Kept) -> History {
        History {
            file,
            path: path.to_owned(),
            columns,
            pending: Vec::new(),
            written: kept.bytes as u64,
            flushed: Instant::now(),
            last_step: kept.last_step,
        }
    }

    /// Step of the last row that an earlier run has left; `None` where it left none.
    pub fn last_step(&self) -> Option<u64> {
        self.last_step
    }

    /// Appends a row. It reaches the file within a second of the rows after
    /// it, or on [`flush`](History::flush) or drop.
    ///
    /// # Errors
    /// [`IoError::File`] when the file cannot be written, or when the row has not
    /// one value per column.
    pub fn row(&mut self, values: &[Value]) -> Result<()> {
        if values.len() != self.columns {
            let what = format!("a row of {} values in {} columns", values.len(), self.columns);
            let error = std::io::Error::new(std::io::ErrorKind::InvalidInput, what);
            return Err(IoError::file(&self.path, error));
        }
        for (i, value) in values.iter().enumerate() {
            if i > 0 {
                self.pending.push(b',');
            }
            push(&mut self.pending, value);
        }
        self.pending.push(b'\n');
        if self.pending.len() >= FLUSH_BYTES || self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    /// Hands all rows so far to the system.
    ///
    /// # Errors
    /// [`IoError::File`] when the file cannot be written; the rows are kept for the next time.
    pub fn flush(&mut self) -> Result<()> {
        self.flushed = Instant::now();
        if let Err(e) = self.file.write_all(&self.pending) {
            // Readers meet whole rows only.
            let _ = self.file.set_len(self.written);
            let _ = self.file.seek(SeekFrom::End(0));
            return Err(IoError::file(&self.path, e));
        }
        self.written += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }
}

impl Drop for History {
    fn drop(&mut self) {
        // Nobody is left to tell; a caller that cares has called `flush`.
        let _ = self.flush();
    }
}

fn push(out: &mut Vec<u8>, value: &Value) {
    // Writing to a vector cannot fail.
    let _ = match *value {
        Value::Float(x) => write!(out, "{x:?}"),
        Value::Count(n) => write!(out, "{n}"),
        Value::Text(t) => {
            let plain = |b| if matches!(b, b',' | b'"' | b'\n' | b'\r') { b' ' } else { b };
            out.extend(t.bytes().map(plain));
            Ok(())
        }
    };
}

fn header(columns: &[&str]) -> Vec<u8> {
    let mut line = columns.join(",").into_bytes();
    line.push(b'\n');
    line
}

/// What a table of an earlier run has that stays.
struct Kept {
    bytes: usize,
    last_step: Option<u64>,
}

/// Names that a message has at most.
const MOST_NAMED: usize = 4;

/// What differs between a table's columns and those of a run.
fn other_columns(text: &[u8], columns: &[&str]) -> InputError {
    let line = text.split(|&b| b == b'\n').next().unwrap_or_default();
    let line = String::from_utf8_lossy(line);
    let found: Vec<&str> = line.trim_end().split(',').collect();
    let without = |all: &[&str], others: &[&str]| -> Vec<String> {
        let left = all.iter().filter(|name| !others.contains(name));
        left.map(|name| format!("`{}`", excerpt(name))).collect()
    };
    let (gone, new) = (without(&found, columns), without(columns, &found));
    let what = match (listed(&gone), listed(&new)) {
        (None, None) => "in another order".to_owned(),
        (Some(gone), None) => format!("the run has no {gone}"),
        (None, Some(new)) => format!("the table has no {new}"),
        (Some(gone), Some(new)) => format!("the table has {gone} where the run has {new}"),
    };
    InputError::new(
        format!("the table's columns are not those of this run: {what}"),
        "restart with the probes and other outputs that the table was begun with, or into another folder",
    )
}

/// The first of some names, and how many others there are; `None` for none.
fn listed(names: &[String]) -> Option<String> {
    let (first, others) = names.split_at(names.len().min(MOST_NAMED));
    let others =
        if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
    (!first.is_empty()).then(|| first.join(", ") + &others)
}

/// The rows of a table up to `last_step`.
fn rows_up_to(
    text: &[u8],
    columns: &[&str],
    step_column: &str,
    last_step: u64,
) -> Result<Kept, InputError> {
    let head = header(columns);
    if !text.starts_with(&head) {
        return Err(other_columns(text, columns).at_line(1));
    }
    let column = columns
        .iter()
        .position(|&c| c == step_column)
        .ok_or_else(|| InputError::new(format!("the table has no column `{step_column}`"), ""))?;
    let mut kept = Kept { bytes: head.len(), last_step: None };
    for (i, line) in text[kept.bytes..].split_inclusive(|&b| b == b'\n').enumerate() {
        if !line.ends_with(b"\n") {
            break;
        }
        let step = line.split(|&b| matches!(b, b',' | b'\n')).nth(column);
        let step = step.and_then(|s| std::str::from_utf8(s).ok()?.parse::<u64>().ok());
        let step = step.ok_or_else(|| {
            InputError::new(format!("the row has no {step_column}"), "restart into another folder")
                .at_line(i + 2)
        })?;
        if step > last_step {
            break;
        }
        kept.bytes += line.len();
        kept.last_step = Some(step);
    }
    Ok(kept)
}
