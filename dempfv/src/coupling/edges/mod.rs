//! Forces that the fluid between two neighbours puts on them, one file for each effect.
//!
//! The pore network's pressures know the fluid at rest relative to its pores. What it does between two
//! surfaces that come closer or slide past each other is added here, on the edges of the triangulation:
//! pairs of spheres, and spheres with walls. Both get opposite forces at one point and opposite
//! couples, so that momentum and angular momentum stay. An effect that is off is computed nowhere and
//! has no array of its own.

mod adjacency;
mod bound;
mod effects;
mod film;
mod forces;
mod losses;
mod normal_lubrication;
mod pump_torque;
mod shear_lubrication;
mod state;
mod twist_torque;
mod viscous_shear;

pub use effects::EdgeEffects;

pub(super) use forces::EdgeForces;
pub(super) use state::{EdgeState, Films};

pub use normal_lubrication::EFFECT as NORMAL_LUBRICATION;
pub use pump_torque::EFFECT as PUMP_TORQUE;
pub use shear_lubrication::EFFECT as SHEAR_LUBRICATION;
pub use twist_torque::EFFECT as TWIST_TORQUE;
pub use viscous_shear::EFFECT as VISCOUS_SHEAR;
