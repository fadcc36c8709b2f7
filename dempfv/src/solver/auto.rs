//! Which solver is the fastest for how many unknowns.

use super::{
    Backend, Cholmod, Cost, Frontal, SolverError, Symbolic, SymmetricCsc, SystemSize, cost,
};

/// From this many unknowns on the frontal solver is the faster one: some 1,500
/// spheres. Below, where a factor lies in the processor's cache whatever its
/// precision, one solve by CHOLMOD takes less than two corrections.
pub const FRONTAL_FROM: usize = 8_000;

/// CHOLMOD for small systems, the frontal solver for large ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct Auto;

impl Backend for Auto {
    fn name(&self) -> &'static str {
        "auto"
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        if a.n < FRONTAL_FROM {
            Cholmod.analyze(a, coordinates)
        } else {
            Frontal.analyze(a, coordinates)
        }
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Some(cost::auto(size.unknowns).cost(size))
    }
}
