//! Scene files: what the user wrote, read and checked into a [`Plan`].
//!
//! This is the only room that reads scene files. A [`Plan`] is plain data; it knows
//! neither particles nor pores.

mod effects;
mod keys;
mod nearest;
mod packing_check;
mod parse;
mod plan;
mod rules;
mod table;

pub use keys::known_keys;
pub use packing_check::{load_packing, validate_packing};
pub use plan::{
    Cloud, Compact, Consolidate, Cycle, Dem, Fluid, Output, ParticleSource, Particles,
    Permeability, Plan, Run, SizeClass, Sizes, Stage, StageKind, TimeStep, Until, WallControl,
    Walls,
};
