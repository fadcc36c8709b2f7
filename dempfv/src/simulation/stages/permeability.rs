//! `permeability`: static flow along one axis through the packing at rest.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::coupling::{CouplingError, Phase};
use crate::pfv::terms::StepTerms;
use crate::pfv::{Assembled, Boundary, Flow, NetworkConditions};
use crate::scene;
use crate::simulation::outcome::{Outcome, PermeabilityTest};
use crate::theory::{KOZENY_CARMAN, kozeny_carman, sauter_diameter};
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
        Ok(Progress::finished(Outcome::Permeability(measured)))
    }
}

/// From wall to wall, with walls as the scene has them and with the other kind.
fn between_walls(
    context: &mut Context,
    fluid: &scene::Fluid,
    axis: Axis,
) -> Result<PermeabilityTest> {
    let lower = WallId::ALL[2 * axis.index()];
    let slip_walls = fluid.fluid.slip_walls;
    let flow = flow(context, fluid, lower, slip_walls)?;
    let no_flow = || InputError::new("no pressure difference to measure with", "");
    let measured = flow.permeability(lower).ok_or_else(no_flow)?;
    let other = self::flow(context, fluid, lower, !slip_walls)?;
    let other = other.permeability(lower).ok_or_else(no_flow)?;
    let (value, imbalance) = (measured.value, measured.imbalance);
    let (slip, no_slip) = if slip_walls { (value, other.value) } else { (other.value, value) };
    let test = test(context, &flow, axis, [value, measured.flux]);
    Ok(PermeabilityTest {
        imbalance,
        slip_walls: Some(slip_walls),
        slip_permeability_m2: Some(slip),
        no_slip_permeability_m2: Some(no_slip),
        core_permeability_m2: flow.core_permeability(lower, test.sauter_diameter_m),
        ..test
    })
}

/// The static flow with 1 Pa on a wall and 0 on the opposite one.
fn flow(
    context: &mut Context,
    fluid: &scene::Fluid,
    lower: WallId,
    slip_walls: bool,
) -> Result<Flow> {
    let mut in_pores = fluid.fluid;
    in_pores.slip_walls = slip_walls;
    in_pores.boundary = Boundary::default();
    in_pores.boundary.pressure[lower] = Some(1.0);
    in_pores.boundary.pressure[lower.opposite()] = Some(0.0);
    let dem = context.coupled.dem();
    let particles = dem.storage();
    let conductances = fluid.effects.conductances.clone();
    let conditions = NetworkConditions { conductances, ..NetworkConditions::default() };
    let (x, r) = (&particles.position, &particles.radius);
    let terms = StepTerms::default();
    let mut flow = Assembled::with_conditions(x, r, dem.box_(), &in_pores, conditions, terms)
        .and_then(|assembled| assembled.analyze(fluid.solver, None)?.factor())
        .map_err(|e| CouplingError::from(e).with_numbers(&particles.id))?;
    context.coupled.book_build(flow.build_times());
    context.coupled.time(Phase::Solve, || flow.solve_static())?;
    Ok(flow)
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
    let (porosity, diameter) = (dem.porosity(), sauter_diameter(&dem.storage().radius));
    PermeabilityTest {
        axis: axis.name().to_owned(),
        permeability_m2: value,
        slip_walls: None,
        slip_permeability_m2: None,
        no_slip_permeability_m2: None,
        core_permeability_m2: None,
        flux_m3_s: flux,
        imbalance: flow.imbalance(),
        kozeny_carman_m2: kozeny_carman(porosity, diameter),
        kozeny_carman_constant: KOZENY_CARMAN,
        sauter_diameter_m: diameter,
        porosity,
        pores: flow.network().pores() as u64,
        unknowns: flow.operators().unknowns() as u64,
        residual: flow.residual().unwrap_or(0.0),
        tensor_m2: None,
    }
}
