//! What a fluid does beside flowing, without weight and incompressible, between walls.

use serde::{Deserialize, Serialize};

use super::edges::EdgeEffects;
use super::error::Result;
use crate::dem::DemError;
use crate::pfv::terms::{Compressibility, PoreSource, StepTerms};
use crate::pfv::{ConductanceRules, Flow, ImposedPressure, NetworkConditions, PressureProfile};
use crate::{Effect, EffectKey, Family, PerWall, TimeFunction, Vec3};

/// What conditions that change with time say of themselves.
pub const IN_TIME: Effect = Effect {
    name: "conditions in time",
    family: Family::Fluid,
    equation: "p = p(t + dt) and Q = Q(t + dt) in the step from t on, of walls and of regions",
    source: "a boundary condition",
    keys: &[
        EffectKey { key: "pressure in [fluid]", unit: "Pa", default: "constant" },
        EffectKey { key: "imposed in [fluid]", unit: "Pa", default: "constant" },
        EffectKey { key: "sources in [fluid]", unit: "m³/s", default: "constant" },
    ],
    needs: "",
    test: "dempfv/tests/coupling_conditions.rs",
};

/// What pressures of pores beside walls say of themselves.
pub const IMPOSED_REGIONS: Effect = Effect {
    name: "pressures of regions",
    family: Family::Fluid,
    equation: "p_i = p for pores whose centroid lies in a region, and those that contain a point",
    source: "a boundary condition",
    keys: &[EffectKey { key: "imposed in [fluid]", unit: "Pa", default: "none" }],
    needs: "",
    test: "dempfv/tests/coupling_conditions.rs",
};

/// What the one-way coupling says of itself.
pub const ONE_WAY: Effect = Effect {
    name: "one-way coupling",
    family: Family::Fluid,
    equation: "dV_i/dt = 0 in the balance of the pores; f = F p on spheres and walls as ever",
    source: "a limit: motion much slower than the flow",
    keys: &[EffectKey { key: "coupling in [fluid]", unit: "", default: "\"two-way\"" }],
    needs: "pore flow",
    test: "dempfv/tests/coupling_one_way.rs",
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
    /// Pressures along walls, beside those.
    pub wall_profile: PerWall<Option<PressureProfile>>,
    /// Pressures imposed on pores of choice.
    pub imposed: Vec<ImposedPressure>,
    /// Those of them that change with time (Pa), by their places; the others, and places beyond the
    /// end, do not.
    pub imposed_in_time: Vec<Option<TimeFunction>>,
    /// What enters pores of choice.
    pub sources: Vec<PoreSource>,
    /// Rates of them that change with time (m³/s), by their places.
    pub sources_in_time: Vec<Option<TimeFunction>>,
    /// How throats conduct.
    pub conductances: ConductanceRules,
    /// The flow pushes spheres and walls, but their motion squeezes no fluid.
    pub one_way: bool,
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
            (self.wall_profile.values().any(Option::is_some), "a pressure along a wall"),
        ];
        if let Some((_, what)) = effects.into_iter().find(|(given, _)| *given) {
            let remedy = "a mean pressure gradient drives the flow there";
            return Err(DemError::InCell { what, remedy }.into());
        }
        if self.conductances != ConductanceRules::default() {
            let what = "a conductance that is not what the geometry says";
            let remedy = "leave it out, or put walls around";
            return Err(DemError::InCell { what, remedy }.into());
        }
        Ok(())
    }

    /// Whether a condition changes with time.
    pub fn change_in_time(&self) -> bool {
        let pores = self.imposed_in_time.iter().chain(&self.sources_in_time);
        self.wall_pressure.values().chain(pores).any(Option::is_some)
    }

    /// Tells a flow the conditions at a time (s), where they change with it.
    pub(super) fn impose(&self, flow: &mut Flow, time: f64) -> Result<()> {
        for (wall, function) in self.wall_pressure.iter() {
            if let Some(function) = function {
                flow.set_wall_pressure(wall, function.value(time - self.wall_pressure_start))?;
            }
        }
        for (number, function) in self.imposed_in_time.iter().enumerate() {
            if let Some(function) = function {
                flow.set_imposed_pressure(number, function.value(time))?;
            }
        }
        for (number, function) in self.sources_in_time.iter().enumerate() {
            if let Some(function) = function {
                flow.set_source_rate(number, function.value(time))?;
            }
        }
        Ok(())
    }

    /// What a network is asked for beside the constant pressures of walls.
    pub fn conditions(&self) -> NetworkConditions {
        NetworkConditions {
            profiles: self.wall_profile.clone(),
            imposed: self.imposed.clone(),
            conductances: self.conductances.clone(),
        }
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
