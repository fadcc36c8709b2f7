//! What a user wrote and what is wrong with it.

use std::path::PathBuf;

use crate::excerpt::harmless;

/// Something the user wrote is wrong: one message that says where, what, and
/// what would be right. Nothing was computed or written.
#[derive(Clone, Debug, PartialEq)]
pub struct InputError {
    /// File the input came from, if any.
    pub file: Option<PathBuf>,
    /// Line in that file, counted from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub what: String,
    /// What would be right.
    pub remedy: String,
}

impl InputError {
    /// An error that is not tied to a line of a file.
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        InputError { file: None, line: None, what: what.into(), remedy: remedy.into() }
    }

    /// Says in which file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<PathBuf>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Says on which line (from 1).
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }
}

/// What a file holds may be anything: no character of it reaches a terminal as a command.
impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(file) = &self.file {
            f.write_str(&harmless(&file.to_string_lossy()))?;
            if let Some(line) = self.line {
                write!(f, ":{line}")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(&harmless(&self.what))?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", harmless(&self.remedy))?;
        }
        Ok(())
    }
}

impl std::error::Error for InputError {}
