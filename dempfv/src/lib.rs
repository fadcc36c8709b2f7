//! Saturated granular matter: spheres that collide and rub (discrete element
//! method, DEM) in a viscous fluid that flows through the pores between them
//! (pore-scale finite volumes, PFV).
//!
//! All quantities are in SI units. Stress and pressure are positive in
//! compression.
#![warn(missing_docs)]

pub mod coupling;
pub mod dem;
mod domain;
mod error;
pub mod io;
pub mod pfv;
pub mod scene;
pub mod solver;
pub mod theory;

pub use domain::{Aabb, UnknownWall, Vec3, WallId};
pub use error::{Error, InputError, Result};
