//! The bounds on the time step of spheres and fluid together.

use serde::{Deserialize, Serialize};

use super::setup;
use super::{Coupled, TimeStepBounds, TimeStepRule, viscous_time_step};
use crate::dem::{Dem, WallControl};
use crate::pfv::{Flow, ViscousMode};
use crate::scene::{self, Plan, StageKind};
use crate::{Result, WallId};

/// Spheres that a report names at most.
const NAMED: usize = 4;
/// A viscous bound of more than so many times the contacts' need not be known
/// well: it takes less than this share of their step away.
const IRRELEVANT: f64 = 50.0;

/// The fastest viscous mode of the network in use, or of one before it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct FastestMode {
    mode: Option<ViscousMode>,
    /// The walls held by a servo when it was found; `None` when it is the mode
    /// of an earlier network.
    servo: Option<[bool; 6]>,
}

impl FastestMode {
    /// The same mode, for a new network to start from.
    pub fn outdated(self) -> FastestMode {
        FastestMode { servo: None, ..self }
    }

    /// Whether the mode is known for the network in use and these walls.
    pub fn is_current(&self, dem: &Dem) -> bool {
        self.servo == Some(servo_walls(dem))
    }

    /// Finds the mode; roughly, unless `exact`, where the contacts bound the
    /// time step anyway.
    pub fn update(&mut self, flow: &mut Flow, dem: &mut Dem, exact: bool) -> Result<()> {
        let servo = servo_walls(dem);
        let start = self.mode.as_ref().map(|m| &m.shape[..]);
        let negligible = match exact {
            true => 0.0,
            false => bound_of(IRRELEVANT * dem.safe_time_step(1.0), dem.options().damping),
        };
        self.mode = flow.viscous_mode(&dem.particles().mass, servo, start, negligible)?;
        self.servo = Some(servo);
        Ok(())
    }

    /// The mode of the network in use, if it is known.
    pub fn current(&self) -> Option<&ViscousMode> {
        self.mode.as_ref().filter(|_| self.servo.is_some())
    }

    /// The viscous bound of the network in use (s): infinite where nothing
    /// resists, `None` where it is not known.
    fn bound(&self, damping: f64) -> Option<f64> {
        self.servo?;
        Some(bound_of(self.mode.as_ref().map_or(0.0, ViscousMode::upper_rate), damping))
    }
}

/// The bound (s) that a viscous rate (1/s) sets to the time step, or the rate
/// that sets a bound: 2/x, over 1 + the local damping. That damping makes a
/// force which brakes larger by its factor, and a viscous force always brakes.
fn bound_of(x: f64, damping: f64) -> f64 {
    2.0 / (x * (1.0 + damping))
}

/// The walls that a servo holds.
fn servo_walls(dem: &Dem) -> [bool; 6] {
    dem.walls().each_ref().map(|w| matches!(w.control, WallControl::Servo { .. }))
}

/// The bounds of spheres with or without a fluid of this viscosity (Pa·s).
pub(super) fn bounds(
    dem: &mut Dem,
    viscosity: Option<f64>,
    fastest: Option<&FastestMode>,
) -> TimeStepBounds {
    let smallest = dem.particles().radius.iter().copied().fold(f64::INFINITY, f64::min);
    TimeStepBounds {
        contact: dem.safe_time_step(1.0),
        viscous_estimate: viscosity
            .map(|mu| viscous_time_step(smallest, dem.material().density, mu)),
        viscous: fastest.and_then(|f| f.bound(dem.options().damping)),
    }
}

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
    /// What is wrong with the packing, or why it has no network.
    pub fn of(plan: &Plan) -> Result<Option<Stability>> {
        let stage = plan.stages.iter().find(|s| s.kind.is_coupled());
        let (Some(fluid), Some(stage)) = (&plan.fluid, stage) else { return Ok(None) };
        let mut coupled = Coupled::new(setup::mechanics(plan)?);
        hold_walls(&mut coupled.dem, &stage.kind)?;
        coupled.dem.compute_contacts()?;
        coupled.saturate(setup::saturation(fluid));
        coupled.update_viscous_mode(true)?;
        let bounds = coupled.time_step_bounds();
        let id = &coupled.dem.particles().id;
        let mode = coupled.viscous_mode();
        let flow = coupled.flow();
        Ok(Some(Stability {
            bounds,
            rule: bounds.rule(),
            viscous_rate: mode.map_or(0.0, ViscousMode::upper_rate),
            carriers: mode.map_or(vec![], |m| {
                m.carriers(NAMED).into_iter().map(|(i, share)| (id[i], share)).collect()
            }),
            participation: mode.map_or(0.0, ViscousMode::participation),
            solves: mode.map_or(0, |m| m.solves),
            pores: flow.map_or(0, |f| f.network.pores()),
            unknowns: flow.map_or(0, |f| f.operators.unknowns()),
            factor_entries: flow.map_or(0, Flow::nnz_l),
        }))
    }
}

/// Puts the walls of a stage under its servos.
fn hold_walls(dem: &mut Dem, stage: &StageKind) -> Result<()> {
    let held = |wall: WallId| match stage {
        StageKind::Consolidate(c) => (c.wall == wall).then_some((c.stress, c.max_velocity)),
        StageKind::Run(run) => match run.walls[wall.index()] {
            scene::WallControl::Stress { stress, max_velocity } => Some((stress, max_velocity)),
            _ => None,
        },
        _ => None,
    };
    for wall in WallId::ALL {
        if let Some((stress, max_velocity)) = held(wall) {
            dem.set_control(wall, WallControl::Servo { stress, max_velocity })?;
        }
    }
    Ok(())
}
