//! `permeability`: static flow along one axis through the packing at rest.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::coupling::{CouplingError, Phase};
use crate::pfv::terms::StepTerms;
use crate::pfv::{Assembled, Boundary, Flow, NetworkConditions};
use crate::scene;
use crate::simulation::outcome::{Outcome, PermeabilityTest};
use crate::theory::{kozeny_carman, sauter_diameter};
use crate::{Axis, Cell, InputError, Result, WallId};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    axis: u8,
}

impl State {
    pub fn start(plan: &scene::Permeability) -> State {
        State { axis: plan.axis.index() as u8 }
    }

    /// The whole stage: it has no steps.
    pub fn advance(&mut self, context: &mut Context) -> Result<Progress> {
        let fluid = context.plan.fluid.as_ref().ok_or_else(|| {
            InputError::new(
                "a permeability stage in a scene without fluid",
                "add a table [fluid] with its viscosity",
            )
        })?;
        let axis = [Axis::X, Axis::Y, Axis::Z][self.axis as usize];
        let measured = match context.coupled.dem().cell().map(|cell| *cell.cell()) {
            None => between_walls(context, fluid, axis)?,
            Some(cell) => in_cell(context, fluid, axis, &cell)?,
        };
        Ok(Progress::Finished(Outcome::Permeability(measured)))
    }
}

/// From wall to wall.
fn between_walls(
    context: &mut Context,
    fluid: &scene::Fluid,
    axis: Axis,
) -> Result<PermeabilityTest> {
    let lower = WallId::ALL[2 * axis.index()];
    let mut fluid_in_pores = fluid.fluid;
    fluid_in_pores.boundary = Boundary::default();
    fluid_in_pores.boundary.pressure[lower] = Some(1.0);
    fluid_in_pores.boundary.pressure[lower.opposite()] = Some(0.0);

    let dem = context.coupled.dem();
    let particles = dem.storage();
    let conductances = fluid.effects.conductances.clone();
    let conditions = NetworkConditions { conductances, ..NetworkConditions::default() };
    let (x, r) = (&particles.position, &particles.radius);
    let terms = StepTerms::default();
    let mut flow = Assembled::with_conditions(x, r, dem.box_(), &fluid_in_pores, conditions, terms)
        .and_then(|assembled| assembled.analyze(fluid.solver, None)?.factor())
        .map_err(|e| CouplingError::from(e).with_numbers(&particles.id))?;
    context.coupled.book_build(flow.build_times());
    context.coupled.time(Phase::Solve, || flow.solve_static())?;
    let measured = flow.permeability(lower);
    let measured =
        measured.ok_or_else(|| InputError::new("no pressure difference to measure with", ""))?;
    let (value, imbalance) = (measured.value, measured.imbalance);
    Ok(PermeabilityTest { imbalance, ..test(context, &flow, axis, [value, measured.flux]) })
}

/// Through a periodic cell.
fn in_cell(
    context: &mut Context,
    fluid: &scene::Fluid,
    axis: Axis,
    cell: &Cell,
) -> Result<PermeabilityTest> {
    let particles = context.coupled.dem().storage();
    let (position, radius) = (&particles.position, &particles.radius);
    let mut flow = Flow::in_cell(position, radius, cell, &fluid.fluid, fluid.solver)
        .map_err(|e| CouplingError::from(e).with_numbers(&particles.id))?;
    context.coupled.book_build(flow.build_times());
    let tensor = context.coupled.time(Phase::Solve, || flow.permeability_tensor())?;
    let tensor = tensor.unwrap_or_default();
    let value = tensor[(axis.index(), axis.index())];
    let flux = value * cell.volume().cbrt() / fluid.fluid.viscosity;
    let rows = [0, 1, 2].map(|a| [0, 1, 2].map(|b| tensor[(a, b)]));
    let measured = test(context, &flow, axis, [value, flux]);
    Ok(PermeabilityTest { tensor_m2: Some(rows), ..measured })
}

/// What was measured, permeability (m²) and flux (m³/s), with what it was measured on.
fn test(context: &Context, flow: &Flow, axis: Axis, [value, flux]: [f64; 2]) -> PermeabilityTest {
    let dem = context.coupled.dem();
    let porosity = dem.porosity();
    PermeabilityTest {
        axis: axis.name().to_owned(),
        permeability_m2: value,
        flux_m3_s: flux,
        imbalance: flow.imbalance(),
        kozeny_carman_m2: kozeny_carman(porosity, sauter_diameter(&dem.storage().radius)),
        porosity,
        pores: flow.network().pores() as u64,
        unknowns: flow.operators().unknowns() as u64,
        residual: flow.residual().unwrap_or(0.0),
        tensor_m2: None,
    }
}
