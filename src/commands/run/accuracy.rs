//! The error that a run has kept to.

use std::fmt;

use dempfv::simulation::{ErrorEstimate, Simulation};
use serde::Serialize;

/// What was asked for, and the estimate.
#[derive(Serialize)]
pub struct Accuracy {
    target: f64,
    #[serde(flatten)]
    estimated: Option<Estimated>,
}

#[derive(Serialize)]
struct Estimated {
    estimated_error: f64,
    estimated_network_error: f64,
    estimated_time_step_error: f64,
    estimated_solver_error: f64,
}

impl Accuracy {
    /// `None` without `[accuracy]`.
    pub fn of(simulation: &Simulation) -> Option<Accuracy> {
        let target = simulation.error_control()?.target();
        let estimated = |ErrorEstimate { total, network, time_step, solver }| Estimated {
            estimated_error: total,
            estimated_network_error: network,
            estimated_time_step_error: time_step,
            estimated_solver_error: solver,
        };
        Some(Accuracy { target, estimated: simulation.error_estimate().map(estimated) })
    }
}

impl fmt::Display for Accuracy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error of the pore pressures: {:.2} % asked for", 100.0 * self.target)?;
        let Some(found) = &self.estimated else { return Ok(()) };
        write!(
            f,
            ", {:.2} % estimated ({:.2} % by networks, {:.2} % by steps)",
            100.0 * found.estimated_error,
            100.0 * found.estimated_network_error,
            100.0 * found.estimated_time_step_error
        )
    }
}
