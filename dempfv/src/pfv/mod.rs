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
mod boundary;
mod boundary_flux;
mod build;
mod build_times;
mod cell_copies;
mod cell_network;
mod cell_tessellation;
mod centroid;
mod clamp;
mod conductance_rules;
mod conductances;
mod core_permeability;
mod drag;
mod edges;
mod error;
mod extrapolation;
mod flat_pores;
mod flow;
mod flow_conditions;
mod flow_results;
mod flow_storage;
mod flow_terms;
mod flow_weight;
mod fluid;
mod frame;
mod geometry_update;
mod gradient_load;
mod krylov;
mod lanes;
mod locate;
mod network;
mod network_conditions;
mod open_area;
mod operator_products;
mod operators;
mod packing_check;
mod periodic;
mod pore;
mod pore_batch;
mod pore_conditions;
mod pore_growth;
mod pore_pressures;
mod pressure_gradient;
mod pressure_solver;
mod profile;
mod remarks;
mod retired_network;
mod reusable_analysis;
mod sealed;
mod slabs;
mod storage;
mod storage_products;
pub mod terms;
mod tessellation;
mod throat;
mod throat_batch;
mod transfer;
mod viscous;
mod void_volume;
mod wall_profiles;

pub(crate) use edges::EdgeList;
pub(crate) use packing_check::check_tolerance;
pub(crate) use periodic::cell_corners;

pub use crate::solver::Iterations;
pub use boundary::{Boundary, SealedPoreRule};
pub use build::{Analyzed, Assembled};
pub use build_times::BuildTimes;
pub use clamp::{Clamp, UnknownClamp};
pub use conductance_rules::{ConductanceRegion, ConductanceRules};
pub use error::{PfvError, PoreVertex, PoreVertices};
pub use extrapolation::Extrapolation;
pub use flow::Flow;
pub use flow_results::Permeability;
pub use fluid::Fluid;
pub use geometry_update::GeometryDegradation;
pub use network::{Derivatives, Network, Throats};
pub use network_conditions::NetworkConditions;
pub use operators::Operators;
pub use periodic::PeriodicNetwork;
pub use pore_conditions::{ImposedPressure, PoreConditions, PoreSelection};
pub(crate) use pore_growth::Place;
pub use profile::PressureProfile;
pub use remarks::NetworkRemarks;
pub use retired_network::RetiredNetwork;
pub use reusable_analysis::ReusableAnalysis;
pub use sealed::SealedPores;
pub use tessellation::{NONE, Tessellation};
pub use transfer::TransferSource;
pub use viscous::ViscousMode;

/// What the effects of this room say of themselves.
pub mod effects {
    pub use crate::pfv::build::PORE_FLOW;
    pub use crate::pfv::clamp::EFFECT as CONDUCTANCE_CLAMP;
    pub use crate::pfv::conductance_rules::{BLOCKED, DARCY, FACTORS};
    pub use crate::pfv::drag::FLUID_FORCES;
    pub use crate::pfv::flow_weight::BUOYANCY;
    pub use crate::pfv::pressure_gradient::EFFECT as PRESSURE_GRADIENT;
    pub use crate::pfv::profile::EFFECT as PROFILES;
    pub use crate::pfv::terms::{COMPRESSIBILITY, SOURCES};
    pub use crate::pfv::throat::WALL_SLIP;
}
