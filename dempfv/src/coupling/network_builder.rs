//! Who builds networks: from positions to a flow that is ready to solve.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::Result;
use crate::pfv::{Assembled, Flow, Fluid, ReusableAnalysis};
use crate::solver::SolverKind;
use crate::{Aabb, Vec3};

/// The positions that a network is to be built from, and how.
pub struct NetworkRequest {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The box (m).
    pub bounds: Aabb,
    /// The fluid and its boundary conditions.
    pub fluid: Fluid,
    /// The linear solver.
    pub solver: SolverKind,
    /// A factor that is no longer needed.
    pub reusable: Option<ReusableAnalysis>,
}

/// What builds networks: a place for other ways to build them, and for
/// failures in tests.
pub trait NetworkBuilder: Send + Sync {
    /// Builds a network; `None` when `cancelled` became true on the way, to
    /// be looked up between two phases.
    ///
    /// # Errors
    /// Why there is no such network.
    fn build(&self, request: NetworkRequest, cancelled: &AtomicBool) -> Result<Option<Flow>>;
}

/// Builds networks by triangulating, analyzing and factoring.
#[derive(Clone, Copy, Debug, Default)]
pub struct StandardBuilder;

impl NetworkBuilder for StandardBuilder {
    fn build(&self, request: NetworkRequest, cancelled: &AtomicBool) -> Result<Option<Flow>> {
        let stop = || cancelled.load(Ordering::Relaxed);
        let NetworkRequest { position, radius, bounds, fluid, solver, reusable } = request;
        if stop() {
            return Ok(None);
        }
        let assembled = Assembled::new(&position, &radius, bounds, &fluid)?;
        drop((position, radius));
        if stop() {
            return Ok(None);
        }
        let analyzed = assembled.analyze(solver, reusable)?;
        if stop() { Ok(None) } else { Ok(Some(analyzed.factor()?)) }
    }
}
