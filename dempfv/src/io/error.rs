//! What can be wrong with a file.

use std::io;
use std::path::PathBuf;

use crate::input::InputError;

/// A file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// What is in it is wrong.
    #[error(transparent)]
    Input(#[from] InputError),
    /// It could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl IoError {
    /// An error of the system, with the file that it concerns.
    pub fn file(path: impl Into<PathBuf>, source: io::Error) -> IoError {
        IoError::File { path: path.into(), source }
    }

    /// True when what is in the file is wrong.
    pub fn is_input(&self) -> bool {
        matches!(self, IoError::Input(_))
    }
}

/// The room's result type.
pub type Result<T, E = IoError> = std::result::Result<T, E>;
