//! What ends the program early.

use dempfv::InputError;

use crate::evidence;

/// An error of the library, or of the measurements.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The library says no.
    #[error(transparent)]
    Library(#[from] dempfv::Error),
    /// A measurement failed.
    #[error(transparent)]
    Evidence(#[from] evidence::Error),
}

impl Error {
    /// Whether what the user wrote is wrong (exit status 2).
    pub fn is_input(&self) -> bool {
        match self {
            Error::Library(error) => error.is_input(),
            Error::Evidence(error) => error.is_input(),
        }
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
