//! Nothing is lost: runs that are killed, interrupted, starved of disk and of memory, and
//! checkpoints that are cut and spoilt. Each ends with its results sound and, where it goes on,
//! with the bytes of a run that nobody disturbed.
//!
//! `cargo test` tries some of each; `make torture` many, and prints how many. `DEMPFV_KILLS` and
//! its like set the numbers, `DEMPFV_SEED` draws others.
#![cfg(target_os = "linux")]

#[path = "../program/mod.rs"]
mod program;

mod allocations;
mod checkpoints;
mod disk;
mod folders;
mod kills;
mod preload;
mod signals;
mod specimen;
