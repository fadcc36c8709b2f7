//! The time loop that joins [`dem`](crate::dem) and [`pfv`](crate::pfv), and
//! the stages that a scene asks for.
//!
//! [`Coupled`] advances spheres and fluid by one step. [`Simulation`] carries
//! out a [`Plan`](crate::scene::Plan): it is advanced step by step by its
//! caller, who may look at it, save its [`State`] or stop between any two.
//!
//! ```no_run
//! use std::path::Path;
//! use dempfv::coupling::Simulation;
//! use dempfv::scene::Plan;
//!
//! let plan = Plan::load(Path::new("scenes/oedometer.toml"))?;
//! let mut simulation = Simulation::new(plan)?;
//! while simulation.advance()? {
//!     if simulation.step() % 1000 == 0 {
//!         let seen = simulation.observe();
//!         assert!(seen.porosity > 0.0);
//!     }
//! }
//! # Ok::<(), dempfv::Error>(())
//! ```
//!
//! What makes a coupled run faster is an [`Acceleration`](crate::scene::Acceleration):
//! networks that are built in the background while the steps go on, and tasks
//! beside each other. Each can be used alone, and none changes a bit of the
//! results but by the moment at which a network comes into use.

mod auto_interval;
mod background;
mod clock;
mod coupled;
mod error;
mod gpu_use;
mod networks;
mod observe;
mod outcome;
mod phases;
mod remesh;
mod setup;
mod simulation;
mod stability;
mod stages;
mod wet;

pub use background::{NetworkBuilder, Order, StandardBuilder};
pub use coupled::{Coupled, Saturation};
pub use error::CouplingError;
pub use gpu_use::GpuUse;
pub use observe::Observation;
pub use outcome::{
    Compaction, Consolidation, ConsolidationSample, LoadCycles, Motion, MotionSample, Outcome,
    PermeabilityTest, Profile, StageOutcome,
};
pub use phases::{Phase, Phases};
pub use remesh::{FluidState, IntervalTrail, RemeshCounts, RemeshRule, UpdateCounts};
pub use setup::initial_packing;
pub use simulation::{Simulation, State};
pub use stability::Stability;
pub use wet::PRESSURE_ERROR;

pub use crate::time_step::{TimeStepBounds, TimeStepRule, viscous_time_step};
