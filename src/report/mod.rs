//! What the program shows: progress while it runs, pictures and tables after.

pub mod plot;
pub mod progress;
pub mod table;
