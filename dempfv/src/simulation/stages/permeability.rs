//! `permeability`: static flow along one axis through the packing at rest.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::coupling::{CouplingError, Phase};
use crate::pfv::{Boundary, Flow};
use crate::scene;
use crate::simulation::outcome::{Outcome, PermeabilityTest};
use crate::theory::{KOZENY_CARMAN, kozeny_carman, sauter_diameter};
use crate::{Axis, InputError, Result, WallId};

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
        let axis = [Axis::X, Axis::Y, Axis::Z][self.axis as usize];
        let lower = WallId::ALL[2 * axis.index()];
        let slip_walls = fluid(context)?.fluid.slip_walls;
        let flow = flow(context, lower, slip_walls)?;
        let no_flow = || InputError::new("no pressure difference to measure with", "");
        let measured = flow.permeability(lower).ok_or_else(no_flow)?;
        let other = self::flow(context, lower, !slip_walls)?;
        let other = other.permeability(lower).ok_or_else(no_flow)?;
        let dem = context.coupled.dem();
        let (porosity, diameter) = (dem.porosity(), sauter_diameter(&dem.storage().radius));
        let (slip, no_slip) = match slip_walls {
            true => (measured.value, other.value),
            false => (other.value, measured.value),
        };
        Ok(Progress::Finished(Outcome::Permeability(PermeabilityTest {
            axis: axis.name().to_owned(),
            permeability_m2: measured.value,
            slip_walls,
            slip_permeability_m2: slip,
            no_slip_permeability_m2: no_slip,
            core_permeability_m2: flow.core_permeability(lower, diameter),
            flux_m3_s: measured.flux,
            imbalance: measured.imbalance,
            kozeny_carman_m2: kozeny_carman(porosity, diameter),
            kozeny_carman_constant: KOZENY_CARMAN,
            sauter_diameter_m: diameter,
            porosity,
            pores: flow.network().pores() as u64,
            unknowns: flow.operators().unknowns() as u64,
            residual: flow.residual().unwrap_or(0.0),
        })))
    }
}

fn fluid<'a>(context: &Context<'a>) -> Result<&'a scene::Fluid> {
    let plan = context.plan;
    Ok(plan.fluid.as_ref().ok_or_else(|| {
        InputError::new(
            "a permeability stage in a scene without fluid",
            "add a table [fluid] with its viscosity",
        )
    })?)
}

/// The static flow with 1 Pa on a wall and 0 on the opposite one.
fn flow(context: &mut Context, lower: WallId, slip_walls: bool) -> Result<Flow> {
    let fluid = fluid(context)?;
    let mut in_pores = fluid.fluid;
    in_pores.slip_walls = slip_walls;
    in_pores.boundary = Boundary::default();
    in_pores.boundary.pressure[lower] = Some(1.0);
    in_pores.boundary.pressure[lower.opposite()] = Some(0.0);
    let dem = context.coupled.dem();
    let particles = dem.storage();
    let (position, radius) = (&particles.position, &particles.radius);
    let mut flow = Flow::new(position, radius, dem.box_(), &in_pores, fluid.solver)
        .map_err(|e| CouplingError::from(e).with_numbers(&particles.id))?;
    context.coupled.book_build(flow.build_times());
    context.coupled.time(Phase::Solve, || flow.solve_static())?;
    Ok(flow)
}
