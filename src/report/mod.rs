//! What the program shows: progress while it runs.

pub mod progress;
