//! The six walls and how they move.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::material::positive;
use crate::{Aabb, PerWall, WallId};

/// Share of the wanted shift that a servo wall leaves out, and share of its
/// previous shift that it adds: the values of YADE's triaxial controller.
const SERVO_DAMPING: f64 = 0.25;
const SERVO_MEMORY: f64 = 0.8;

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
        let finite = |name, value: f64| {
            if value.is_finite() {
                Ok(())
            } else {
                Err(DemError::Parameter { name, value, expected: "finite" })
            }
        };
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

/// What acts on a wall in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallLoad {
    /// Force of spheres and fluid along the outward normal (N).
    pub outward: f64,
    /// Sum of the normal stiffnesses of the contacts on the wall (N/m).
    pub stiffness: f64,
    /// What the fluid adds to the force against the wall's velocity (N·s/m).
    pub resistance: f64,
    /// Area of the wall (m²).
    pub area: f64,
    /// 3 L_a / (L_x + L_y + L_z).
    pub axis_share: f64,
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

    /// Moves the wall by one time step.
    pub(super) fn advance(&mut self, wall: WallId, dt: f64, load: WallLoad) {
        self.velocity = match self.control {
            WallControl::Fixed => 0.0,
            WallControl::Velocity(v) => v,
            WallControl::Servo { stress, max_velocity } => {
                let limit = max_velocity * load.axis_share * dt;
                let excess = load.outward - stress * load.area;
                let stiffness = load.stiffness + load.resistance / dt;
                // A wall that touches nothing approaches at the largest speed.
                let wanted = if stiffness > 0.0 {
                    (excess / stiffness).clamp(-limit, limit)
                } else if excess == 0.0 {
                    0.0
                } else {
                    limit.copysign(excess)
                };
                // A fluid holds the force up while the wall moves on, so of its
                // share the previous shift is kept and nothing is damped.
                let wet =
                    if load.resistance > 0.0 { load.resistance / dt / stiffness } else { 0.0 };
                let damping = (1.0 - wet) * SERVO_DAMPING;
                let memory = SERVO_MEMORY + wet * (1.0 - SERVO_MEMORY);
                let mut shift = (1.0 - damping) * wanted + memory * self.previous_shift;
                if wet > 0.0 {
                    shift = shift.clamp(-limit, limit);
                }
                self.previous_shift = shift;
                -wall.inward() * shift / dt
            }
        };
        let shift = self.velocity * dt;
        self.position += shift;
        self.displacement += shift;
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

/// The error of a box without volume, if it is one.
pub(super) fn check_box(box_: &Aabb) -> Result<(), DemError> {
    for lower in [WallId::XMin, WallId::YMin, WallId::ZMin] {
        let (a, b) = (box_.wall(lower), box_.wall(lower.opposite()));
        if !(a.is_finite() && b.is_finite() && a < b) {
            return Err(DemError::WallsMet { lower, upper: lower.opposite() });
        }
    }
    Ok(())
}
