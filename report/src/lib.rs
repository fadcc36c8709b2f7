//! What reports are made of: progress while a program runs, pictures and tables after, and
//! the versions and the machine that they hold for.
//!
//! - [`plot`]: pictures, as SVG and PNG;
//! - [`table`](table()): tables for the terminal; [`markdown`]: tables for a page;
//! - [`format`](mod@format): quantities as people read them;
//! - [`progress`]: a line on the terminal while work goes on;
//! - [`json`], [`output`]: where results go; [`outputs`]: what they hold;
//! - [`machine`], [`versions`]: what a measurement depends on;
//! - [`memory`]: how much there is for a run.
#![warn(missing_docs)]

pub mod format;
pub mod json;
pub mod machine;
pub mod markdown;
pub mod memory;
pub mod output;
pub mod outputs;
pub mod plot;
pub mod progress;
mod table;
pub mod versions;

pub use table::table;
