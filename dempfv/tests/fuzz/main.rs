//! Hostile input: shipped scenes, packings, matrices and checkpoints with bytes flipped, numbers
//! replaced, lines doubled and cut, read and computed with. No input may panic, hang, ask for
//! memory without bounds, or give a result that is no number.
//!
//! `cargo test` tries some hundreds; `make fuzz` a million and more (`DEMPFV_INPUTS`), with other
//! draws for another `DEMPFV_SEED`. Of a failure, the input is kept and named.

mod allocator;
mod corpus;
mod harness;
mod mutate;
mod readers;
mod whole;
