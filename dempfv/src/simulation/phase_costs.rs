//! Time and memory of each phase of a step, fitted to measured runs.

use super::specimen::Specimen;
use crate::coupling::{OnFailure, RemeshMode, Update};
use crate::scene::Fluid;
use crate::solver::{Cost, Fill, SystemSize};

/// Whether networks follow the spheres between remeshes.
pub(super) fn follows(fluid: &Fluid) -> bool {
    fluid.acceleration.update == Update::EveryStep
}

/// The part of a remesh that a step pays (s). With the strain rule alone, remeshes are as
/// rare as the motion is slow.
pub(super) fn remesh_share(fluid: &Fluid, step: f64, remesh: f64) -> f64 {
    let how = fluid.acceleration;
    // Eq. 15 of Caulk 2020: half an interval of steps takes as long as a remesh.
    let interval = match how.auto_interval {
        true => Some(2.0 * remesh / step),
        false => fluid.remesh.interval.map(|steps| steps as f64),
    };
    let slower = if how.remesh == RemeshMode::Background { BACKGROUND_REMESH } else { 1.0 };
    interval.map_or(0.0, |steps| slower * remesh / steps.max(1.0))
}

/// A dry step with two threads (s per sphere): contacts and integration take 0.042 µs a
/// sphere with 20,000 spheres, 0.039 with 5,000 and 0.062 with 135,000.
const DRY_STEP_PER_SPHERE: f64 = 4.5e-8;
/// Spheres from which on the contacts are shared out among threads.
const SHARED_SPHERES: usize = 2_560;
/// Part of shared work that one thread does alone (1).
const SERIAL_PART: f64 = 0.05;
/// A coupled step between remeshes, beside dry step and solve, with two threads (s per
/// pore): E and F 12 ns, the right-hand side and the flux 5.
const FLOW_STEP_PER_PORE: f64 = 1.7e-8;
/// Volumes, conductances and operators of the moment, with two threads (s per pore).
const UPDATE_PER_PORE: f64 = 3e-7;
/// Applications of the factor in an iterated solve (1), and what each takes beside the
/// factor (s per pore).
const ITERATIONS: f64 = 4.0;
const ITERATION_PER_PORE: f64 = 3e-8;
/// Triangulation, throats, operators, taking into use (s per pore): nearly all by one
/// thread.
const NETWORK_PER_PORE: f64 = 9e-7;
/// A remesh beside the steps over one in turn (1): it takes their caches and threads.
const BACKGROUND_REMESH: f64 = 1.5;

/// The program and its libraries (bytes).
pub(super) const BASE_BYTES: f64 = 12e6;
/// A picture: its points, and what they are drawn from.
pub(super) const PICTURE_BYTES: f64 = 13e6;
/// State, contacts, neighbour list.
pub(super) const BYTES_PER_SPHERE: f64 = 1200.0;
/// Network, operators, matrix, and what they are made with.
const BYTES_PER_PORE: f64 = 800.0;
/// What following the spheres takes: a network as it was built, throats, force coefficients.
const BYTES_PER_FOLLOWED_PORE: f64 = 500.0;

/// Time with so many threads over that with two (Amdahl 1967).
fn threads_factor(threads: usize) -> f64 {
    let time = |threads: f64| SERIAL_PART + (1.0 - SERIAL_PART) / threads;
    time(threads.max(1) as f64) / time(2.0)
}

/// Time of a dry step (s).
pub(super) fn dry_step(spheres: usize, threads: usize) -> f64 {
    let threads = if spheres < SHARED_SPHERES { 1 } else { threads };
    DRY_STEP_PER_SPHERE * threads_factor(threads) * spheres as f64
}

/// Pores and unknowns of a packing, and what their solver takes.
pub(super) struct FlowSize {
    pub pores: f64,
    pub unknowns: f64,
    pub cost: Cost,
    /// Time of work on all pores over that with two threads (1).
    shared: f64,
}

impl FlowSize {
    pub fn of(
        specimen: &Specimen,
        drained_walls: usize,
        fluid: &Fluid,
        threads: usize,
    ) -> FlowSize {
        let n = specimen.spheres as f64;
        let surface = n.powf(2.0 / 3.0);
        // 5,685 pores in 1,000 spheres, 29,319 in 5,000, 119,578 in 20,000, 822,396 in
        // 135,000: a bulk value less what the walls cut off. One sphere in a box has 8.
        let pores = specimen.pores.map_or((6.15 * n - 4.6 * surface).max(8.0), |p| p as f64);
        // A drained wall takes the pores that touch it out: 1,379 of 20,000 spheres.
        let drained = 1.85 * surface * drained_walls as f64;
        let unknowns = specimen.unknowns.map_or((pores - drained).max(1.0), |u| u as f64);
        let mut size = SystemSize::of_network(unknowns as usize, threads);
        if let Some(entries) = specimen.factor_entries {
            size.factor = Some(Fill { nnz_l: entries as f64, flops: size.fill().flops });
        }
        let cost = fluid.solver.cost(&size);
        let threads = if pores < SHARED_PORES { 1 } else { threads };
        FlowSize { pores, unknowns, cost, shared: threads_factor(threads) }
    }

    /// What the fluid adds to a step between remeshes (s).
    pub fn step(&self, fluid: &Fluid) -> f64 {
        let operators = FLOW_STEP_PER_PORE * self.shared * self.pores;
        if !follows(fluid) {
            return operators + self.cost.solve_to(fluid.tolerance);
        }
        let iteration = self.cost.correction + ITERATION_PER_PORE * self.shared * self.pores;
        operators + UPDATE_PER_PORE * self.shared * self.pores + ITERATIONS * iteration
    }

    /// Time of one remesh (s).
    pub fn remesh(&self) -> f64 {
        NETWORK_PER_PORE * self.pores + self.cost.analysis + self.cost.factorization
    }

    /// Most memory that networks take (bytes): the one in use makes room for the next, or
    /// stays beside it.
    pub fn bytes(&self, fluid: &Fluid) -> f64 {
        let how = fluid.acceleration;
        let beside = match how.remesh {
            RemeshMode::Background => true,
            RemeshMode::Ahead => how.on_failure == OnFailure::Retry,
            RemeshMode::AtOnce => false,
        };
        let built = BYTES_PER_PORE * self.pores + self.cost.peak_bytes;
        let held = BYTES_PER_PORE * self.pores + self.cost.held_bytes;
        built
            + if beside { held } else { 0.0 }
            + if follows(fluid) { BYTES_PER_FOLLOWED_PORE * self.pores } else { 0.0 }
    }
}

/// Pores from which on their work is shared out among threads.
const SHARED_PORES: f64 = 16_384.0;
