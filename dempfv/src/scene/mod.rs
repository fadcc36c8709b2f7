//! Scene files: what the user wrote, read and checked into a [`Plan`].
//!
//! This is the only room that reads scene files. A [`Plan`] is plain data; it knows
//! neither particles nor pores.

mod keys;
mod nearest;
mod parse;
mod plan;
mod rules;
mod table;

pub use plan::{
    Axis, Clamp, Cloud, Compact, Consolidate, Cycle, Dem, Fluid, Output, ParticleSource, Particles,
    Permeability, Plan, Run, SizeClass, Sizes, Solver, Stage, StageKind, TimeStep, Until,
    WallControl, Walls,
};
