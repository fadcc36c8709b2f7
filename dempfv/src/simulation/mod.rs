//! A scene carried out: stages, model time, outcomes, what it will cost.
//!
//! [`Simulation`] carries out a [`Plan`](crate::scene::Plan): it is advanced step by step by its
//! caller, who may look at it, save its [`SimulationState`] or stop between any two.
//!
//! ```no_run
//! use std::path::Path;
//! use dempfv::scene::Plan;
//! use dempfv::simulation::Simulation;
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

mod advice;
mod clock;
mod conditions;
mod controlled_steps;
mod error_control;
mod error_estimate;
mod estimate;
mod fingerprint;
mod grading;
pub mod history;
mod look_ahead;
mod outcome;
mod phase_costs;
mod restart;
mod run;
mod setup;
mod specimen;
mod stability;
mod stages;
mod state;
mod warning;

pub use crate::stage_error::StageError;
pub use advice::{Advice, Verdict};
pub use conditions::check_conditions;
pub use error_control::ErrorControl;
pub use error_estimate::ErrorEstimate;
pub use estimate::{Estimate, UnstableStage};
pub use grading::{Grading, GradingClass};
pub use outcome::{
    CellState, Compaction, Consolidation, ConsolidationSample, FlowTest, LoadCycles, Outcome,
    PermeabilityTest, Profile, StageOutcome, StressPath, StressPathSample,
};
pub use restart::{Change, Effect, Restart};
pub use run::Simulation;
pub use setup::initial_packing;
pub use specimen::Specimen;
pub use stability::Stability;
pub use state::SimulationState;
pub use warning::{BondsUnderLoad, LateLoad, ServoMissed, Warning};
