//! The six walls and how they move.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::material::{finite, positive};
use super::servo::ServoLoad;
use crate::{Aabb, PerWall, WallId};

/// What moves a wall along its axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WallControl {
    /// The wall stands still.
    Fixed,
    /// The wall moves at this velocity along its axis (m/s, positive towards
    /// larger coordinates).
    Velocity(f64),
    /// The wall moves so that the stress on it becomes `stress`.
    Servo {
        /// Stress wanted (Pa, positive in compression).
        stress: f64,
        /// Cut v of the speed that the stress asks for (m/s), for the walls of
        /// a cube; for an axis of length L_a it is 3 v L_a / (L_x + L_y + L_z).
        /// The wall also goes on with 0.8 of its last shift, so that its speed
        /// comes up to 3.75 times the cut.
        max_velocity: f64,
    },
}

impl WallControl {
    pub(super) fn check(&self) -> Result<(), DemError> {
        match *self {
            WallControl::Fixed => Ok(()),
            WallControl::Velocity(v) => finite("wall velocity", v),
            WallControl::Servo { stress, max_velocity } => {
                finite("servo stress", stress)?;
                positive("servo max_velocity", max_velocity)
            }
        }
    }
}

/// One wall: a plane normal to its axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Coordinate of the plane along the axis (m).
    pub position: f64,
    /// Velocity along the axis in the last step (m/s).
    pub velocity: f64,
    /// What moves it.
    pub control: WallControl,
    /// Distance it has moved along the axis since the box was made (m).
    pub displacement: f64,
    /// Shift of the servo in its previous step (m), outwards.
    pub(super) previous_shift: f64,
}

impl Wall {
    fn new(position: f64) -> Wall {
        Wall {
            position,
            velocity: 0.0,
            control: WallControl::Fixed,
            displacement: 0.0,
            previous_shift: 0.0,
        }
    }

    /// What a servo has to do with the wall; `None` where none holds it. `outward` is the force of
    /// spheres and fluid along the outward normal (N), `stiffness` that of the contacts (N/m);
    /// `area` (m²) and `axis_share`, 3 L_a / (L_x + L_y + L_z), are the wall's.
    pub(super) fn servo_load(
        &self,
        dt: f64,
        (outward, stiffness): (f64, f64),
        (area, axis_share): (f64, f64),
    ) -> Option<ServoLoad> {
        let WallControl::Servo { stress, max_velocity } = self.control else { return None };
        Some(ServoLoad {
            excess: outward - stress * area,
            stiffness,
            limit: max_velocity * axis_share * dt,
            previous: self.previous_shift,
        })
    }

    /// Moves the wall by one time step; a servo wall by this outward shift (m).
    pub(super) fn advance(&mut self, wall: WallId, dt: f64, servo_shift: f64) {
        self.velocity = match self.control {
            WallControl::Fixed => 0.0,
            WallControl::Velocity(v) => v,
            WallControl::Servo { .. } => {
                self.previous_shift = servo_shift;
                -wall.inward() * servo_shift / dt
            }
        };
        let shift = self.velocity * dt;
        self.position += shift;
        self.displacement += shift;
    }

    /// Refuses numbers that no step leaves.
    pub(super) fn check(&self) -> Result<(), DemError> {
        finite("wall velocity", self.velocity)?;
        finite("wall displacement", self.displacement)?;
        finite("wall shift", self.previous_shift)?;
        self.control.check()
    }

    /// Changes the control; a servo starts without memory.
    pub(super) fn set_control(&mut self, control: WallControl) {
        let servo = |c: &WallControl| matches!(c, WallControl::Servo { .. });
        if !(servo(&control) && servo(&self.control)) {
            self.previous_shift = 0.0;
        }
        self.control = control;
    }
}

/// Six fixed walls around a box.
pub(super) fn walls_of(box_: &Aabb) -> PerWall<Wall> {
    PerWall::from_fn(|w| Wall::new(box_.wall(w)))
}

/// The box between the walls.
pub(super) fn box_of(walls: &PerWall<Wall>) -> Aabb {
    let at = |w: WallId| walls[w].position;
    Aabb {
        min: crate::Vec3::new(at(WallId::XMin), at(WallId::YMin), at(WallId::ZMin)),
        max: crate::Vec3::new(at(WallId::XMax), at(WallId::YMax), at(WallId::ZMax)),
    }
}

/// The error of a box without a volume, or with one that is no number, if it is one.
pub(super) fn check_box(box_: &Aabb) -> Result<(), DemError> {
    for lower in [WallId::XMin, WallId::YMin, WallId::ZMin] {
        let (a, b) = (box_.wall(lower), box_.wall(lower.opposite()));
        if !(a.is_finite() && b.is_finite() && a < b) {
            return Err(DemError::WallsMet { lower, upper: lower.opposite() });
        }
    }
    let value = box_.volume();
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        let expected = "positive and finite; choose another unit of length";
        Err(DemError::Parameter { name: "volume of the box", value, expected })
    }
}
