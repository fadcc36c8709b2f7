//! The six walls and how they move.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::material::{finite, positive};
use super::servo::{ServoLoad, wet_share};
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
        /// comes up to 3.75 times the cut. With `None` it is 10 σ / √(ρ E), with
        /// the larger of the stress wanted and the one there as σ, and density
        /// and modulus of the softest spheres: ten times the speed at which a
        /// wall that strikes them meets that stress. It is at most 0.02 of the
        /// smallest radius in a step, and as much where a fluid carries the wall.
        ///
        /// A wall that no sphere touches comes nearer by a tenth of its
        /// distance in a step, at most by a tenth of a radius, and at least by a
        /// fifth of what puts the stress wanted on the nearest sphere; no faster
        /// than `max_velocity`, where given.
        max_velocity: Option<f64>,
    },
}

impl WallControl {
    pub(super) fn check(&self) -> Result<(), DemError> {
        match *self {
            WallControl::Fixed => Ok(()),
            WallControl::Velocity(v) => finite("wall velocity", v),
            WallControl::Servo { stress, max_velocity } => {
                finite("servo stress", stress)?;
                max_velocity.map_or(Ok(()), |v| positive("servo max_velocity", v))
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
    /// Whether spheres touched it in the previous step.
    pub(super) touched: bool,
    /// By what a fluid's force on it is expected to change in a step, its shift aside (N).
    pub(super) drift: f64,
}

/// What a servo must know to move a wall.
#[derive(Clone, Copy)]
pub(super) struct WallSituation {
    /// Force of spheres and fluid along the outward normal (N).
    pub outward: f64,
    /// What the contacts put up against a shift in the step (N/m).
    pub stiffness: f64,
    /// What the fluid takes off the force per shift in the step (N/m).
    pub per_shift: f64,
    /// Area of the wall (m²).
    pub area: f64,
    /// 3 L_a / (L_x + L_y + L_z) for the wall's axis.
    pub axis_share: f64,
    /// Density and contact modulus of the spheres (kg/m³, Pa).
    pub density: f64,
    pub young: f64,
    /// The smallest radius of all (m).
    pub smallest_radius: f64,
    /// What a wall that nothing touches comes to next.
    pub nearest: Option<Nearest>,
}

/// The sphere with its surface nearest to a wall.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    /// Distance of that surface (m).
    pub distance: f64,
    /// Its radius (m).
    pub radius: f64,
    /// Stiffness of its contact with the wall (N/m).
    pub stiffness: f64,
}

/// Cut of a servo's speed over σ / √(ρ E), which is the speed of a wall that meets the stress σ
/// on the bodies that it strikes. From below 3 on a column of spheres takes long to follow; from
/// 30 on it is struck at five times the stress wanted.
const SPEED_CUT: f64 = 10.0;
/// Cut of a servo's shift in a step over the smallest radius. A fluid alone may have all of it.
const SHIFT_CUT: f64 = 0.02;
/// Share of the distance by which a wall that touches nothing comes nearer in a step, or of a
/// radius, and of the overlap under the stress wanted, for what it does at least.
const APPROACH: f64 = 0.1;
const FIRST_TOUCH: f64 = 0.2;

impl Wall {
    fn new(position: f64) -> Wall {
        Wall {
            position,
            velocity: 0.0,
            control: WallControl::Fixed,
            displacement: 0.0,
            previous_shift: 0.0,
            touched: false,
            drift: 0.0,
        }
    }

    /// What a servo has to do with the wall in a step of length `dt` (s); `None` where none
    /// holds it.
    pub(super) fn servo_load(&self, dt: f64, at: &WallSituation) -> Option<ServoLoad> {
        let WallControl::Servo { stress, max_velocity } = self.control else { return None };
        let natural = || {
            let stress = stress.abs().max((at.outward / at.area).abs());
            let dry = SPEED_CUT * stress / (at.density * at.young).sqrt() * at.axis_share * dt;
            let most = SHIFT_CUT * at.smallest_radius;
            dry.max(wet_share(at.per_shift, at.stiffness + at.per_shift) * most).min(most)
        };
        let limit = max_velocity.map_or_else(natural, |v| v * at.axis_share * dt);
        let inwards = at.nearest.map_or(limit, |Nearest { distance, radius, stiffness }| {
            // What puts 4 r² σ on the sphere.
            let overlap = 4.0 * radius * radius * stress.abs() / stiffness;
            let approach = (APPROACH * distance.min(radius)).max(FIRST_TOUCH * overlap);
            max_velocity.map_or(approach.min(APPROACH * radius), |_| approach.min(limit))
        });
        Some(ServoLoad {
            excess: at.outward - stress * at.area,
            stiffness: at.stiffness,
            limit: [inwards, limit],
            previous: self.previous_shift,
            in_touch: self.touched && at.stiffness > 0.0,
            drift: self.drift,
        })
    }

    /// Moves the wall by one time step; a servo wall by its shift, outwards (m).
    pub(super) fn advance(&mut self, wall: WallId, dt: f64, servo_shift: f64) {
        self.velocity = match self.control {
            WallControl::Fixed => 0.0,
            WallControl::Velocity(v) => v,
            WallControl::Servo { .. } => -wall.inward() * servo_shift / dt,
        };
        let shift = self.velocity * dt;
        self.position += shift;
        self.displacement += shift;
    }

    /// Keeps what the servo has learned in a step. `area` is the wall's (m²), `touched` says whether
    /// spheres touched it, `wet` whether it squeezes a fluid.
    pub(super) fn remember(
        &mut self,
        load: &ServoLoad,
        shift: f64,
        area: f64,
        (touched, wet): (bool, bool),
    ) {
        let WallControl::Servo { stress, .. } = self.control else { return };
        self.previous_shift = shift;
        self.touched = touched;
        self.drift = load.next_drift(shift, stress * area, wet);
    }

    /// Refuses numbers that no step leaves.
    pub(super) fn check(&self) -> Result<(), DemError> {
        finite("wall velocity", self.velocity)?;
        finite("wall displacement", self.displacement)?;
        finite("wall shift", self.previous_shift)?;
        finite("wall drift", self.drift)?;
        self.control.check()
    }

    /// Changes the control; a servo starts without memory.
    pub(super) fn set_control(&mut self, control: WallControl) {
        let servo = |c: &WallControl| matches!(c, WallControl::Servo { .. });
        if !(servo(&control) && servo(&self.control)) {
            (self.previous_shift, self.drift, self.touched) = (0.0, 0.0, false);
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
