//! What a scene asks for, as plain validated data. SI units; angles in radians.

use std::path::PathBuf;

use serde::Serialize;

use crate::coupling::Acceleration;
use crate::domain::{Aabb, Axis, Vec3, WallId};
use crate::pfv::Clamp;
use crate::solver::SolverKind;

/// A validated scene: what is simulated, with which numbers, in which order.
///
/// An absent part (`None`) is an effect that is not simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Title; the scene file's name without its ending when the scene has none.
    pub title: String,
    /// The scene file, if the plan came from one.
    pub file: Option<PathBuf>,
    /// Seed of every random draw. Default 1.
    pub seed: u64,
    /// The box (m). `None`: the packing file's own, else the tight box of its spheres.
    /// Always `Some` when the particles are a cloud.
    pub bounds: Option<Aabb>,
    /// The spheres and their material.
    pub particles: Particles,
    /// The six walls' material.
    pub walls: Walls,
    /// The mechanics; `None`: nothing moves.
    pub dem: Option<Dem>,
    /// The fluid in the pores; `None`: nothing is triangulated.
    pub fluid: Option<Fluid>,
    /// What happens, in order. At least one.
    pub stages: Vec<Stage>,
    /// What is written, and how often.
    pub output: Output,
}

/// The spheres: where they come from and what they are made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Particles {
    /// Where they come from.
    pub source: ParticleSource,
    /// Density ρ (kg/m³). Default 2600.
    pub density: f64,
    /// Young's modulus E of the contact law (Pa). Default 1e6.
    pub young: f64,
    /// Ratio of shear to normal stiffness k_s/k_n (1). Default 0.5.
    pub stiffness_ratio: f64,
    /// Friction angle φ (rad). Default 30°.
    pub friction_angle: f64,
}

/// Where the spheres come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ParticleSource {
    /// A packing file. A relative path in the scene has been joined to the scene's folder.
    Packing(PathBuf),
    /// Random positions in the box, without overlaps.
    Cloud(Cloud),
}

/// A random cloud of spheres without overlaps, drawn with the scene's seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cloud {
    /// Number of spheres, at least 1.
    pub count: u32,
    /// Their radii.
    pub sizes: Sizes,
}

/// Distribution of radii.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sizes {
    /// Uniform in `mean·(1 ± spread)`.
    Uniform {
        /// Mean radius (m). Where the scene gives a porosity, the mean that gives that
        /// porosity in the box.
        mean: f64,
        /// Half width over mean (1), in [0, 1). Default 0: all alike.
        spread: f64,
    },
    /// A few radii with their shares.
    Classes(Vec<SizeClass>),
}

/// One class of a size distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SizeClass {
    /// Radius (m).
    pub radius: f64,
    /// Share of the number of spheres; the shares of all classes add up to 1.
    pub share: f64,
}

impl Sizes {
    /// Expected volume of one sphere (m³).
    pub fn mean_volume(&self) -> f64 {
        let mean_cube = match self {
            // Third moment of the uniform distribution: m³ (1 + s²).
            Sizes::Uniform { mean, spread } => mean.powi(3) * (1.0 + spread * spread),
            Sizes::Classes(classes) => classes.iter().map(|c| c.share * c.radius.powi(3)).sum(),
        };
        4.0 / 3.0 * std::f64::consts::PI * mean_cube
    }

    /// Smallest radius that can be drawn (m).
    pub fn smallest(&self) -> f64 {
        match self {
            Sizes::Uniform { mean, spread } => mean * (1.0 - spread),
            Sizes::Classes(classes) => {
                classes.iter().map(|c| c.radius).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Largest radius that can be drawn (m).
    pub fn largest(&self) -> f64 {
        match self {
            Sizes::Uniform { mean, spread } => mean * (1.0 + spread),
            Sizes::Classes(classes) => classes.iter().map(|c| c.radius).fold(0.0, f64::max),
        }
    }
}

/// Material of the six walls, and how fast the servo may move them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Walls {
    /// Young's modulus of the contact law (Pa). Default: the particles'.
    pub young: f64,
    /// Friction angle of the walls (rad); a contact takes the smaller of its sphere's and
    /// its wall's. Default 0.
    pub friction_angle: f64,
    /// Cut of the speed that a servo asks for (m/s), for the walls of a cube, unless the stage
    /// says another. Default 1.
    pub max_velocity: f64,
}

/// Settings of the mechanics.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dem {
    /// Time step. Default: automatic.
    pub dt: TimeStep,
    /// Share of the contact time step that is safe (1), in (0, 1]. Default 0.8.
    pub safety: f64,
    /// Local damping λ (1), in [0, 1). Default 0.2.
    pub damping: f64,
    /// Gravity (m/s²). `None`: no gravity.
    pub gravity: Option<Vec3>,
    /// Do spheres rotate? Default true.
    pub rotation: bool,
}

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// The smaller of the contact and (with fluid) the viscous time step, times `safety`.
    Auto,
    /// Always this (s).
    Fixed(f64),
}

