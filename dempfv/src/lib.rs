#![doc = include_str!("../README.md")]
#![warn(missing_docs)]

mod awake;
pub mod coupling;
pub mod dem;
mod domain;
mod error;
mod fetch;
pub mod io;
mod pages;
pub mod pfv;
pub mod scene;
mod size;
pub mod solver;
pub mod theory;
mod time_step;

pub use domain::{Aabb, UnknownWall, Vec3, WallId};
pub use error::{Error, InputError, Result};
