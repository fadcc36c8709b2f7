//! What holds of every packing that can be drawn: random ones, and those at which geometry breaks.
//! What has no network or no flow is refused in words.

#[path = "../common/mod.rs"]
mod common;

mod coupled;
mod packings;
mod static_flow;