/// The fluid and how its flow is computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fluid {
    /// Dynamic viscosity μ (Pa·s). Required.
    pub viscosity: f64,
    /// Remesh every so many steps (λ_rm). Default 200 unless `remesh_strain` is given.
    /// `None` too where measured times choose it.
    pub remesh_interval: Option<u64>,
    /// Remesh when a pore has changed its volume by this share since the last remesh (1).
    /// Default: no such rule.
    pub remesh_strain: Option<f64>,
    /// Do the walls without imposed pressure let the fluid slip? Default true.
    pub slip_walls: bool,
    /// Bounds on conductances. Default: none.
    pub clamp: Clamp,
    /// Linear solver. Default: by the number of unknowns.
    pub solver: SolverKind,
    /// What a solve may leave: of the imbalance of fluid mass, and of the estimated error of the
    /// pressures (1). Default 1e-11.
    pub tolerance: f64,
    /// How networks are renewed while the spheres move on. Default: plainly.
    pub acceleration: Acceleration,
    /// Imposed pressure on each wall (Pa), by the wall's index; `None`: no flow through it.
    pub pressure: [Option<f64>; 6],
}

impl Fluid {
    /// Walls with an imposed pressure, in the order of their indices.
    pub fn pressure_walls(&self) -> impl Iterator<Item = (WallId, f64)> + '_ {
        WallId::ALL.into_iter().filter_map(|w| Some((w, self.pressure[w.index()]?)))
    }
}

/// A stage of the simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// Name, unlike any other stage's. Default: the kind, with a number from the second on.
    pub name: String,
    /// What happens.
    pub kind: StageKind,
}

/// What happens in a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StageKind {
    /// Growth of radii to an isotropic stress.
    Compact(Compact),
    /// Dry load and unload cycles that measure the oedometric modulus.
    Cycle(Cycle),
    /// Static flow through the packing at rest.
    Permeability(Permeability),
    /// Coupled one-dimensional consolidation.
    Consolidate(Consolidate),
    /// A number of steps under given wall motions.
    Run(Run),
}

impl StageKind {
    /// The kind's name in scene files.
    pub const fn name(&self) -> &'static str {
        match self {
            StageKind::Compact(_) => "compact",
            StageKind::Cycle(_) => "cycle",
            StageKind::Permeability(_) => "permeability",
            StageKind::Consolidate(_) => "consolidate",
            StageKind::Run(_) => "run",
        }
    }

    /// True when spheres move in this stage.
    pub const fn moves(&self) -> bool {
        !matches!(self, StageKind::Permeability(_))
    }

    /// True when the flow is solved at every step of this stage.
    pub const fn is_coupled(&self) -> bool {
        match self {
            StageKind::Consolidate(_) => true,
            StageKind::Run(run) => run.fluid,
            _ => false,
        }
    }

    /// True when a wall moves with a given velocity in this stage.
    pub fn has_moving_wall(&self) -> bool {
        let moves = |c: &WallControl| matches!(c, WallControl::Velocity { .. });
        matches!(self, StageKind::Run(run) if run.walls.iter().any(moves))
    }

    /// True when a wall is held at a stress in this stage.
    pub fn has_servo(&self) -> bool {
        match self {
            StageKind::Cycle(_) | StageKind::Consolidate(_) => true,
            StageKind::Run(run) => {
                run.walls.iter().any(|c| matches!(c, WallControl::Stress { .. }))
            }
            StageKind::Compact(_) | StageKind::Permeability(_) => false,
        }
    }
}

