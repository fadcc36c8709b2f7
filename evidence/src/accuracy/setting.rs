//! What trades accuracy for time: one setting of one knob.

use std::fmt;

use dempfv::coupling::{EdgeEffects, OnFailure, RemeshMode, RemeshRule, Swap, Update};
use dempfv::pfv::Clamp;
use dempfv::scene::{Accuracy, Fluid, Plan, TimeStep};
use dempfv::solver::SolverKind;
use serde::{Deserialize, Serialize};

/// Steps between networks where nobody says how many.
const DEFAULT_INTERVAL: u64 = 200;
/// Share of the stable step that runs may take which keep to an error.
const SAFETY: f64 = 0.8;

/// An effect that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Omitted {
    Rotation,
    Compressibility,
    FilmsBetweenNeighbours,
    MotionOnFluid,
    FluidWeight,
    WallSlip,
}

/// A change of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Setting {
    /// A network every so many steps.
    Interval(u64),
    /// A network when a pore's volume has changed by this share.
    Strain(f64),
    /// Who builds networks, from which positions.
    Mode(RemeshMode),
    /// What follows the spheres between networks.
    Update(Update),
    /// Linear solver.
    Solver(SolverKind),
    /// What a solve may leave.
    Tolerance(f64),
    /// The same where networks follow each step, by conjugate gradients with an aged factor.
    IteratedTolerance(f64),
    /// Bounds of conductances.
    Clamp(Clamp),
    /// Time step as a share of the largest stable one at the start.
    TimeStep(f64),
    /// An error that the run keeps to by itself.
    Target(f64),
    /// An effect left out.
    Without(Omitted),
}

impl Setting {
    /// The knob that it is a setting of.
    pub fn knob(&self) -> &'static str {
        match self {
            Setting::Interval(_) => "remesh interval",
            Setting::Strain(_) => "remesh strain",
            Setting::Mode(_) => "remesh mode",
            Setting::Update(_) => "update",
            Setting::Solver(_) => "solver",
            Setting::Tolerance(_) => "tolerance",
            Setting::IteratedTolerance(_) => "tolerance, every step",
            Setting::Clamp(_) => "clamp",
            Setting::TimeStep(_) => "time step",
            Setting::Target(_) => "error control",
            Setting::Without(_) => "effects",
        }
    }

    /// Whether it bears on a flow through spheres at rest.
    pub fn is_of_statics(&self) -> bool {
        matches!(
            self,
            Setting::Solver(_)
                | Setting::Tolerance(_)
                | Setting::Clamp(_)
                | Setting::Without(Omitted::WallSlip)
        )
    }

    /// Makes this change to a plan whose measured stage has this index and whose largest stable step
    /// at its start is `limit` (s).
    pub fn apply(&self, plan: &mut Plan, stage: usize, limit: f64) {
        if let Setting::TimeStep(share) = self {
            plan.stages[stage].dt = Some(TimeStep::Fixed(share * limit));
        }
        if let Setting::Target(target) = *self {
            plan.accuracy = Some(Accuracy { target });
            plan.stages[stage].dt = Some(TimeStep::Auto);
            if let Some(dem) = &mut plan.dem {
                dem.safety = SAFETY;
            }
        }
        if let (Setting::Without(Omitted::Rotation), Some(dem)) = (self, &mut plan.dem) {
            dem.options.rotation = false;
        }
        if let Some(fluid) = &mut plan.fluid {
            self.change(fluid);
        }
    }

    fn change(&self, fluid: &mut Fluid) {
        match *self {
            Setting::Interval(steps) => {
                fluid.remesh = RemeshRule { interval: Some(steps), strain: None };
                fluid.acceleration.auto_interval = false;
            }
            Setting::Strain(share) => {
                fluid.remesh = RemeshRule { interval: None, strain: Some(share) };
                fluid.acceleration.auto_interval = false;
            }
            Setting::Mode(mode) => {
                let how = &mut fluid.acceleration;
                how.remesh = mode;
                // What only the background knows of.
                if mode != RemeshMode::Background {
                    how.swap = Swap::WhenDue;
                    if std::mem::take(&mut how.auto_interval) {
                        fluid.remesh.interval.get_or_insert(DEFAULT_INTERVAL);
                    }
                }
                if mode == RemeshMode::AtOnce {
                    how.on_failure = OnFailure::Stop;
                }
            }
            Setting::Update(update) => fluid.acceleration.update = update,
            Setting::Solver(solver) => fluid.solver = solver,
            Setting::Tolerance(tolerance) => fluid.tolerance = tolerance,
            Setting::IteratedTolerance(tolerance) => {
                fluid.acceleration.update = Update::EveryStep;
                fluid.tolerance = tolerance;
            }
            Setting::Clamp(clamp) => fluid.fluid.clamp = clamp,
            Setting::Without(omitted) => match omitted {
                Omitted::Compressibility => fluid.effects.bulk_modulus = None,
                Omitted::FilmsBetweenNeighbours => fluid.effects.edges = EdgeEffects::default(),
                Omitted::MotionOnFluid => fluid.effects.one_way = true,
                Omitted::FluidWeight => fluid.effects.density = None,
                Omitted::WallSlip => fluid.fluid.slip_walls = false,
                Omitted::Rotation => {}
            },
            Setting::Target(_) => {
                fluid.remesh = RemeshRule { interval: Some(DEFAULT_INTERVAL), strain: None };
                fluid.acceleration.auto_interval = false;
                fluid.acceleration.swap = Swap::WhenDue;
            }
            Setting::TimeStep(_) => {}
        }
    }
}

impl fmt::Display for Setting {
    /// As a scene says it, where it does.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Setting::Interval(steps) => write!(f, "remesh_interval = {steps}"),
            Setting::Strain(share) => write!(f, "remesh_strain = {share}"),
            Setting::Mode(mode) => write!(f, "remesh = \"{}\"", mode.name()),
            Setting::Update(update) => write!(f, "update = \"{}\"", update.name()),
            Setting::Solver(solver) => write!(f, "solver = \"{}\"", solver.name()),
            Setting::Tolerance(tolerance) => write!(f, "tolerance = {tolerance:e}"),
            Setting::IteratedTolerance(tolerance) => {
                write!(f, "update = \"every step\", tolerance = {tolerance:e}")
            }
            Setting::Clamp(clamp) => write!(f, "clamp = \"{}\"", clamp.name()),
            Setting::TimeStep(share) => write!(f, "dt = {share} of the stable step"),
            Setting::Target(target) => write!(f, "[accuracy] target = {target}"),
            Setting::Without(omitted) => f.write_str(match omitted {
                Omitted::Rotation => "without rotation",
                Omitted::Compressibility => "without bulk_modulus",
                Omitted::FilmsBetweenNeighbours => "without films between neighbours",
                Omitted::MotionOnFluid => "coupling = \"one-way\"",
                Omitted::FluidWeight => "without density of the fluid",
                Omitted::WallSlip => "slip_walls = false",
            }),
        }
    }
}
