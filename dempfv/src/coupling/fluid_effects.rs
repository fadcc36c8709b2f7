//! What a fluid does beside flowing, without weight and incompressible, between walls.

use serde::{Deserialize, Serialize};

use super::edges::EdgeEffects;
use super::error::Result;
use crate::dem::DemError;
use crate::pfv::ImposedPressure;
use crate::pfv::terms::{Compressibility, PoreSource, StepTerms};
use crate::{Effect, EffectKey, Family, PerWall, TimeFunction, Vec3};

/// What pressures that change with time say of themselves.
pub const PRESSURE_IN_TIME: Effect = Effect {
    name: "pressures in time",
    family: Family::Fluid,
    equation: "p_wall = p(t + dt) in the step from t on",
    source: "a boundary condition",
    keys: &[EffectKey { key: "pressure in [fluid]", unit: "Pa", default: "none" }],
    needs: "",
    test: "dempfv/tests/coupling_conditions.rs",
};

/// What pressures of pores beside walls say of themselves.
pub const IMPOSED_REGIONS: Effect = Effect {
    name: "pressures of regions",
    family: Family::Fluid,
    equation: "p_i = p for pores whose centroid lies in a region",
    source: "a boundary condition",
    keys: &[EffectKey { key: "imposed in [fluid]", unit: "Pa", default: "none" }],
    needs: "",
    test: "dempfv/tests/coupling_conditions.rs",
};

/// Effects of the fluid that are off unless someone asks for them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FluidEffects {
    /// Bulk modulus of the fluid (Pa); `None`: incompressible.
    pub bulk_modulus: Option<f64>,
    /// Density of the fluid (kg/m³), which spheres under gravity feel as buoyancy; `None`: no weight.
    pub density: Option<f64>,
    /// Pressures of walls that change with time (Pa), in the place of those of
    /// [`Boundary`](crate::pfv::Boundary), which are needed too and hold at the beginning.
    pub wall_pressure: PerWall<Option<TimeFunction>>,
    /// Model time from which these functions count (s).
    pub wall_pressure_start: f64,
    /// Pressures imposed on pores of choice.
    pub imposed: Vec<ImposedPressure>,
    /// What enters pores of choice.
    pub sources: Vec<PoreSource>,
    /// Mean pressure gradient through a periodic cell (Pa/m).
    pub pressure_gradient: Option<Vec3>,
    /// Forces between neighbours.
    pub edges: EdgeEffects,
}

impl FluidEffects {
    /// Whether pores store fluid, so that the matrix of a network goes with the time step.
    pub fn store(&self) -> bool {
        self.bulk_modulus.is_some()
    }

    /// Refuses what a periodic cell has no place for.
    pub(super) fn check_in_cell(&self) -> Result<()> {
        let effects = [
            (!self.imposed.is_empty(), "a pressure imposed on pores"),
            (!self.sources.is_empty(), "a source of fluid"),
            (self.density.is_some(), "a fluid with weight"),
            (self.wall_pressure.values().any(Option::is_some), "a pressure of a wall"),
        ];
        match effects.into_iter().find(|(given, _)| *given) {
            None => Ok(()),
            Some((_, what)) => {
                let remedy = "a mean pressure gradient drives the flow there";
                Err(DemError::InCell { what, remedy }.into())
            }
        }
    }

    /// Pressures (Pa) of the walls with one that changes, at a time (s); `None` where there are no
    /// such walls.
    pub(super) fn wall_pressures(&self, time: f64) -> Option<PerWall<Option<f64>>> {
        let changes = self.wall_pressure.values().any(Option::is_some);
        let since = time - self.wall_pressure_start;
        changes.then(|| self.wall_pressure.map(|p| p.as_ref().map(|p| p.value(since))))
    }

    /// The terms that the matrix of a network is made with, for a first step of this length (s).
    pub(super) fn step_terms(&self, time_step: f64) -> Result<StepTerms> {
        let mut step = StepTerms { terms: vec![], time_step };
        if let Some(bulk_modulus) = self.bulk_modulus {
            step.terms.push(Box::new(Compressibility::new(bulk_modulus)?));
        }
        Ok(step)
    }
}
