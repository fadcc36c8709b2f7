//! `[fluid]`: the fluid in the pores, and how its flow is computed.

use serde::Serialize;

use super::fluid_conditions;
use super::keys::{Keyed, Keys};
use super::kind::{Count, Flag, Kind, Maybe, OneOf, Vector, number, quoted};
use super::lubrication;
use super::schema::Schema;
use super::table::{Bound, Table, Value};
use super::wall_pressure::{AtWall, WallPressure, wrong_profile};
use super::wrong::Wrong;
use crate::coupling::effects::{
    BACKGROUND_REMESH, EVERY_STEP, IMPOSED_REGIONS, IN_TIME, ONE_WAY, PARALLEL_TASKS,
};
use crate::coupling::{
    Acceleration, FluidEffects, OnFailure, PRESSURE_ERROR, RemeshMode, RemeshRule, Saturation,
    Swap, Update,
};
use crate::domain::{Aabb, PerWall, WallId};
use crate::input::InputError;
use crate::pfv::effects::{
    BLOCKED, BUOYANCY, COMPRESSIBILITY, CONDUCTANCE_CLAMP, DARCY, FACTORS, FLUID_FORCES, PORE_FLOW,
    PRESSURE_GRADIENT, PROFILES, SOURCES, WALL_SLIP,
};
use crate::pfv::{self, Boundary, Clamp, ConductanceRules, SealedPoreRule};
use crate::solver::SolverKind;
use crate::{Effect, TimeFunction};

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[fluid]",
    &[
        "viscosity",
        "bulk_modulus",
        "density",
        "remesh_interval",
        "remesh_strain",
        "remesh",
        "swap",
        "on_failure",
        "update",
        "parallel_tasks",
        "slip_walls",
        "clamp",
        "solver",
        "tolerance",
        "gpu_device",
        "gpu_memory",
        "pressure",
        "no_flow",
        "sealed_pores",
        "imposed",
        "sources",
        "coupling",
        "darcy_permeability",
        "conductance_factor",
        "conductance_regions",
        "blocked",
        "pressure_gradient",
        "viscous_shear",
        "normal_lubrication",
        "shear_lubrication",
        "pump_torque",
        "twist_torque",
        "eps",
        "lubrication_stiffness",
    ],
);
pub(super) static PRESSURE: Schema = Schema::by_wall("`pressure`");

/// The fluid and how its flow is computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fluid {
    /// What it is, and what it meets at the walls. Default: water (1e-3 Pa·s) that slips along
    /// the walls, without bounds on conductances, no pressure imposed.
    #[serde(flatten)]
    pub fluid: pfv::Fluid,
    /// What it does beside flowing. Default: nothing.
    #[serde(flatten)]
    pub effects: FluidEffects,
    /// When networks are built anew. Default: every 200 steps.
    pub remesh: RemeshRule,
    /// How they are renewed while the spheres move on. Default: plainly.
    pub acceleration: Acceleration,
    /// Linear solver. Default: by the number of unknowns.
    pub solver: SolverKind,
    /// What a solve may leave: of the imbalance of fluid mass, and of the estimated error of the
    /// pressures (1). Default 1e-11; in a scene whose networks follow the spheres 1e-6.
    pub tolerance: f64,
}

impl Default for Fluid {
    fn default() -> Fluid {
        Fluid {
            fluid: pfv::Fluid {
                viscosity: 1e-3,
                slip_walls: true,
                clamp: Clamp::None,
                boundary: Boundary::default(),
            },
            effects: FluidEffects::default(),
            remesh: RemeshRule { interval: Some(200), strain: None },
            acceleration: Acceleration::default(),
            solver: SolverKind::default(),
            tolerance: 1e-11,
        }
    }
}

