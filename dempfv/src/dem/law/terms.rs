//! What the loops of the granular law hand on to each other.

use super::batch::{Lane, UpTo, ZERO_LANE};

/// The most that a contact of the granular law remembers: shear force (3), rolling force (3),
/// twisting force (1), radius of an adhesive contact (1) or state and length of a bond (2), force of the
/// dashpots (3).
pub type Memory = UpTo<12>;

/// Constants of a contact of the granular law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GranularParameters {
    /// Normal stiffness over the reduced radius for linear springs, E* for Hertz's contact (Pa).
    pub modulus: f64,
    /// Shear stiffness over normal stiffness; with Hertz 4 G*/E*.
    pub shear_ratio: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Densities of the two bodies (kg/m³); of a wall none.
    pub densities: [f64; 2],
    /// Damping ratio of the normal spring that the restitution stands for; 0 without damping.
    pub damping_ratio: f64,
    /// Whether the two bodies may be bonded: spheres, where bonds are on.
    pub bondable: bool,
}

/// Lanes of what a contact's forces are made of. What an effect that is off would write, stays as
/// it was made: zero.
#[derive(Debug)]
pub struct Terms {
    /// Tangent stiffness of the normal spring (N/m).
    pub(super) stiffness: Lane,
    /// Force by which the surfaces push each other apart (N).
    pub(super) push: Lane,
    /// Force by which they pull each other together, and the largest tension that they bear (N).
    pub(super) pull: Lane,
    pub(super) pull_off: Lane,
    /// The least that spring and dashpot together may push (N).
    pub(super) floor: Lane,
    /// Coefficient of the normal dashpot (N s/m).
    pub(super) dashpot: Lane,
    /// Force of the normal dashpot, positive where the bodies approach (N).
    pub(super) viscous: Lane,
    /// What of it came to act (N): spring and dashpot may not pull.
    pub(super) damped: Lane,
    /// Normal force that friction and rolling resistance are proportional to (N).
    pub(super) grip: Lane,
    /// Shear force that a bond bears beside friction (N).
    pub(super) strength: Lane,
    /// Contact radius over what it was a step before; 1 where there was none.
    pub(super) growth: Lane,
    /// Whether an adhesive contact or a bond was there before, and its length without force (m).
    pub(super) before: [Lane; 2],
    /// Shear force after the contact has turned, and the square of the factor that its length
    /// lacks.
    pub(super) turned: [Lane; 3],
    pub(super) ratio: Lane,
    /// What the slip of the step takes off the shear force (N).
    pub(super) loss: [Lane; 3],
    /// Shear force of the tangential dashpot on the second body (N).
    pub(super) drag: [Lane; 3],
}

impl Default for Terms {
    fn default() -> Terms {
        Terms {
            stiffness: ZERO_LANE,
            push: ZERO_LANE,
            pull: ZERO_LANE,
            pull_off: ZERO_LANE,
            floor: ZERO_LANE,
            dashpot: ZERO_LANE,
            viscous: ZERO_LANE,
            damped: ZERO_LANE,
            grip: ZERO_LANE,
            strength: ZERO_LANE,
            growth: ZERO_LANE,
            before: [ZERO_LANE; 2],
            turned: [ZERO_LANE; 3],
            ratio: ZERO_LANE,
            loss: [ZERO_LANE; 3],
            drag: [ZERO_LANE; 3],
        }
    }
}
