//! What an effect says of itself. `dempfv check`, the list of effects in a summary and
//! docs/effects.md are written from these descriptions; each stands in the file of its effect.

use serde::Serialize;

/// The part of a simulation that an effect belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// Forces between surfaces.
    Contacts,
    /// What moves and holds spheres beside contacts.
    Bodies,
    /// Walls and cells around the spheres.
    Boundaries,
    /// The fluid in the pores.
    Fluid,
    /// How it is computed: results agree to the tolerance asked for.
    Numerics,
}

/// A key of a scene that switches an effect on or sets a constant of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct EffectKey {
    /// The key with its table, as `young in [particles]`.
    pub key: &'static str,
    /// Its unit; empty for a number without one.
    pub unit: &'static str,
    /// Its default, in words or as a scene has it.
    pub default: &'static str,
}

/// An effect that a scene may call for. It is off unless the scene does, and then costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Effect {
    /// Its name among the effects of a run.
    pub name: &'static str,
    /// What it belongs to.
    pub family: Family,
    /// Its equation, in plain text.
    pub equation: &'static str,
    /// Where the equation is from.
    pub source: &'static str,
    /// The keys of a scene that name it.
    pub keys: &'static [EffectKey],
    /// What it makes necessary; empty where nothing.
    pub needs: &'static str,
    /// The test that holds it against a known answer.
    pub test: &'static str,
}
