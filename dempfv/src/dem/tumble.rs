//! The free rotation of a rigid body over a time step.
//!
//! The angular momentum stays as it is; the body turns about its principal axes one after the other,
//! there and back, each by what its share of the angular momentum makes of the step. Each such turn is
//! the exact motion under one term of ½ Σ L_k²/I_k, so that the composition is symplectic: of second
//! order, time-reversible, with an energy that swings and does not drift (A. Dullweber, B. Leimkuhler,
//! R. McLachlan: J. Chem. Phys. 107, 1997).

use nalgebra::{Quaternion, UnitQuaternion};

use crate::Vec3;

/// A small rotation as the parts of its quaternion, of which the vector keeps the digits of an angle
/// however small.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    real: f64,
    vector: Vec3,
}

impl Default for Turn {
    fn default() -> Turn {
        Turn { real: 1.0, vector: Vec3::zeros() }
    }
}

impl Turn {
    /// By a rotation vector (rad).
    pub fn by(angles: &Vec3) -> Turn {
        let angle = angles.norm();
        // sin(x/2)/x tends to ½.
        let share = if angle > 0.0 { (0.5 * angle).sin() / angle } else { 0.5 };
        Turn { real: (0.5 * angle).cos(), vector: share * angles }
    }

    /// By an angle (rad) about an axis of the coordinates.
    fn about(axis: usize, angle: f64) -> Turn {
        let mut vector = Vec3::zeros();
        vector[axis] = (0.5 * angle).sin();
        Turn { real: (0.5 * angle).cos(), vector }
    }

    /// This one after `first`.
    fn after(&self, first: &Turn) -> Turn {
        let (a, b) = (self, first);
        Turn {
            real: a.real * b.real - a.vector.dot(&b.vector),
            vector: a.real * b.vector + b.real * a.vector + a.vector.cross(&b.vector),
        }
    }

    /// By how much it shifts `r`: without the cancellation of a difference.
    pub fn shift(&self, r: &Vec3) -> Vec3 {
        let once = self.vector.cross(r);
        2.0 * (self.real * once + self.vector.cross(&once))
    }

    /// By how much it has shifted what is at `r` now.
    pub fn way_to(&self, r: &Vec3) -> Vec3 {
        let once = self.vector.cross(r);
        2.0 * (self.real * once - self.vector.cross(&once))
    }

    /// Where it takes `r`.
    pub fn of(&self, r: &Vec3) -> Vec3 {
        r + self.shift(r)
    }

    /// The rotation vector (rad), of up to half a turn.
    pub fn angles(&self) -> Vec3 {
        let sine = self.vector.norm();
        if sine == 0.0 {
            return Vec3::zeros();
        }
        2.0 * sine.atan2(self.real) / sine * self.vector
    }

    /// The orientation after it, of length 1 again.
    pub fn turned(&self, orientation: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let own = Quaternion::from_parts(self.real, self.vector);
        UnitQuaternion::new_normalize(own * orientation.quaternion())
    }
}

/// How a body with these principal moments (kg m²) and this `orientation` turns in a step of `dt` (s)
/// with an angular `momentum` (kg m²/s) that stays: as seen from outside.
pub(super) fn free_turn(
    moments: &Vec3,
    orientation: &UnitQuaternion<f64>,
    momentum: &Vec3,
    dt: f64,
) -> Turn {
    // In the body's frame, in which its turns are about axes of the coordinates.
    let mut own = orientation.inverse_transform_vector(momentum);
    let mut whole = Turn::default();
    for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let angle = share * dt * own[axis] / moments[axis];
        own = Turn::about(axis, -angle).of(&own);
        whole = whole.after(&Turn::about(axis, angle));
    }
    Turn { real: whole.real, vector: orientation.transform_vector(&whole.vector) }
}