impl Fluid {
    /// Walls with an imposed pressure (Pa), in the order of their indices.
    pub fn pressure_walls(&self) -> impl Iterator<Item = (WallId, f64)> + '_ {
        WallId::ALL.into_iter().filter_map(|w| Some((w, self.fluid.boundary.pressure[w]?)))
    }

    /// Whether the pressure of a wall changes with time or along the wall.
    pub(super) fn changes_pressures(&self) -> bool {
        let FluidEffects { wall_pressure, wall_profile, .. } = &self.effects;
        wall_pressure.values().any(Option::is_some) || wall_profile.values().any(Option::is_some)
    }

    /// The fluid with other pressures on the walls (Pa), with the time from `start` on (s).
    pub fn with_pressures(&self, walls: &PerWall<Option<TimeFunction>>, start: f64) -> Fluid {
        let mut fluid = self.clone();
        fluid.fluid.boundary.pressure = walls.map(|p| p.as_ref().map(|p| p.value(0.0)));
        fluid.effects.wall_pressure = walls.map(changing);
        fluid.effects.wall_profile = PerWall::default();
        fluid.effects.wall_pressure_start = start;
        fluid
    }

    /// What fills the pores of a coupled stage.
    pub fn saturation(&self) -> Saturation {
        Saturation { fluid: self.fluid, solver: self.solver, remesh: self.remesh }
    }
}

impl Keyed for Fluid {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        let Fluid { fluid, effects, remesh, acceleration, .. } = self;
        keys.need_number("viscosity", number("Pa·s", Bound::Positive), &mut fluid.viscosity)?;
        let modulus = Maybe(number("Pa", Bound::Positive));
        keys.take("bulk_modulus", &modulus, &mut effects.bulk_modulus)?;
        let density = Maybe(number("kg/m³", Bound::Positive));
        keys.take("density", &density, &mut effects.density)?;
        keys.take("remesh_strain", &Maybe(number("", Bound::Positive)), &mut remesh.strain)?;
        interval(keys, remesh, acceleration)?;
        networks(keys, acceleration)?;
        keys.take("slip_walls", &Flag, &mut fluid.slip_walls)?;
        keys.take("clamp", &OneOf(&Clamp::ALL.map(|c| (c.name(), c))), &mut fluid.clamp)?;
        solver(keys, &mut self.solver)?;
        if let Keys::Read(_) = keys
            && acceleration.update == Update::EveryStep
        {
            self.tolerance = PRESSURE_ERROR;
        }
        keys.take("tolerance", &number("", Bound::InsideUnit), &mut self.tolerance)?;
        pressure(keys, &mut fluid.boundary, effects)?;
        let rules = SealedPoreRule::ALL.map(|rule| (rule.name(), rule));
        keys.take("sealed_pores", &OneOf(&rules), &mut fluid.boundary.sealed_pores)?;
        keys.take("coupling", &OneOf(&COUPLINGS), &mut effects.one_way)?;
        fluid_conditions::keys(keys, effects)?;
        let clamped = fluid.clamp != Clamp::None;
        let darcy = effects.conductances.darcy_permeability.is_some();
        keys.rule("darcy_permeability", (darcy && clamped).then(darcy_beside_clamp))?;
        keys.take("pressure_gradient", &Maybe(Vector("Pa/m")), &mut effects.pressure_gradient)?;
        lubrication::keys(keys, &mut effects.edges)?;
        match keys {
            Keys::Read(table) => check_no_flow(table, &fluid.boundary),
            Keys::Check(_) | Keys::Write(_) => Ok(()),
        }
    }
}

/// Pressures of walls. The boundary has them at the beginning; what changes with time, and along the
/// walls, is among the effects.
fn pressure(keys: &mut Keys, boundary: &mut Boundary, effects: &mut FluidEffects) -> Result<()> {
    let FluidEffects { wall_pressure: in_time, wall_profile, .. } = effects;
    let mut all = PerWall::from_fn(|w| {
        let level = in_time[w].clone().or(boundary.pressure[w].map(TimeFunction::Constant))?;
        Some(WallPressure { level, profile: wall_profile[w].clone() })
    });
    keys.by_wall("pressure", &PRESSURE, &Maybe(AtWall), &mut all.0)?;
    keys.rule("pressure", wrong_profile(&all))?;
    let level = all.map(|p| p.as_ref().map(|p| p.level.clone()));
    boundary.pressure = level.map(|p| p.as_ref().map(|p| p.value(0.0)));
    *in_time = level.map(changing);
    *wall_profile = all.map(|p| p.as_ref().and_then(|p| p.profile.clone()));
    Ok(())
}

