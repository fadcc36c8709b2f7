//! `kind = "run"`: a number of steps under given wall motions.

use serde::Serialize;

use super::until::Until;
use super::{cell_controls, control};
use crate::TimeFunction;
use crate::dem::{CellControl, CellControls, WallControl};
use crate::domain::{Axis, PerWall};
use crate::input::InputError;
use crate::scene::fluid::PRESSURE;
use crate::scene::keys::{Keyed, Keys};
use crate::scene::kind::{Angle, Flag, Maybe};
use crate::scene::schema::Schema;
use crate::scene::table::Table;
use crate::scene::time_function::InTime;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

pub(in crate::scene) static SCHEMA: Schema = Schema::table(
    "a run stage",
    &[
        "kind",
        "name",
        "steps",
        "time",
        "until",
        "fluid",
        "pressure",
        "walls",
        "velocity_gradient",
        "cell_stress",
        "friction_angle",
        "dt",
        "damping",
    ],
);

/// A number of steps under given wall motions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// When the stage ends. Default: after 1000 steps; a scene file must say it.
    pub until: Until,
    /// Is the flow solved at every step? Default false; in a scene file, true when it has
    /// `[fluid]`.
    pub fluid: bool,
    /// Pressures of walls in this stage (Pa), in the place of all those of the scene's fluid, with the
    /// time from the stage's start (s). Default: those of the fluid.
    pub pressure: Option<Box<PerWall<Option<TimeFunction>>>>,
    /// What each wall does; one with a function of time, at its start. Default: fixed.
    pub walls: PerWall<WallControl>,
    /// How the stress (Pa) or velocity (m/s) of a wall changes with the time from the stage's start
    /// (s). Default: it does not.
    pub walls_in_time: Box<PerWall<Option<TimeFunction>>>,
    /// What moves the periodic cell, where there is one. Default: nothing.
    pub cell: Box<CellControls>,
    /// Friction angle of the particles during this stage (rad). Default: the particles'.
    pub friction_angle: Option<f64>,
}

impl Default for Run {
    fn default() -> Run {
        let walls = PerWall::from_fn(|_| WallControl::Fixed);
        Run {
            until: Until::Steps(1000),
            fluid: false,
            pressure: None,
            walls,
            walls_in_time: Box::default(),
            cell: Box::default(),
            friction_angle: None,
        }
    }
}

impl Keyed for Run {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        self.keys_with(keys, None)
    }
}

impl Run {
    /// Reads a stage whose servos move walls at up to `max_velocity` (m/s) where it says no
    /// other.
    pub(super) fn read_with(mut self, table: &Table, max_velocity: Option<f64>) -> Result<Run> {
        self.keys_with(&mut Keys::Read(table), max_velocity)?;
        Ok(self)
    }

    fn keys_with(&mut self, keys: &mut Keys, max_velocity: Option<f64>) -> Result<()> {
        control::keys(keys, &mut self.walls, &mut self.walls_in_time, max_velocity)?;
        self.pressure_keys(keys)?;
        cell_controls::keys(keys, &mut self.cell)?;
        self.until.keys(keys)?;
        keys.take("fluid", &Flag, &mut self.fluid)?;
        keys.take("friction_angle", &Maybe(Angle), &mut self.friction_angle)
    }

    /// Pressures of walls, where the stage has any of its own.
    fn pressure_keys(&mut self, keys: &mut Keys) -> Result<()> {
        if let Keys::Read(table) = keys
            && table.get("pressure").is_some()
        {
            self.pressure = Some(Box::default());
        }
        let Some(walls) = &mut self.pressure else { return Ok(()) };
        keys.by_wall("pressure", &PRESSURE, &Maybe(InTime("Pa")), &mut walls.0)?;
        if walls.values().all(Option::is_none) {
            // Not the same as none of the stage's own: all walls are shut.
            keys.push(("pressure", "{}".to_owned()));
        }
        Ok(())
    }

