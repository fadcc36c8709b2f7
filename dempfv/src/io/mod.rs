//! Files: packings, the history of a run, results for ParaView, checkpoints.
//!
//! Whatever is written in one go is written beside its place and renamed into
//! it ([`atomic`]), so a reader never meets half a file.

pub mod atomic;
pub mod checkpoint;
mod error;
pub mod history;
pub mod matrix_market;
mod number;
pub mod packing;
mod packing_layout;
pub mod vtk;

pub use error::IoError;
