//! The fluid in the pores, and when its network is renewed.

use serde::{Deserialize, Serialize};

use crate::pfv::Fluid;
use crate::solver::SolverKind;

/// When the pore network is built anew: whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RemeshRule {
    /// After so many steps (λ_rm).
    pub interval: Option<u64>,
    /// When a pore's volume has changed by this share (eq. 14 of Caulk 2020).
    pub strain: Option<f64>,
}

/// A fluid in the pores: what it is, and how its flow is computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saturation {
    /// The fluid and its boundary conditions.
    pub fluid: Fluid,
    /// The linear solver.
    pub solver: SolverKind,
    /// When to remesh.
    pub remesh: RemeshRule,
}
