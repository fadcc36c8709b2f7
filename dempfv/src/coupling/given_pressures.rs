//! Pressures that a caller gives between two steps, in the place of those of the fluid's effects.

use super::error::Result;
use super::fluid_effects::FluidEffects;
use crate::pfv::Flow;
use crate::{PerWall, WallId};

/// Pressures of walls and of regions of pores (Pa), as far as they were given.
#[derive(Debug, Default)]
pub(super) struct GivenPressures {
    walls: PerWall<Option<f64>>,
    /// By the places of regions.
    regions: Vec<(usize, f64)>,
}

impl GivenPressures {
    pub fn set_wall(&mut self, wall: WallId, pressure: f64) {
        self.walls[wall] = Some(pressure);
    }

    pub fn set_region(&mut self, number: usize, pressure: f64) {
        match self.regions.iter_mut().find(|(region, _)| *region == number) {
            Some((_, given)) => *given = pressure,
            None => self.regions.push((number, pressure)),
        }
    }

    fn is_empty(&self) -> bool {
        self.regions.is_empty() && self.walls.values().all(Option::is_none)
    }
}

/// What is imposed on a flow and may be another in each step.
#[derive(Clone, Copy)]
pub(super) struct Conditions<'a> {
    pub effects: &'a FluidEffects,
    pub given: &'a GivenPressures,
    /// Model time for which they are (s).
    pub time: f64,
}

impl Conditions<'_> {
    /// Whether one of them may differ from step to step.
    pub fn change(&self) -> bool {
        self.effects.change_in_time() || !self.given.is_empty()
    }

    /// Tells a flow.
    pub fn impose(&self, flow: &mut Flow) -> Result<()> {
        self.effects.impose(flow, self.time)?;
        for (wall, pressure) in self.given.walls.iter() {
            if let Some(pressure) = pressure {
                flow.set_wall_pressure(wall, *pressure)?;
            }
        }
        for (number, pressure) in &self.given.regions {
            flow.set_imposed_pressure(*number, *pressure)?;
        }
        Ok(())
    }
}
