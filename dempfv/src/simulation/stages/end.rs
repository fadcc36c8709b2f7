//! When a run stage ends.

use serde::{Deserialize, Serialize};

use super::context::Context;
use super::strain::Reference;
use crate::coupling::Coupled;
use crate::dem::{CellControl, WallControl};
use crate::scene::Until;
use crate::simulation::StageError;
use crate::simulation::clock::Clock;
use crate::{Axis, Result};

/// Steps from one look at all contacts to the next: it takes a part of a step.
const STEPS_BETWEEN_LOOKS: u64 = 10;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum End {
    Step(u64, u64),
    Time(f64, f64),
    Strain {
        goal: f64,
        axis: usize,
        max_steps: u64,
    },
    /// A stress (Pa) along an axis.
    Stress(Crossing, usize),
    Porosity(Crossing),
    Unbalanced {
        goal: f64,
        tolerance: f64,
        max_steps: u64,
    },
}

/// A value that a quantity comes to, from what it was when the stage began.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Crossing {
    from: f64,
    goal: f64,
    max_steps: u64,
}

impl Crossing {
    /// Share of the way; at its end where there is none.
    fn share(&self, now: f64) -> f64 {
        let way = self.goal - self.from;
        if way == 0.0 { 1.0 } else { (now - self.from) / way }
    }

    /// The same quantity on its way to another goal.
    fn to(&self, goal: f64, max_steps: u64) -> Crossing {
        Crossing { goal, max_steps, ..*self }
    }
}

impl End {
    /// The end of a stage that begins now, at this step and time (s).
    pub fn of(until: Until, (step, time): (u64, f64), coupled: &Coupled) -> End {
        let from = |from, goal, max_steps| Crossing { from, goal, max_steps };
        match until {
            Until::Steps(steps) => End::Step(step, step + steps),
            Until::Time(length) => End::Time(time, time + length),
            Until::Strain { strain, axis, max_steps } => {
                End::Strain { goal: strain, axis: axis.index(), max_steps }
            }
            Until::Stress { stress, axis, max_steps } => {
                End::Stress(from(coupled.axis_stress(axis), stress, max_steps), axis.index())
            }
            Until::Porosity { porosity, max_steps } => {
                End::Porosity(from(coupled.dem().porosity(), porosity, max_steps))
            }
            Until::Unbalanced { unbalanced: goal, tolerance, max_steps } => {
                End::Unbalanced { goal, tolerance, max_steps }
            }
        }
    }

    /// The end of a stage that began at this step and time (s), as a restart has it.
    pub fn restored(&self, until: Until, start: (u64, f64), coupled: &Coupled) -> End {
        match (self, until) {
            (End::Stress(old, _), Until::Stress { stress, axis, max_steps }) => {
                End::Stress(old.to(stress, max_steps), axis.index())
            }
            (End::Porosity(old), Until::Porosity { porosity, max_steps }) => {
                End::Porosity(old.to(porosity, max_steps))
            }
            _ => End::of(until, start, coupled),
        }
    }

    /// Share of the stage that is done; that of states as last seen, `seen`.
    pub fn progress(&self, clock: &Clock, seen: f64) -> f64 {
        match self {
            End::Step(from, to) => {
                clock.step.saturating_sub(*from) as f64 / to.saturating_sub(*from).max(1) as f64
            }
            End::Time(from, to) => (clock.time - from) / (to - from),
            _ => seen,
        }
    }

    /// Share of the way to a state; 0 where steps or time end the stage.
    pub fn share(&self, coupled: &Coupled, reference: &Reference) -> f64 {
        let share = match self {
            End::Step(..) | End::Time(..) | End::Unbalanced { .. } => 0.0,
            End::Strain { goal, axis, .. } => reference.strain(coupled)[*axis] / goal,
            End::Stress(crossing, axis) => crossing.share(stress(coupled, *axis)),
            End::Porosity(crossing) => crossing.share(coupled.dem().porosity()),
        };
        share.clamp(0.0, 1.0)
    }

    /// Whether the stage is over after so many steps of it.
    ///
    /// # Errors
    /// The steps are used up.
    pub fn is_over(&self, context: &Context, reference: &Reference, steps: u64) -> Result<bool> {
        let (coupled, clock) = (&context.coupled, &context.clock);
        let given_up = |quantity, value, goal, max_steps| match steps >= max_steps {
            true => Err(StageError::GoalNotReached { quantity, steps, value, goal }.into()),
            false => Ok(false),
        };
        match *self {
            End::Step(_, to) => Ok(clock.step >= to),
            // Half a time step short counts as there, so that round-off in the
            // sum of time steps adds none.
            End::Time(_, to) => Ok(steps > 0 && clock.time >= to - 0.5 * clock.dt),
            End::Strain { goal, axis, max_steps } => {
                let strain = reference.strain(coupled)[axis];
                if strain / goal >= 1.0 {
                    return Ok(true);
                }
                match steps >= max_steps {
                    true => Err(StageError::StrainNotReached { steps, strain, goal }.into()),
                    false => Ok(false),
                }
            }
            End::Stress(crossing, axis) => {
                let now = stress(coupled, axis);
                let over = crossing.share(now) >= 1.0;
                if over {
                    Ok(true)
                } else {
                    given_up("stress", now, crossing.goal, crossing.max_steps)
                }
            }
            End::Porosity(crossing) => {
                let now = coupled.dem().porosity();
                let over = crossing.share(now) >= 1.0;
                if over {
                    Ok(true)
                } else {
                    given_up("porosity", now, crossing.goal, crossing.max_steps)
                }
            }
            End::Unbalanced { goal, tolerance, max_steps } => {
                // Before the first steps nothing has moved, and all is at rest.
                if steps == 0 || !steps.is_multiple_of(STEPS_BETWEEN_LOOKS) {
                    return Ok(false);
                }
                let now = coupled.unbalanced_force();
                if now < goal && holds_stresses(coupled, tolerance) {
                    return Ok(true);
                }
                given_up("unbalanced force", now, goal, max_steps)
            }
        }
    }
}

fn stress(coupled: &Coupled, axis: usize) -> f64 {
    coupled.axis_stress([Axis::X, Axis::Y, Axis::Z][axis])
}

/// Whether all stresses that servos hold are within a share of their goals.
fn holds_stresses(coupled: &Coupled, tolerance: f64) -> bool {
    let walls = coupled.dem().walls().iter().all(|(wall, state)| match state.control {
        WallControl::Servo { stress, .. } => {
            (coupled.wall_stress(wall) - stress).abs() <= tolerance * stress.abs()
        }
        WallControl::Fixed | WallControl::Velocity(_) => true,
    });
    let (Some(cell), Some(seen)) = (coupled.dem().cell(), coupled.observe_cell()) else {
        return walls;
    };
    // A shear stress of 0 is held within a share of the largest.
    let wanted = |a: usize, b: usize| match cell.controls()[a][b] {
        CellControl::Stress(stress) => Some(stress),
        CellControl::Rate(_) => None,
    };
    let all = || (0..9).filter_map(|k| Some((k / 3, k % 3, wanted(k / 3, k % 3)?)));
    let largest = all().fold(0.0, |most: f64, (_, _, stress)| most.max(stress.abs()));
    walls && all().all(|(a, b, stress)| (seen.stress[(a, b)] - stress).abs() <= tolerance * largest)
}
