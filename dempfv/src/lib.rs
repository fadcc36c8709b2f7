#![doc = include_str!("../README.md")]
#![warn(missing_docs)]

mod calls;
pub mod coupling;
pub mod dem;
mod domain;
mod effect;
mod error;
mod excerpt;
mod input;
pub mod io;
mod parallel;
pub mod pfv;
pub mod scene;
pub mod simulation;
pub mod solver;
mod stage_error;
pub mod theory;
mod time_function;

pub use calls::Calls;
pub use domain::{Aabb, Axis, Cell, CellError, PerWall, Tensor, UnknownWall, Vec3, WallId};
pub use domain::{deviatoric_stress, mean_stress};
pub use effect::{Effect, EffectKey, Family};
pub use error::{Error, Result};
pub use input::InputError;
pub use time_function::TimeFunction;
