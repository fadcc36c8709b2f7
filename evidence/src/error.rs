//! What ends a measurement early.

use std::path::PathBuf;

use dempfv::InputError;

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the library, or of a program that ours is compared with.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The library says no.
    #[error(transparent)]
    Library(#[from] dempfv::Error),
    /// Another program is not there, or did not do what it was asked.
    #[error("{step}: {what}{}", kept(.log))]
    Peer {
        /// Step of the comparison, by name.
        step: String,
        /// What happened, and what would help.
        what: String,
        /// File that holds what the program printed.
        log: Option<PathBuf>,
    },
    /// A comparison ran to its end, and something lies outside its bounds.
    #[error("{count} outside the bounds, in {}", page.display())]
    Differs {
        /// Number of quantities.
        count: usize,
        /// The report that names them.
        page: PathBuf,
    },
}

impl Error {
    /// Whether what the user wrote is wrong.
    pub fn is_input(&self) -> bool {
        matches!(self, Error::Library(error) if error.is_input())
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Error::Library(error.into())
    }
}

impl From<dempfv::io::IoError> for Error {
    fn from(error: dempfv::io::IoError) -> Self {
        Error::Library(error.into())
    }
}

fn kept(log: &Option<PathBuf>) -> String {
    log.as_ref().map_or(String::new(), |log| format!("; what it printed is in {}", log.display()))
}
