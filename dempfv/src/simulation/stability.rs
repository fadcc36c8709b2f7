//! The bounds that a plan's packing sets to its time step before it has moved.

use serde::Serialize;

use super::setup;
use crate::coupling::{Controls, Coupled, TimeStepBounds, TimeStepRule};
use crate::dem::WallControl;
use crate::pfv::{Flow, ViscousMode};
use crate::scene::{Plan, StageKind};
use crate::{Result, WallId};

/// Spheres that a report names at most.
const NAMED_SPHERES: usize = 4;

/// The bounds that the packing of a plan sets to its time step before it has
/// moved, and the size of its network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    /// The bounds.
    pub bounds: TimeStepBounds,
    /// Which of them rules.
    pub rule: TimeStepRule,
    /// λ_max of V M⁻¹ (1/s), its residual included; 0 where nothing resists.
    pub viscous_rate: f64,
    /// The spheres that the fastest viscous mode moves most, by the user's
    /// numbers, with their shares of its kinetic energy.
    pub carriers: Vec<(u32, f64)>,
    /// How many spheres share that mode (1).
    pub participation: f64,
    /// Solves that it took.
    pub solves: u32,
    /// Pores of the network.
    pub pores: usize,
    /// Unknown pressures.
    pub unknowns: usize,
    /// Entries of the factor.
    pub factor_entries: u64,
}

impl Stability {
    /// Builds mechanics and network of a plan and looks at its first coupled
    /// stage: its walls, its friction. `None` when no stage couples a fluid.
    ///
    /// # Errors
    /// What [`Plan::validate`] finds, what is wrong with the packing, or why it has no network.
    pub fn of(plan: &Plan) -> Result<Option<Stability>> {
        plan.validate()?;
        let stage = plan.stages.iter().find(|s| s.kind.is_coupled());
        let (Some(fluid), Some(stage)) = (&plan.fluid, stage) else { return Ok(None) };
        let mut coupled = Coupled::new(setup::mechanics(plan, setup::initial_packing(plan)?)?);
        if let Some(mechanics) = plan.mechanics(stage) {
            coupled.controls().set_damping(mechanics.options.damping)?;
        }
        hold_walls(coupled.controls(), &stage.kind)?;
        coupled.compute_contacts()?;
        coupled.saturate(fluid.saturation());
        coupled.set_fluid_effects(fluid.effects.clone());
        coupled.update_viscous_mode(true)?;
        let bounds = coupled.time_step_bounds();
        let id = &coupled.dem().storage().id;
        let mode = coupled.viscous_mode();
        let flow = coupled.storage_flow();
        Ok(Some(Stability {
            bounds,
            rule: bounds.rule(),
            viscous_rate: mode.map_or(0.0, ViscousMode::upper_rate),
            carriers: mode.map_or(vec![], |m| {
                m.carriers(NAMED_SPHERES).into_iter().map(|(i, share)| (id[i], share)).collect()
            }),
            participation: mode.map_or(0.0, ViscousMode::participation),
            solves: mode.map_or(0, |m| m.solves),
            pores: flow.map_or(0, |f| f.network().pores()),
            unknowns: flow.map_or(0, |f| f.operators().unknowns()),
            factor_entries: flow.map_or(0, Flow::nnz_l),
        }))
    }
}

/// Puts the walls of a stage under its servos.
fn hold_walls(mut controls: Controls, stage: &StageKind) -> Result<()> {
    let held = |wall: WallId| match stage {
        StageKind::Consolidate(c) => (c.wall == wall).then_some((c.stress, c.max_velocity)),
        StageKind::Run(run) => match run.walls[wall] {
            WallControl::Servo { stress, max_velocity } => Some((stress, max_velocity)),
            _ => None,
        },
        _ => None,
    };
    for wall in WallId::ALL {
        if let Some((stress, max_velocity)) = held(wall) {
            controls.set_control(wall, WallControl::Servo { stress, max_velocity })?;
        }
    }
    Ok(())
}
