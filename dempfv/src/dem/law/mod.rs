//! Contact laws: one file per law.
//!
//! A law implements [`ContactLaw`] and is given to
//! [`Dem::with_law`](super::Dem::with_law); `examples/custom_contact_law.rs`
//! shows one outside of the library.

mod batch;
mod contact_law;
mod geometry;
mod linear;
mod loss;
pub mod vector;

pub use batch::{Batch, CONTACTS_PER_BATCH, History, Lane, ZERO_LANE, get, put};
pub use contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
pub use geometry::{
    Geometry, Radii, Sliding, SphereOnPlane, SpherePairs, SpheresOnWalls, TwoSpheres,
};
pub use linear::{Linear, LinearParameters, LinearScratch};
pub use loss::{Loss, Losses};
