//! Does the servo of a periodic cell hold its stresses?

use serde::{Deserialize, Serialize};

use super::context::Context;
use super::servo_watch::{MISS, PARTS, SWING};
use crate::coupling::Coupled;
use crate::dem::CellControl;
use crate::simulation::warning::{CellStressMissed, Warning, warn};

/// The stresses of a cell since the last part of a stage began, component by component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CellWatch {
    /// Part of the stage that is looked at.
    part: u64,
    seen: Vec<Seen>,
}

/// A component that a servo holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Seen {
    component: [u8; 2],
    asked: f64,
    steps: u64,
    sum: f64,
    range: [f64; 2],
    /// The largest of the whole stage (Pa).
    largest: f64,
}

impl Seen {
    fn new(component: [u8; 2], asked: f64) -> Seen {
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Seen { component, asked, steps: 0, sum: 0.0, range, largest: 0.0 }
    }

    fn add(&mut self, stress: f64) {
        self.steps += 1;
        self.sum += stress;
        self.largest = self.largest.max(stress.abs());
        self.range = [self.range[0].min(stress), self.range[1].max(stress)];
    }
}

impl CellWatch {
    /// Of the components that are held; empty between walls.
    pub fn of(coupled: &Coupled) -> CellWatch {
        let controls = coupled.dem().cell().map(|cell| *cell.controls());
        let mut seen = vec![];
        for (a, row) in controls.iter().flatten().enumerate() {
            for (b, control) in row.iter().enumerate() {
                if let CellControl::Stress(asked) = control {
                    seen.push(Seen::new([a as u8, b as u8], *asked));
                }
            }
        }
        CellWatch { part: 0, seen }
    }

    /// Looks at the cell after a step; `progress` is the share of the stage that is done.
    pub fn look(&mut self, context: &Context, progress: f64) {
        if self.seen.is_empty() {
            return;
        }
        let Some(stress) = context.coupled.cell_stress() else { return };
        // As a cast has it, what is no number is the first part.
        let part = (progress * PARTS).min(PARTS - 1.0) as u64;
        let begins = part > self.part;
        self.part = self.part.max(part);
        for seen in &mut self.seen {
            if begins {
                *seen = Seen { largest: seen.largest, ..Seen::new(seen.component, seen.asked) };
            }
            let [a, b] = seen.component.map(usize::from);
            seen.add(0.5 * (stress[(a, b)] + stress[(b, a)]));
        }
    }

    /// Warns of the components that have missed their goal when the stage ends. A component is
    /// measured by the largest stress that any is asked for: friction makes a shear stress of 0 as
    /// rough as the others.
    pub fn warn(&self, context: &mut Context) {
        let asked = self.seen.iter().fold(0.0f64, |most, seen| most.max(seen.asked.abs()));
        for seen in self.seen.iter().filter(|seen| seen.steps > 0) {
            let mean = seen.sum / seen.steps as f64;
            // Of no stress at all, a share is one of what there was.
            let whole = if asked == 0.0 { seen.largest } else { asked };
            let off = |stress: f64, share: f64| (stress - seen.asked).abs() > share * whole;
            if off(mean, MISS) || seen.range.iter().any(|&stress| off(stress, SWING)) {
                let stage = context.stage.name.clone();
                let Seen { component, asked, range, .. } = *seen;
                let missed = CellStressMissed { stage, component, asked, mean, range };
                warn(context.warnings, Warning::CellStressMissed(missed));
            }
        }
    }
}
