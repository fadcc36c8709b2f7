//! Steps of two lengths from the same state on: what the length does to the pressures.

use super::error_control::{Difference, LOOK_STEPS};
use super::run::Simulation;
use super::state::SimulationState;
use crate::coupling::{OnFailure, RemeshMode, RemeshRule, Swap};
use crate::scene::{Plan, TimeStep};
use crate::{InputError, Result};

/// Steps between networks that nobody lives to see.
const NEVER: u64 = 1 << 40;
/// At most so many spheres are looked at, evenly by number.
const SPHERES: usize = 1_000;
/// How long before the end of its step a pressure belongs, in steps: velocities are those half a step
/// before the positions at its beginning.
const LAG: f64 = 1.5;

/// Pressures at spheres (Pa) at moments (s).
struct Course {
    times: Vec<f64>,
    pressures: Vec<Vec<f64>>,
}

/// The difference between the pressures of steps of `dt` (s) and of half of it, over a time of some of
/// them.
///
/// # Errors
/// As a restart or a step.
pub fn difference(plan: &Plan, state: &SimulationState, dt: f64) -> Result<Difference> {
    let until = state.time() + f64::from(LOOK_STEPS) * dt;
    let coarse = course(plan, state, dt, until)?;
    let fine = course(plan, state, 0.5 * dt, until)?;
    let (mut off, mut size, mut count) = (0.0, 0.0, 0.0);
    for (&time, pressures) in coarse.times.iter().zip(&coarse.pressures) {
        let after = fine.times.partition_point(|&t| t < time);
        let (Some(before), Some(there)) = (after.checked_sub(1), fine.pressures.get(after)) else {
            continue;
        };
        let step = fine.times[after] - fine.times[before];
        let share = (time - fine.times[before]) / step;
        for ((p, a), b) in pressures.iter().zip(&fine.pressures[before]).zip(there) {
            let exact = a + share * (b - a);
            off += (p - exact).powi(2);
            size += exact * exact;
            count += 1.0;
        }
    }
    let mean = |sum: f64| (sum / f64::max(count, 1.0)).sqrt();
    Ok(Difference { off: mean(off), size: mean(size) })
}

/// Fixed steps with the network of the state, to its stage's end at most.
fn course(plan: &Plan, state: &SimulationState, dt: f64, until: f64) -> Result<Course> {
    let mut plan = plan.clone();
    let Some(stage) = plan.stages.get_mut(state.stage()) else {
        return Err(InputError::new("no stage is left", "give a state within a stage").into());
    };
    let name = stage.name.clone();
    stage.dt = Some(TimeStep::Fixed(dt));
    plan.accuracy = None;
    if let Some(fluid) = &mut plan.fluid {
        fluid.remesh = RemeshRule { interval: Some(NEVER), strain: None };
        fluid.acceleration.auto_interval = false;
        let how = &mut fluid.acceleration;
        (how.remesh, how.swap, how.on_failure) =
            (RemeshMode::AtOnce, Swap::WhenDue, OnFailure::Stop);
    }
    let mut simulation = Simulation::restart(plan, state.without_error_control())?;
    let mut course = Course { times: vec![], pressures: vec![] };
    while simulation.stage().is_some_and(|stage| stage.name == name) && simulation.time() < until {
        simulation.advance()?;
        let all = simulation.coupled().determined_pressures();
        let apart = all.len().div_ceil(SPHERES).max(1);
        course.times.push(simulation.time() - LAG * dt);
        course.pressures.push(all.into_iter().step_by(apart).collect());
    }
    Ok(course)
}
