//! Scene files: what the user wrote, read and checked into a [`Plan`].
//!
//! This is the only room that reads scene files. A [`Plan`] is plain data; it knows
//! neither spheres nor pores. Each table of a scene has a file: its struct with the defaults, its
//! keys, how they are read, checked and written, what must hold, and the names of its effects. A
//! new key is a field with its default, a word in the table's `SCHEMA`, and a line in its `keys`.

mod accuracy;
mod bonds;
mod cell;
mod choice;
mod clump;
mod contacts;
mod dem;
mod difference;
mod fluid;
mod fluid_conditions;
mod grading;
mod keys;
mod kind;
mod lubrication;
mod materials;
mod motion;
mod nearest;
mod output;
mod packing_check;
mod particles;
mod plan;
mod read;
mod region;
mod schema;
mod simulated;
mod sizes;
mod stage;
mod syntax;
mod table;
mod time_function;
mod wall_pressure;
mod walls;
mod watched;
mod wrong;

pub use crate::dem::{CellControl, CellControls, WallControl};
pub use accuracy::Accuracy;
pub use bonds::Bonds;
pub use cell::CellShape;
pub use choice::SphereChoice;
pub use contacts::{AdhesionModel, Contacts, NormalLaw, Turning};
pub use dem::{Dem, TimeStep};
pub(crate) use difference::stage_names;
pub use difference::{Difference, differences};
pub use fluid::Fluid;
pub use grading::{GradingCurve, LogNormal};
pub use materials::{OtherMaterial, Pair};
pub use motion::GivenMotion;
pub use output::Output;
pub use packing_check::{load_packing, load_periodic_packing, validate_packing};
pub use particles::{ParticleSource, Particles};
pub use plan::Plan;
pub use read::known_keys;
pub use sizes::{Cloud, SizeClass, Sizes};
pub(crate) use stage::control::with_value;
pub use stage::{
    Compact, Consolidate, Cycle, FlowOnly, Permeability, Run, Stage, StageKind, Until,
};
pub use walls::Walls;
pub use watched::SectionPlane;
