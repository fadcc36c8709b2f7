//! Results as JSON.

use std::path::Path;

use dempfv::io::atomic;
use dempfv::{Error, Result};
use serde::Serialize;

/// A report as JSON, indented.
///
/// # Errors
/// [`Error::Io`] when it has no form in JSON, as a map whose keys are no text.
pub fn text<R: Serialize>(report: &R) -> Result<String> {
    serde_json::to_string_pretty(report).map_err(|e| Error::io("JSON report", e.into()))
}

/// Writes a report as JSON: beside its place, then renamed into it, so that no reader
/// meets half a file. What is no regular file (a pipe, `/dev/null`) is written directly.
///
/// # Errors
/// [`Error::Io`] when the file cannot be written.
pub fn write<R: Serialize>(path: &Path, report: &R) -> Result<()> {
    let text = text(report)? + "\n";
    let special = path.metadata().is_ok_and(|m| !m.is_file());
    if special {
        return std::fs::write(path, text).map_err(|e| Error::io(path, e));
    }
    Ok(atomic::write(path, text.as_bytes())?)
}
