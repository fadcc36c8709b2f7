//! `permeability`: static flow along one axis through the packing at rest.

use serde::{Deserialize, Serialize};

use super::context::{Context, Progress};
use crate::coupling::{CouplingError, Phase};
use crate::pfv::terms::StepTerms;
use crate::pfv::{Assembled, Boundary, NetworkConditions};
use crate::scene;
use crate::simulation::outcome::{Outcome, PermeabilityTest};
use crate::theory::{kozeny_carman, sauter_diameter};
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
        let fluid = context.plan.fluid.as_ref().ok_or_else(|| {
            InputError::new(
                "a permeability stage in a scene without fluid",
                "add a table [fluid] with its viscosity",
            )
        })?;
        let axis = [Axis::X, Axis::Y, Axis::Z][self.axis as usize];
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
        let mut flow =
            Assembled::with_conditions(x, r, dem.box_(), &fluid_in_pores, conditions, terms)
                .and_then(|assembled| assembled.analyze(fluid.solver, None)?.factor())
                .map_err(|e| CouplingError::from(e).with_numbers(&particles.id))?;
        context.coupled.book_build(flow.build_times());
        context.coupled.time(Phase::Solve, || flow.solve_static())?;
        let measured = flow.permeability(lower);
        let measured = measured
            .ok_or_else(|| InputError::new("no pressure difference to measure with", ""))?;
        let dem = context.coupled.dem();
        let porosity = dem.porosity();
        Ok(Progress::Finished(Outcome::Permeability(PermeabilityTest {
            axis: axis.name().to_owned(),
            permeability_m2: measured.value,
            flux_m3_s: measured.flux,
            imbalance: measured.imbalance,
            kozeny_carman_m2: kozeny_carman(porosity, sauter_diameter(&dem.storage().radius)),
            porosity,
            pores: flow.network().pores() as u64,
            unknowns: flow.operators().unknowns() as u64,
            residual: flow.residual().unwrap_or(0.0),
        })))
    }
}
