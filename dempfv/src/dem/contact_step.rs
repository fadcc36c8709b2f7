//! A contact in the step from one pass to the next, and what energy it takes that the contact turns.

use super::law::vector::Vector;
use super::law::{Sliding, turned};
use crate::Vec3;

/// Where two bodies are at a pass.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    /// Unit normal from the first to the second.
    pub normal: Vec3,
    /// Distance of the centres, or of the centre from the wall (m).
    pub distance: f64,
    /// Depth of the overlap (m).
    pub overlap: f64,
    /// Distances of the contact point from the centres (m); 0 of a wall, which does not turn.
    arms: [f64; 2],
}

/// Two bodies before and after a step.
#[derive(Clone, Copy)]
pub(super) struct ContactStep {
    pub before: Meeting,
    pub now: Meeting,
    /// Way of the second body relative to the first (m).
    way: Vec3,
    /// Turns of the two bodies (rad).
    turns: [Vec3; 2],
}

impl ContactStep {
    /// Of two spheres whose centres are `apart` (m) after the step.
    pub fn of_spheres(radii: [f64; 2], apart: Vec3, way: Vec3, turns: [Vec3; 2]) -> ContactStep {
        let meeting = |apart: Vec3| {
            let distance = apart.norm();
            let overlap = (radii[0] + radii[1]) - distance;
            let arms = radii.map(|radius| radius - 0.5 * overlap);
            Meeting { normal: apart / distance, distance, overlap, arms }
        };
        ContactStep { before: meeting(apart - way), now: meeting(apart), way, turns }
    }

    /// Of a sphere at this distance (m) from a wall after the step; the normal points to the wall.
    pub fn on_wall(
        radius: f64,
        (normal, distance): (Vec3, f64),
        way: Vec3,
        turn: Vec3,
    ) -> ContactStep {
        let meeting = |distance: f64| {
            let overlap = radius - distance;
            Meeting { normal, distance, overlap, arms: [radius - 0.5 * overlap, 0.0] }
        };
        let (before, now) = (meeting(distance - way.dot(&normal)), meeting(distance));
        ContactStep { before, now, way, turns: [turn, Vec3::zeros()] }
    }

    /// Way of the second body relative to the first (m) as forces at one of the two meetings feel it.
    pub fn slip(&self, at: &Meeting) -> Vec3 {
        let rim = at.arms[0] * self.turns[0] + at.arms[1] * self.turns[1];
        self.way - rim.cross(&at.normal)
    }

    /// What the motion loses (J), or gains where negative, because the normal turns under normal
    /// forces of these sizes before and after.
    ///
    /// Each acts along its own normal over half the way; the spring takes up their mean over the whole
    /// approach, to which the chord is short by 1 − n₀·n₁ of the distance.
    pub fn lost_by_turning(&self, [first, second]: [f64; 2]) -> f64 {
        let ContactStep { before, now, .. } = self;
        let bend = 0.5 * (now.normal - before.normal).norm_squared();
        -0.5 * bend * (second * before.distance - first * now.distance)
    }

    /// The same of the shear forces s₀ and s₁: their spring takes up ½ (R s₀ + s₁) · u, with turn R and
    /// slip u as the law has them, by normal and arms after the step, while each acts over half the way
    /// with normal and arms of its own.
    pub fn lost_by_turning_shear(&self, [first, second]: [Vec3; 2], sliding: &Sliding) -> f64 {
        let followed = Vec3::from(turned(Vector::from(first), sliding));
        let spring = (followed + second).dot(&Vec3::from(sliding.slip));
        0.5 * (spring - first.dot(&self.slip(&self.before)) - second.dot(&self.slip(&self.now)))
    }
}
