//! Who builds networks: from positions to a flow that is ready to solve.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::Result;
use super::fluid_effects::FluidEffects;
use crate::pfv::{Assembled, Flow, Fluid, ReusableAnalysis};
use crate::solver::{Backend, Solver, SolverKind};
use crate::{Aabb, Cell, Vec3};

/// The positions that a network is to be built from, and how.
pub struct NetworkRequest {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The box (m).
    pub bounds: Aabb,
    /// The periodic cell in the place of the box; `None` between walls.
    pub cell: Option<Cell>,
    /// The fluid and its boundary conditions.
    pub fluid: Fluid,
    /// What else it does.
    pub effects: FluidEffects,
    /// Length of the step that the network is for (s); of no account where no pore stores fluid.
    pub time_step: f64,
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
        let solver = request.solver.into();
        build(request, solver, cancelled)
    }
}

/// As [`StandardBuilder`], with any solver in the place of the one that is asked for.
#[derive(Clone)]
pub struct BackendBuilder {
    backend: Arc<dyn Backend>,
}

impl BackendBuilder {
    /// Networks that this backend solves.
    pub fn new(backend: Arc<dyn Backend>) -> BackendBuilder {
        BackendBuilder { backend }
    }
}

impl NetworkBuilder for BackendBuilder {
    fn build(&self, request: NetworkRequest, cancelled: &AtomicBool) -> Result<Option<Flow>> {
        build(request, Arc::clone(&self.backend).into(), cancelled)
    }
}

fn build(request: NetworkRequest, solver: Solver, cancelled: &AtomicBool) -> Result<Option<Flow>> {
    let stop = || cancelled.load(Ordering::Relaxed);
    let NetworkRequest { position, radius, bounds, cell, fluid, effects, time_step, .. } = request;
    if stop() {
        return Ok(None);
    }
    let (terms, conditions) = (effects.step_terms(time_step)?, effects.conditions());
    let FluidEffects { sources, .. } = effects;
    let assembled = match cell {
        None => Assembled::with_conditions(&position, &radius, bounds, &fluid, conditions, terms)?,
        Some(cell) => Assembled::in_cell(&position, &radius, &cell, &fluid, terms)?,
    };
    drop(radius);
    if stop() {
        return Ok(None);
    }
    let analyzed = assembled.analyze(solver, request.reusable)?;
    if stop() {
        return Ok(None);
    }
    let mut flow = analyzed.factor()?;
    if !sources.is_empty() {
        flow.set_sources(&position, &sources)?;
    }
    Ok(Some(flow))
}