    /// What is wrong with this stage alone.
    pub(super) fn wrong(&self) -> Option<Wrong> {
        if self.pressure.is_some() && !self.fluid {
            let problem = "has a `pressure`, but no flow is simulated in it";
            return Some(Wrong::new(problem, "leave it out, or set `fluid = true`"));
        }
        if let (Until::Porosity { porosity, .. }, false) = (self.until, self.changes_box()) {
            let problem = format!("waits for a porosity of {porosity}, but no wall moves");
            let remedy =
                "give one of them a velocity or a stress; a cell a velocity gradient or a stress";
            return Some(Wrong::new(problem, remedy));
        }
        self.strain_out_of_reach()
    }

    /// A strain must be within reach of the walls or the cell.
    fn strain_out_of_reach(&self) -> Option<Wrong> {
        let Until::Strain { axis, strain, .. } = self.until else { return None };
        match self.cell[axis.index()][axis.index()] {
            CellControl::Stress(_) => return None,
            CellControl::Rate(rate) if rate != 0.0 => {
                let problem = format!("waits for a strain of {strain} along {}", axis.name());
                let remedy = "strain is positive in compression, a velocity gradient in extension";
                let other = || Wrong::new(problem + ", but the cell goes the other way", remedy);
                return (rate * strain > 0.0).then(other);
            }
            CellControl::Rate(_) => {}
        }
        let mut shortening = 0.0;
        for (wall, control) in self.walls.iter().filter(|(w, _)| Axis::of(*w) == axis) {
            match control {
                WallControl::Fixed => {}
                // It may turn.
                _ if self.walls_in_time[wall].is_some() => return None,
                WallControl::Velocity(velocity) => shortening += velocity * wall.inward(),
                // The servo goes where the stress leads it.
                WallControl::Servo { .. } => return None,
            }
        }
        let axis = axis.name();
        if shortening == 0.0 {
            return Some(Wrong::new(
                format!("waits for a strain along {axis}, but the walls there do not move"),
                "give one of them a velocity or a stress; a cell a velocity gradient or a stress",
            ));
        }
        (shortening * strain < 0.0).then(|| {
            Wrong::new(
                format!(
                    "waits for a strain of {strain} along {axis}, but the walls move the other way"
                ),
                "strain is positive in compression, velocity towards larger coordinates",
            )
        })
    }
}

impl Run {
    /// True when a wall does anything.
    pub(super) fn moves_walls(&self) -> bool {
        self.walls.values().any(|c| *c != WallControl::Fixed)
    }

    /// True when a wall or a periodic cell moves.
    fn changes_box(&self) -> bool {
        self.moves_walls() || self.moves_cell()
    }

    /// True when a periodic cell is told to do anything.
    pub(super) fn moves_cell(&self) -> bool {
        *self.cell != CellControls::default()
    }

    /// True when a component of the stress on a periodic cell is prescribed.
    pub(super) fn has_cell_stress(&self) -> bool {
        self.cell.iter().flatten().any(|c| matches!(c, CellControl::Stress(_)))
    }

    /// True when a wall moves with a given velocity.
    pub(super) fn has_moving_wall(&self) -> bool {
        self.walls.values().any(|c| matches!(c, WallControl::Velocity(_)))
    }

    /// True when a wall is held at a stress.
    pub(super) fn has_servo(&self) -> bool {
        self.walls.values().any(|c| matches!(c, WallControl::Servo { .. }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::WallId;

    #[test]
    fn a_servo_goes_where_the_stress_leads_it() {
        let mut run = Run {
            until: Until::Strain { strain: -0.1, axis: Axis::Y, max_steps: 1 },
            ..Run::default()
        };
        assert!(run.wrong().unwrap().problem.contains("do not move"));
        run.walls[WallId::YMax] = WallControl::Velocity(-0.1);
        assert!(run.wrong().unwrap().problem.contains("the other way"));
        run.walls[WallId::YMax] = WallControl::Velocity(0.1);
        assert!(run.wrong().is_none());
        run.walls[WallId::YMax] = WallControl::Servo { stress: 1.0, max_velocity: None };
        assert!(run.wrong().is_none());
    }
}
