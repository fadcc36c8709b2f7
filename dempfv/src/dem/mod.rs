//! Discrete elements: spheres, walls, contacts, integration.
//!
//! A [`Dem`] holds linear elastic-frictional spheres in a box of six walls
//! and advances them with an explicit leapfrog scheme:
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
//! assert_eq!(dem.particles().len(), 2);
//! # Ok::<(), dempfv::dem::DemError>(())
//! ```
//!
//! A step is [`Dem::compute_contacts`] (forces at the current positions)
//! followed by [`Dem::integrate`] (positions one time step further). Results
//! are the same, bit for bit, for any number of threads: blocks of a fixed
//! number of particles accumulate their own contacts in a fixed order and the
//! forces across blocks are gathered per particle in a fixed order.

mod batch;
mod cloud;
mod contact_forces;
mod contacts;
mod error;
mod grid;
mod growth;
mod hilbert;
mod integrate;
mod kernel;
mod material;
mod neighbours;
mod observe;
mod pairs;
mod particles;
mod pass;
mod rng;
mod state;
mod system;
mod walls;

pub(crate) use contact_forces::ContactForces;

pub use cloud::{CloudScale, CloudSpec, SizeDistribution, random_cloud};
pub use contacts::{Contact, Partner};
pub use error::DemError;
pub use growth::{GrowthCompaction, GrowthOptions, GrowthStatus};
pub use material::{Material, WallMaterial};
pub use particles::Particles;
pub use state::{DemState, SphereHistory, WallHistory};
pub use system::{Dem, DemOptions};
pub use walls::{Wall, WallControl};
