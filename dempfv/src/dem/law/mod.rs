//! Contact laws: one file per law, and one per effect of the granular law.
//!
//! A law implements [`ContactLaw`] and is given to
//! [`Dem::with_law`](super::Dem::with_law); `examples/custom_contact_law.rs`
//! shows one outside of the library.

mod adhesion;
mod batch;
pub mod bonds;
mod contact_law;
pub mod dmt;
mod effects;
mod geometry;
mod granular;
pub mod hertz;
pub mod jkr;
mod linear;
mod loss;
pub mod pull_off;
mod resistance;
pub mod restitution;
pub mod rolling;
mod shear;
mod springs;
mod terms;
mod turn;
pub mod twisting;
pub mod vector;

pub use adhesion::Adhesion;
pub use batch::{Batch, CONTACTS_PER_BATCH, History, Lane, UpTo, ZERO_LANE, get, put};
pub use bonds::Bonds;
pub use contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
pub use effects::GranularEffects;
pub use geometry::{
    Geometry, Radii, Sliding, SphereOnPlane, SpherePairs, SpheresOnWalls, TwoSpheres,
};
pub use granular::Granular;
pub use hertz::Hertz;
pub use linear::{CONTACTS, FRICTION, Linear, LinearParameters, LinearScratch};
pub use loss::{Loss, Losses};
pub use resistance::Resistance;
pub use restitution::Restitution;
pub use terms::{GranularParameters, Memory, Terms};
pub(in crate::dem) use turn::turned;
