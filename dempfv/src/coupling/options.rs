//! How the pore network is renewed while the spheres move on.

use crate::{Effect, EffectKey, Family};
use serde::{Deserialize, Serialize};

/// What this effect says of itself.
pub const EVERY_STEP: Effect = Effect {
    name: "network at every step",
    family: Family::Numerics,
    equation: "conductances and volumes follow the spheres; conjugate gradients with the aged factor",
    source: "docs/solver.md",
    keys: &[EffectKey { key: "update in [fluid]", unit: "", default: "\"remesh\"" }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_update.rs",
};

/// What this effect says of itself.
pub const PARALLEL_TASKS: Effect = Effect {
    name: "parallel tasks",
    family: Family::Numerics,
    equation: "the fluid of a step beside its contacts",
    source: "R. Caulk et al.: Comput. Phys. Commun. 248 (2020), section 3",
    keys: &[EffectKey { key: "parallel_tasks in [fluid]", unit: "", default: "false" }],
    needs: "pore flow",
    test: "dempfv/tests/coupling_restart.rs",
};

/// From which positions, and by whom, a network is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RemeshMode {
    /// From the positions of the moment, when a remesh is due; the time loop
    /// waits.
    #[default]
    AtOnce,
    /// From the positions of half an interval (or half the strain) before, when
    /// a remesh is due; the time loop waits. The results are those of
    /// `Background`, bit for bit.
    Ahead,
    /// From these positions too, beside the time loop (Caulk 2020, Algorithm 1):
    /// snapshot at half the interval, swap at its end.
    Background,
}

impl RemeshMode {
    /// Every mode.
    pub const ALL: [RemeshMode; 3] =
        [RemeshMode::AtOnce, RemeshMode::Ahead, RemeshMode::Background];

    /// The mode's name in scenes.
    pub const fn name(self) -> &'static str {
        ["at once", "ahead", "background"][self as usize]
    }
}

/// When a network that was built in the background is taken into use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Swap {
    /// At the end of the interval, waiting for it if need be: the results do
    /// not depend on how fast the machine is.
    #[default]
    WhenDue,
    /// As soon as it is ready, and without waiting for it at the end of the
    /// interval: the results depend on the clock.
    WhenReady,
}

impl Swap {
    /// Every choice.
    pub const ALL: [Swap; 2] = [Swap::WhenDue, Swap::WhenReady];

    /// The choice's name in scenes.
    pub const fn name(self) -> &'static str {
        ["when due", "when ready"][self as usize]
    }
}

/// What happens when a network cannot be built from its snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnFailure {
    /// The run stops with the cause.
    #[default]
    Stop,
    /// The old network stays in use, and the next interval tries again.
    Retry,
}

impl OnFailure {
    /// Every choice.
    pub const ALL: [OnFailure; 2] = [OnFailure::Stop, OnFailure::Retry];

    /// The choice's name in scenes.
    pub const fn name(self) -> &'static str {
        ["stop", "retry"][self as usize]
    }
}

/// What follows the spheres between two remeshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Update {
    /// Nothing: network, operators and factor are those of the last remesh.
    #[default]
    Remesh,
    /// Everything but the triangulation: volumes, conductances and operators
    /// are those of the positions at every step. The solve is iterated with
    /// the factor of the last remesh.
    EveryStep,
}

impl Update {
    /// Every choice.
    pub const ALL: [Update; 2] = [Update::Remesh, Update::EveryStep];

    /// The choice's name in scenes.
    pub const fn name(self) -> &'static str {
        ["remesh", "every step"][self as usize]
    }
}

/// What makes a coupled run faster. The default is the plain time loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acceleration {
    /// From which positions, and by whom, a network is built.
    pub remesh: RemeshMode,
    /// When a network from the background is taken into use.
    pub swap: Swap,
    /// What happens when one cannot be built; with `AtOnce` there is no old
    /// one to go on with, and the run stops.
    pub on_failure: OnFailure,
    /// Whether the remesh interval follows from measured times (eq. 15 of
    /// Caulk 2020); in the background only.
    pub auto_interval: bool,
    /// Whether volumes, solve and fluid forces run beside the contact forces.
    pub parallel_tasks: bool,
    /// What follows the spheres between two remeshes.
    pub update: Update,
}
