//! Do servo walls hold their stress?

use serde::{Deserialize, Serialize};

use super::context::Context;
use crate::dem::WallControl;
use crate::simulation::warning::{ServoMissed, Warning, warn};
use crate::{PerWall, WallId};

/// Parts of a stage: the last one is looked at.
pub(super) const PARTS: f64 = 10.0;
/// A mean stress may miss its goal by this share of it, and single steps by this one.
pub(super) const MISS: f64 = 0.05;
pub(super) const SWING: f64 = 0.5;

/// The stresses on servo walls since the last part of a stage began.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ServoWatch {
    /// Part of the stage that is looked at.
    part: u64,
    steps: u64,
    sum: PerWall<f64>,
    range: PerWall<[f64; 2]>,
    /// The largest stress of the whole stage (Pa).
    largest: PerWall<f64>,
}

impl ServoWatch {
    /// Looks at the walls after a step; `progress` is the share of the stage that is done.
    pub fn look(&mut self, context: &Context, progress: f64) {
        // As a cast has it, what is no number is the first part.
        let part = (progress * PARTS).min(PARTS - 1.0) as u64;
        if self.steps == 0 || part > self.part {
            *self = ServoWatch { part, largest: self.largest, ..ServoWatch::default() };
            self.range = PerWall([[f64::INFINITY, f64::NEG_INFINITY]; 6]);
        }
        self.steps += 1;
        for (wall, _) in servos(context) {
            let stress = context.coupled.wall_stress(wall);
            self.sum[wall] += stress;
            self.largest[wall] = self.largest[wall].max(stress.abs());
            let [low, high] = &mut self.range[wall];
            (*low, *high) = (low.min(stress), high.max(stress));
        }
    }

    /// Warns of the walls that have missed their goal when the stage ends.
    pub fn warn(&self, context: &mut Context) {
        let missed: Vec<Warning> = servos(context)
            .filter(|_| self.steps > 0)
            .filter_map(|(wall, asked)| {
                let mean = self.sum[wall] / self.steps as f64;
                let range = self.range[wall];
                // Of no stress at all, a share is one of what there was.
                let whole = if asked == 0.0 { self.largest[wall] } else { asked.abs() };
                let off = |stress: f64, share: f64| (stress - asked).abs() > share * whole;
                let missed = off(mean, MISS) || range.iter().any(|&stress| off(stress, SWING));
                let stage = context.stage.name.clone();
                missed.then_some(Warning::ServoMissed(ServoMissed {
                    stage,
                    wall,
                    asked,
                    mean,
                    range,
                }))
            })
            .collect();
        for warning in missed {
            warn(context.warnings, warning);
        }
    }
}

/// The walls that a servo moves, with the stress asked for (Pa).
fn servos<'a>(context: &'a Context) -> impl Iterator<Item = (WallId, f64)> + 'a {
    context.coupled.dem().walls().iter().filter_map(|(wall, state)| match state.control {
        WallControl::Servo { stress, .. } => Some((wall, stress)),
        _ => None,
    })
}
