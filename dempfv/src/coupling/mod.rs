//! The time step of [`dem`](crate::dem) and [`pfv`](crate::pfv) together.
//!
//! [`Coupled`] advances spheres and fluid by one step; it knows no scene. What
//! may change between two steps goes through its [`Controls`]; its
//! [`CoupledState`] is all that a restart needs.
//!
//! What makes a coupled run faster is an [`Acceleration`]:
//! networks that are built in the background while the steps go on, and tasks
//! beside each other. Each can be used alone, and none changes a bit of the
//! results but by the moment at which a network comes into use.

mod active_network;
mod auto_interval;
mod auto_step;
mod background;
mod controls;
mod counts;
mod coupled;
mod edge_step;
mod edges;
mod error;
mod fluid_effects;
mod fluid_state;
mod fluid_step;
mod given_pressures;
mod gpu_use;
mod network_builder;
mod network_change;
mod network_comparison;
mod network_source;
mod new_network;
mod observe;
mod options;
mod phases;
mod pore_pressures;
mod remesh_due;
mod remesher;
mod saturation;
mod state;
mod time_step;
mod viscous_bound;

pub use active_network::PRESSURE_ERROR;
pub use controls::Controls;
pub use counts::{IntervalTrail, RemeshCounts, UnmetTolerance, UpdateCounts};
pub use coupled::Coupled;
pub use edges::EdgeEffects;
pub use error::CouplingError;
pub use fluid_effects::FluidEffects;
pub use gpu_use::GpuUse;
pub use network_builder::{BackendBuilder, NetworkBuilder, NetworkRequest, StandardBuilder};
pub(crate) use network_change::NetworkChange;
pub use observe::{CellObservation, Observation};
pub use options::{Acceleration, OnFailure, RemeshMode, Swap, Update};
pub use phases::{Phase, Phases};
pub use saturation::{RemeshRule, Saturation};
pub use state::{CoupledState, Parameters};
pub use time_step::{TimeStepBounds, TimeStepRule, viscous_time_step};

/// What the effects of this room say of themselves.
pub mod effects {
    pub use crate::coupling::background::EFFECT as BACKGROUND_REMESH;
    pub use crate::coupling::edges::{
        NORMAL_LUBRICATION, PUMP_TORQUE, SHEAR_LUBRICATION, TWIST_TORQUE, VISCOUS_SHEAR,
    };
    pub use crate::coupling::fluid_effects::{IMPOSED_REGIONS, IN_TIME, ONE_WAY};
    pub use crate::coupling::options::{EVERY_STEP, PARALLEL_TASKS};
}