/// All radii grow in the fixed box until the walls feel an isotropic stress; dry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compact {
    /// Goal: mean stress on the six walls (Pa). Required.
    pub stress: f64,
    /// Friction angle of the particles during this stage (rad). Default: the particles'.
    pub friction_angle: Option<f64>,
    /// Stop at this unbalanced force (1). Default 0.001.
    pub unbalanced: f64,
    /// Stop within this share of the goal (1). Default 0.001.
    pub tolerance: f64,
    /// Give up after so many steps. Default 500,000.
    pub max_steps: u64,
}

/// Dry servo cycles of one wall between two stresses: their secant slope is the
/// oedometric modulus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cycle {
    /// The wall that moves. Required.
    pub wall: WallId,
    /// Lower stress on it (Pa). Required.
    pub from: f64,
    /// Upper stress on it (Pa). Required, above `from`.
    pub to: f64,
    /// Load-unload pairs. Default 2.
    pub cycles: u32,
    /// Each half cycle ends at this unbalanced force (1). Default 0.001.
    pub unbalanced: f64,
    /// and with the stress within this share of its goal (1). Default 0.001.
    pub tolerance: f64,
    /// Cut of the speed that the servo asks for (m/s). Default: that of `[walls]`.
    pub max_velocity: f64,
    /// Give up after so many steps in all. Default 500,000.
    pub max_steps: u64,
}

/// Static flow along one axis through the packing at rest: 1 Pa on the lower wall, 0 on
/// the upper, no flow through the other four.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Permeability {
    /// Axis of the flow. Required.
    pub axis: Axis,
}

/// A stress is put on a wall at once and the packing drains, until a dimensionless time
/// T_v = c_v t / H², with c_v = k E_oed / μ from the modulus and the permeability that
/// the stages before measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Consolidate {
    /// The loaded wall. Required.
    pub wall: WallId,
    /// Stress on it (Pa). Required.
    pub stress: f64,
    /// End of the stage, as T_v (1). Required.
    pub until_tv: f64,
    /// T_v at which pressure profiles are kept, ascending (1). Default: none.
    pub profiles: Vec<f64>,
    /// Cut of the speed that the servo asks for (m/s). Default: that of `[walls]`.
    pub max_velocity: f64,
    /// Give up after so many steps. Default 5,000,000.
    pub max_steps: u64,
}

/// A number of steps under given wall motions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// When the stage ends. Required.
    pub until: Until,
    /// Is the flow solved at every step? Default: true when the scene has `[fluid]`.
    pub fluid: bool,
    /// What each wall does, by its index. Default: fixed.
    pub walls: [WallControl; 6],
    /// Friction angle of the particles during this stage (rad). Default: the particles'.
    pub friction_angle: Option<f64>,
}

/// When a run stage ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Until {
    /// After so many steps.
    Steps(u64),
    /// After so much model time (s).
    Time(f64),
    /// When the box has this strain since the start of the stage.
    Strain {
        /// Logarithmic strain (1), positive in compression, not 0.
        strain: f64,
        /// Axis along which it is taken.
        axis: Axis,
        /// Give up after so many steps. Default 5,000,000.
        max_steps: u64,
    },
}

/// What a wall does during a run stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallControl {
    /// It stands still.
    Fixed,
    /// It moves steadily.
    Velocity {
        /// Velocity along its axis (m/s), positive towards larger coordinates.
        velocity: f64,
    },
    /// The servo holds it at a stress.
    Stress {
        /// Stress (Pa), positive in compression, contacts and fluid together.
        stress: f64,
        /// Cut of the speed that the servo asks for (m/s). Default: that of `[walls]`.
        max_velocity: f64,
    },
}

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Steps between rows of the history. Default 10.
    pub history_every: u64,
    /// Steps between VTK snapshots; 0: none. Default 0.
    pub vtk_every: u64,
    /// Steps between checkpoints; 0: none. Default 0.
    pub checkpoint_every: u64,
    /// Are pictures drawn at the end? Default true.
    pub pictures: bool,
    /// Points whose pore pressure is in the history (m). Default: none.
    pub probes: Vec<Vec3>,
}