/// A function that is not always the same.
fn changing(function: &Option<TimeFunction>) -> Option<TimeFunction> {
    function.clone().filter(|p| !matches!(p, TimeFunction::Constant(_)))
}

/// Whether motion squeezes no fluid.
const COUPLINGS: [(&str, bool); 2] = [("two-way", false), ("one-way", true)];

fn darcy_beside_clamp() -> Wrong {
    Wrong::new(
        "stands beside a `clamp`, which bounds what the geometry says",
        "leave one of the two out",
    )
}

/// When networks are built anew. The strain has been looked at.
fn interval(keys: &mut Keys, remesh: &mut RemeshRule, how: &mut Acceleration) -> Result<()> {
    if let Keys::Read(table) = keys
        && remesh.strain.is_some()
        && table.get("remesh_interval").is_none()
    {
        remesh.interval = None;
    }
    let mut interval = match remesh.interval {
        _ if how.auto_interval => Interval::Auto,
        Some(steps) => Interval::Steps(steps),
        None => Interval::Never,
    };
    keys.take("remesh_interval", &Intervals, &mut interval)?;
    how.auto_interval = interval == Interval::Auto;
    remesh.interval = if let Interval::Steps(steps) = interval { Some(steps) } else { None };
    let never = interval == Interval::Never && remesh.strain.is_none();
    let wrong = || {
        Wrong::new("is none, and there is no `remesh_strain`", "give one of the two, or \"auto\"")
    };
    keys.rule("remesh_interval", never.then(wrong))
}

#[derive(Clone, Copy, PartialEq)]
enum Interval {
    Auto,
    Steps(u64),
    Never,
}

struct Intervals;

impl Kind<Interval> for Intervals {
    fn read(&self, value: &Value) -> Result<Interval> {
        match value.is_name() {
            true => value.choice(&[("auto", Interval::Auto)]),
            false => value.count(1).map(Interval::Steps),
        }
    }

    fn wrong(&self, interval: &Interval) -> Option<Wrong> {
        match interval {
            Interval::Steps(steps) => Count(1).wrong(steps),
            Interval::Auto | Interval::Never => None,
        }
    }

    fn write(&self, interval: &Interval) -> Option<String> {
        match interval {
            Interval::Auto => Some(quoted("auto")),
            Interval::Steps(steps) => Some(steps.to_string()),
            Interval::Never => None,
        }
    }
}

/// How networks are renewed; what the mode has no use for is an error.
fn networks(keys: &mut Keys, how: &mut Acceleration) -> Result<()> {
    keys.take("remesh", &OneOf(&RemeshMode::ALL.map(|m| (m.name(), m))), &mut how.remesh)?;
    let background = how.remesh == RemeshMode::Background;
    let auto = how.auto_interval && !background;
    keys.rule(
        "remesh_interval",
        auto.then(|| {
            Wrong::new(
                "is \"auto\", which balances the time loop against a background that is not there",
                "add `remesh = \"background\"`, or give a number of steps",
            )
        }),
    )?;
    keys.take("swap", &OneOf(&Swap::ALL.map(|s| (s.name(), s))), &mut how.swap)?;
    let early = how.swap == Swap::WhenReady && !background;
    keys.rule(
        "swap",
        early.then(|| {
            Wrong::new(
                "is \"when ready\", but nothing is built in the background",
                "add `remesh = \"background\"`",
            )
        }),
    )?;
    let failures = OnFailure::ALL.map(|f| (f.name(), f));
    keys.take("on_failure", &OneOf(&failures), &mut how.on_failure)?;
    let retry = how.on_failure == OnFailure::Retry && how.remesh == RemeshMode::AtOnce;
    keys.rule(
        "on_failure",
        retry.then(|| {
            Wrong::new(
                "is \"retry\", but a remesh at once has no old network left to go on with",
                "add `remesh = \"ahead\"` or `remesh = \"background\"`",
            )
        }),
    )?;
    keys.take("update", &OneOf(&Update::ALL.map(|u| (u.name(), u))), &mut how.update)?;
    keys.take("parallel_tasks", &Flag, &mut how.parallel_tasks)
}

