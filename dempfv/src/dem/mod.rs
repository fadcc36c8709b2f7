//! Discrete elements: spheres, walls, contacts, integration.
//!
//! A [`Dem`] holds spheres in a box of six walls and advances them with an
//! explicit leapfrog scheme. Their contacts are linear elastic-frictional
//! unless another [`law`] is given:
//!
//! ```
//! use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
//! use dempfv::{Aabb, Vec3};
//!
//! let material = Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
//! let spheres = Particles::new(
//!     vec![Vec3::new(0.4, 0.5, 0.5), Vec3::new(0.6, 0.5, 0.5)],
//!     vec![0.1, 0.1],
//!     material.density,
//! );
//! let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
//! let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
//! let mut dem = Dem::new(spheres, unit, material, walls, DemOptions::default())?;
//! dem.step(1e-5)?;
//! assert_eq!(dem.velocity(0).x, -dem.velocity(1).x);
//! # Ok::<(), dempfv::dem::DemError>(())
//! ```
//!
//! Spheres have the numbers that they had in the list given, although they
//! are stored in an order in space: whatever is in that order has `storage` in
//! its name.
//!
//! A step is [`Dem::compute_contacts`] (forces at the current positions)
//! followed by [`Dem::integrate`] (positions one time step further). Results
//! are the same, bit for bit, for any number of threads: blocks of a fixed
//! number of particles accumulate their own contacts in a fixed order and the
//! forces across blocks are gathered per particle in a fixed order.

mod assemble;
mod body_force;
mod bonding;
mod by_number;
mod cell;
mod cell_motion;
mod cell_neighbours;
mod cell_pass;
mod cell_servo;
mod changes;
mod cloud;
mod clump;
mod clump_shape;
mod clump_template;
mod clumping;
mod clumps;
mod compiled;
mod contact_forces;
mod contact_step;
mod contacts;
mod damping;
mod driving;
mod energy;
mod error;
mod external;
mod fabric;
mod grid;
mod growth;
mod held;
mod hilbert;
mod integrate;
mod kept;
pub mod law;
mod ledger;
mod material;
mod motion;
mod neighbours;
mod observe;
mod parameters;
mod particles;
mod pass;
mod pass_input;
mod rng;
mod servo;
mod sphere_pairs;
mod state;
mod stiffness_pass;
mod stiffness_sum;
mod system;
mod time_step;
mod touch_change;
mod tumble;
mod wall_motion;
mod wall_pairs;
mod walls;
mod with_effects;

pub(crate) use contact_forces::ContactForces;
pub(crate) use integrate::FluidLoads;
pub(crate) use ledger::FilmLosses;
pub(crate) use stiffness_sum::StiffnessSum;

pub use body_force::{BodyForce, BodyLoad, SphereState};
pub use cell::{CellControl, CellControls, PeriodicCell};
pub use cloud::{CloudScale, CloudSpec, SizeDistribution, random_cloud, random_cloud_in_cell};
pub use clump::Clump;
pub use clump_template::{ClumpTemplate, ClumpedSpheres};
pub use contacts::{Contact, Partner};
pub use energy::EnergyBalance;
pub use error::{DemError, Leaving};
pub use fabric::Fabric;
pub use growth::{GrowthCompaction, GrowthOptions, GrowthStatus};
pub use material::{Material, MaterialPair, WallMaterial};
pub use motion::Motion;
pub use particles::Particles;
pub use servo::WallResistance;
pub use state::{ContactHistory, DemState};
pub use system::{Dem, DemOptions};
pub use walls::{Wall, WallControl};

/// What the effects of this room say of themselves.
pub mod effects {
    pub use crate::dem::cell::EFFECT as PERIODIC_CELL;
    pub use crate::dem::cell_servo::EFFECT as CELL_STRESS;
    pub use crate::dem::clump::EFFECT as CLUMPS;
    pub use crate::dem::damping::EFFECT as LOCAL_DAMPING;
    pub use crate::dem::energy::EFFECT as ENERGY;
    pub use crate::dem::growth::EFFECT as GROWTH;
    pub use crate::dem::integrate::{GRAVITY, ROTATION};
    pub use crate::dem::law::bonds::EFFECT as BONDS;
    pub use crate::dem::law::dmt::EFFECT as DMT;
    pub use crate::dem::law::hertz::EFFECT as HERTZ_MINDLIN;
    pub use crate::dem::law::jkr::EFFECT as JKR;
    pub use crate::dem::law::pull_off::EFFECT as CONSTANT_COHESION;
    pub use crate::dem::law::restitution::EFFECT as RESTITUTION;
    pub use crate::dem::law::rolling::EFFECT as ROLLING;
    pub use crate::dem::law::twisting::EFFECT as TWISTING;
    pub use crate::dem::law::{CONTACTS, FRICTION};
    pub use crate::dem::material::EFFECT as MATERIALS;
    pub use crate::dem::motion::EFFECT as PRESCRIBED_MOTION;
    pub use crate::dem::servo::EFFECT as SERVO_WALLS;
    pub use crate::dem::wall_motion::MOVING_WALLS;
    pub use crate::dem::wall_pairs::WALL_FRICTION;
}
