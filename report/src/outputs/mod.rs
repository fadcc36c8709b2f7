//! What results hold: every key of `summary.json`, every column and every array of the other files,
//! with unit, sign and definition. The program takes the names of arrays and columns from here (those of
//! the history stand beside their values, in [`dempfv::simulation::history`]), and `docs/outputs.md` is
//! written from it.

pub mod frames;
mod page;
mod stages;
pub mod summary;
pub mod tables;

pub use page::page;

/// A key, a column or an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` for a number without one, empty for what is no number.
    pub unit: &'static str,
    /// What it is, and when it is positive.
    pub meaning: &'static str,
}

const fn entry(name: &'static str, unit: &'static str, meaning: &'static str) -> Entry {
    Entry { name, unit, meaning }
}