/// The solver, and what only one of them uses.
fn solver(keys: &mut Keys, solver: &mut SolverKind) -> Result<()> {
    if let Keys::Write(_) = keys {
        keys.push(("solver", quoted(solver.name())));
    } else {
        let choices: Vec<_> = SolverKind::CHOICES.iter().map(|s| (s.name(), *s)).collect();
        keys.take("solver", &OneOf(&choices), solver)?;
    }
    if let SolverKind::CholmodGpu(options) = solver {
        keys.take("gpu_device", &Count(0), &mut options.device)?;
        return keys.take("gpu_memory", &Maybe(Bytes), &mut options.memory);
    }
    let Keys::Read(table) = keys else { return Ok(()) };
    match table.get("gpu_device").or_else(|| table.get("gpu_memory")) {
        Some(value) => {
            Err(value
                .error("is given, but the solver uses no GPU", "add `solver = \"cholmod-gpu\"`"))
        }
        None => Ok(()),
    }
}

/// A size in bytes, which may be given with an exponent.
struct Bytes;

impl Kind<u64> for Bytes {
    fn read(&self, value: &Value) -> Result<u64> {
        Ok(value.number("bytes", Bound::Positive)? as u64)
    }

    fn wrong(&self, bytes: &u64) -> Option<Wrong> {
        Count(1).wrong(bytes)
    }

    fn write(&self, bytes: &u64) -> Option<String> {
        Some(bytes.to_string())
    }
}

/// A wall with an imposed pressure must not be in `no_flow` too.
fn check_no_flow(table: &Table, boundary: &Boundary) -> Result<()> {
    let Some(value) = table.get("no_flow") else { return Ok(()) };
    for item in value.items("an array of wall names, as in [\"x_min\", \"x_max\"]")? {
        let wall = item.wall()?;
        if boundary.pressure[wall].is_some() {
            return Err(item.error(
                &format!("names {wall}, which has two conditions: a pressure and no flow"),
                format!("take {wall} out of `pressure` or out of `no_flow`"),
            ));
        }
    }
    Ok(())
}

impl Fluid {
    /// An incompressible fluid whose pressure is imposed nowhere has a singular system: what is
    /// wrong where a stage of this name couples it.
    pub(super) fn undetermined_in(&self, stage: &str) -> Option<Wrong> {
        let FluidEffects { imposed, .. } = &self.effects;
        if self.pressure_walls().next().is_some() || self.effects.store() || !imposed.is_empty() {
            return None;
        }
        Some(Wrong::new(
            format!(
                "has no wall with imposed pressure and no storage: pressures in stage \"{stage}\" \
                 are undetermined"
            ),
            "add `pressure = { y_max = 0.0 }` (Pa) for at least one wall, or a `bulk_modulus` (Pa)",
        ))
    }

    /// What is wrong with its conditions in a box, as far as that is known, and among each other.
    pub(super) fn misplaced_in(&self, bounds: Option<&Aabb>) -> Option<Wrong> {
        let outside = |bounds| fluid_conditions::outside(&self.effects, bounds);
        bounds.and_then(outside).or_else(|| fluid_conditions::contradiction(&self.effects))
    }

