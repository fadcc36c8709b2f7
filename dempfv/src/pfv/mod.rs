//! Pore-scale finite volumes: the pore network of a packing and its flow.
//!
//! A [`Network`] is the regular triangulation of spheres and walls as flat
//! arrays, with the throats' conductances. [`Operators`] holds the sparse
//! matrices of the coupled problem: pressures follow from `G p = -E v + Q`
//! (eqs. 5 to 7 of Caulk 2020) and the fluid's forces from `f = F p` (eq. 10).
//! [`Flow`] joins both with a factorization.
//!
//! Walls are exact planes in every formula. Only the triangulation itself sees
//! them as huge spheres.

mod angle;
mod build;
mod clamp;
mod error;
mod extrapolation;
mod flow;
mod fluid;
mod geometry_update;
mod transfer;

mod boundary_flux;
mod frame;
mod iterate;
mod krylov;
mod lanes;
mod locate;
mod network;
mod operators;
mod pore;
mod pore_batch;
mod slabs;
mod tessellation;
mod throat;
mod throat_batch;
mod viscous;

pub use build::{Analyzed, Assembled, BuildTimes, Spare};
pub use clamp::Clamp;
pub use error::{PfvError, PoreVertex, PoreVertices};
pub use extrapolation::Extrapolation;
pub use flow::{Flow, Permeability};
pub use fluid::{Boundary, Fluid};
pub use geometry_update::Wear;
pub use iterate::Iterations;
pub use transfer::TransferSource;

pub use network::{Derivatives, Network, Throats};
pub use operators::Operators;
pub use tessellation::{NONE, Tessellation};
pub use viscous::ViscousMode;
