//! The time step of [`dem`](crate::dem) and [`pfv`](crate::pfv) together.
//!
//! [`Coupled`] advances spheres and fluid by one step; it knows no scene.
//!
//! What makes a coupled run faster is an [`Acceleration`]:
//! networks that are built in the background while the steps go on, and tasks
//! beside each other. Each can be used alone, and none changes a bit of the
//! results but by the moment at which a network comes into use.

mod active_network;
mod auto_interval;
mod background;
mod coupled;
mod error;
mod gpu_use;
mod observe;
mod options;
mod phases;
mod remesh;
mod remesher;
mod time_step;
mod viscous_bound;

pub use active_network::PRESSURE_ERROR;
pub use background::{NetworkBuilder, Order, StandardBuilder};
pub use coupled::{Coupled, Saturation};
pub use error::CouplingError;
pub use gpu_use::GpuUse;
pub use observe::Observation;
pub use options::{Acceleration, OnFailure, RemeshMode, Swap, Update};
pub use phases::{Phase, Phases};
pub use remesh::{FluidState, IntervalTrail, RemeshCounts, RemeshRule, UpdateCounts};
pub(crate) use remesher::with_users_numbers;

pub use time_step::{TimeStepBounds, TimeStepRule, viscous_time_step};