    /// What has no place in a periodic cell, or none between walls.
    pub(super) fn wrong_around(&self, is_cell: bool) -> Option<Wrong> {
        let (fluid, effects, how) = (&self.fluid, &self.effects, &self.acceleration);
        let drives = "a `pressure_gradient` (Pa/m) drives the flow in a cell";
        let wrong = |what: &str, remedy: &str| Some(Wrong::new(what, remedy));
        if !is_cell {
            let walls = "give two opposite walls a `pressure`, or add [cell]";
            let given = effects.pressure_gradient.is_some();
            return wrong("has a `pressure_gradient`, but there are walls", walls)
                .filter(|_| given);
        }
        let refused = [
            (self.pressure_walls().next().is_some(), "has the `pressure` of a wall", drives),
            (!effects.imposed.is_empty(), "has an `imposed` pressure", drives),
            (!effects.sources.is_empty(), "has `sources`, whose fluid cannot leave", drives),
            (
                effects.conductances != ConductanceRules::default(),
                "has conductances that are not what the geometry says",
                "leave them out, or put walls around",
            ),
            (!fluid.slip_walls, "has `slip_walls`", "leave it out: a cell has no walls"),
            (
                fluid.boundary.sealed_pores == SealedPoreRule::Drained,
                "has `sealed_pores = \"drained\"`: all pores of a cell are",
                "leave it out; a `bulk_modulus` lets pores change their volume",
            ),
            (
                how.update == Update::EveryStep,
                "has `update = \"every step\"`, but spheres are put back into the cell meanwhile",
                "leave it out, and take a smaller `remesh_interval`",
            ),
        ];
        let (_, what, remedy) = refused.into_iter().find(|(given, ..)| *given)?;
        wrong(&format!("stands beside [cell] and {what}"), remedy)
    }

    /// What is wrong with a density where nothing has weight.
    pub(super) fn weightless(&self, gravity: bool) -> Option<Wrong> {
        let useless = self.effects.density.is_some() && !gravity;
        useless.then(|| {
            Wrong::new(
                "has a `density`, but without gravity nothing has weight",
                "add `gravity` to [dem], or leave `density` out",
            )
        })
    }

    /// Effects of this table: `flow` is the fluid where some stage has flow, `conditioned` where one
    /// has it under the conditions of this table, `coupled` where a stage couples it to spheres that
    /// move; in a periodic cell or between walls.
    pub(super) fn effects(
        flow: Option<&Fluid>,
        conditioned: Option<&Fluid>,
        coupled: Option<&Fluid>,
        in_cell: bool,
    ) -> [(&'static Effect, bool); 18] {
        let is = |fluid: Option<&Fluid>, holds: fn(&Fluid) -> bool| fluid.is_some_and(holds);
        let has_factors = |f: &Fluid| {
            let rules = &f.effects.conductances;
            rules.factor.is_some() || !rules.regions.is_empty()
        };
        [
            (&PORE_FLOW, flow.is_some()),
            (&FLUID_FORCES, coupled.is_some()),
            (&WALL_SLIP, is(flow, |f| f.fluid.slip_walls) && !in_cell),
            (&COMPRESSIBILITY, is(conditioned, |f| f.effects.bulk_modulus.is_some())),
            (&BUOYANCY, is(coupled, |f| f.effects.density.is_some())),
            (&SOURCES, is(conditioned, |f| !f.effects.sources.is_empty())),
            (&IMPOSED_REGIONS, is(conditioned, |f| !f.effects.imposed.is_empty())),
            (&PRESSURE_GRADIENT, is(coupled, |f| f.effects.pressure_gradient.is_some())),
            (&IN_TIME, is(conditioned, |f| f.effects.change_in_time())),
            (&PROFILES, is(conditioned, |f| f.effects.wall_profile.values().any(Option::is_some))),
            (&CONDUCTANCE_CLAMP, is(flow, |f| f.fluid.clamp != Clamp::None)),
            (&DARCY, is(flow, |f| f.effects.conductances.darcy_permeability.is_some())),
            (&FACTORS, is(flow, has_factors)),
            (&BLOCKED, is(flow, |f| !f.effects.conductances.blocked.is_empty())),
            (&ONE_WAY, is(coupled, |f| f.effects.one_way)),
            (
                &BACKGROUND_REMESH,
                is(conditioned, |f| f.acceleration.remesh == RemeshMode::Background),
            ),
            (&EVERY_STEP, is(conditioned, |f| f.acceleration.update == Update::EveryStep)),
            (&PARALLEL_TASKS, is(coupled, |f| f.acceleration.parallel_tasks)),
        ]
    }
}
