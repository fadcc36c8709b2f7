//! Work on several threads with the same bits for any number of them, and what makes memory
//! and processors faster without changing a result.
//!
//! This is the only place that decides in which order results of threads are joined.

mod blocks;
mod huge_pages;
mod max_norm;
mod prefetch;
mod spin;
mod tasks;

pub use blocks::{BLOCK, Span, block_count, cut, cut_mut, for_blocks};
pub use huge_pages::advise_huge_pages;
pub use max_norm::max_norm;
pub use prefetch::prefetch;
pub use spin::spinning;
pub use tasks::{SERIAL, TASK, for_each, in_tasks, parts, runs, sum_of, with_pores};
