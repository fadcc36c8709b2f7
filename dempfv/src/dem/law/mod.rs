//! Contact laws: one file per law, and one per effect of the granular law.
//!
//! A law implements [`ContactLaw`] and is given to
//! [`Dem::with_law`](super::Dem::with_law); `examples/custom_contact_law.rs`
//! shows one outside of the library.

mod batch;
mod contact_law;
mod geometry;
mod granular;
pub mod hertz;
mod linear;
pub mod restitution;
mod shear;
mod springs;
mod terms;
mod turn;
pub mod vector;

pub use batch::{Batch, CONTACTS_PER_BATCH, History, Lane, UpTo, ZERO_LANE, get, put};
pub use contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
pub use geometry::{
    Geometry, Radii, Sliding, SphereOnPlane, SpherePairs, SpheresOnWalls, TwoSpheres,
};
pub use granular::{Granular, GranularEffects};
pub use hertz::Hertz;
pub use linear::{Linear, LinearParameters, LinearScratch};
pub use restitution::Restitution;
pub use terms::{GranularParameters, Memory, Terms};
