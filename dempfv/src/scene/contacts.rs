//! `[contacts]`: what contacts do beside linear springs and friction.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Maybe, Number, OneOf, number};
use super::schema::Schema;
use super::table::Bound;
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::effects;
use crate::dem::law::{Adhesion, GranularEffects, Hertz, Resistance, Restitution};
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema = Schema::table(
    "[contacts]",
    &[
        "law",
        "poisson_ratio",
        "wall_poisson_ratio",
        "restitution",
        "wall_restitution",
        "rolling_friction",
        "rolling_stiffness_ratio",
        "rolling_damping_ratio",
        "twisting_friction",
        "twisting_stiffness_ratio",
        "twisting_damping_ratio",
        "adhesion",
        "pull_off_force",
        "work_of_adhesion",
    ],
);

/// What contacts do beside linear springs and friction. Default: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Contacts {
    /// The normal force and what goes with it. Default: linear springs.
    pub law: NormalLaw,
    /// Poisson's ratio of the spheres, with Hertz's contact. Default 0.25.
    pub poisson_ratio: Option<f64>,
    /// Poisson's ratio of the walls. Default: the spheres'.
    pub wall_poisson_ratio: Option<f64>,
    /// Coefficient of restitution of two spheres. Default: no viscous damping.
    pub restitution: Option<f64>,
    /// That of a sphere and a wall. Default: the spheres'.
    pub wall_restitution: Option<f64>,
    /// Resistance against rolling. Default: none.
    pub rolling: Turning,
    /// Resistance against twisting. Default: none.
    pub twisting: Turning,
    /// What holds surfaces together that touch. Default: nothing.
    pub adhesion: AdhesionModel,
    /// Force of constant adhesion (N).
    pub pull_off_force: Option<f64>,
    /// Work of adhesion of DMT and JKR (J/m²).
    pub work_of_adhesion: Option<f64>,
}

/// The normal force and what goes with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalLaw {
    /// Linear springs.
    #[default]
    Linear,
    /// Hertz's contact with Mindlin's shear stiffness.
    HertzMindlin,
}

/// What holds surfaces together that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AdhesionModel {
    /// Nothing.
    #[default]
    None,
    /// A constant force.
    Constant,
    /// The theory of Derjaguin, Muller and Toporov.
    Dmt,
    /// The theory of Johnson, Kendall and Roberts.
    Jkr,
}

/// Resistance against one kind of turning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Turning {
    /// The largest moment over the reduced radius and the normal force. Default: no resistance.
    pub friction: Option<f64>,
    /// Stiffness over the normal stiffness. Default 0.5.
    pub stiffness_ratio: Option<f64>,
    /// Damping ratio. Default 0.3.
    pub damping_ratio: Option<f64>,
}

const LAWS: OneOf<'static, NormalLaw> =
    OneOf(&[("linear", NormalLaw::Linear), ("hertz-mindlin", NormalLaw::HertzMindlin)]);
const MODELS: OneOf<'static, AdhesionModel> = OneOf(&[
    ("none", AdhesionModel::None),
    ("constant", AdhesionModel::Constant),
    ("dmt", AdhesionModel::Dmt),
    ("jkr", AdhesionModel::Jkr),
]);
const POISSON_RATIO: Number = number("", Bound::PoissonRatio);
const RESTITUTION: Number = number("", Bound::Restitution);
const POSITIVE: Number = number("", Bound::Positive);
const NOT_NEGATIVE: Number = number("", Bound::NotNegative);

impl Turning {
    fn keys(&mut self, keys: &mut Keys, names: [&'static str; 3]) -> Result<()> {
        let [friction, stiffness_ratio, damping_ratio] = names;
        keys.take(friction, &Maybe(POSITIVE), &mut self.friction)?;
        keys.take(stiffness_ratio, &Maybe(POSITIVE), &mut self.stiffness_ratio)?;
        keys.take(damping_ratio, &Maybe(NOT_NEGATIVE), &mut self.damping_ratio)?;
        for (name, given) in
            [(stiffness_ratio, self.stiffness_ratio), (damping_ratio, self.damping_ratio)]
        {
            keys.rule(name, stray(given.is_some() && self.friction.is_none(), friction))?;
        }
        Ok(())
    }

    fn resistance(&self) -> Option<Resistance> {
        self.friction.map(|friction| Resistance {
            friction,
            stiffness_ratio: self.stiffness_ratio.unwrap_or(0.5),
            damping_ratio: self.damping_ratio.unwrap_or(0.3),
        })
    }
}

/// What is wrong with a key that has no meaning without another.
fn stray(is_stray: bool, without: &str) -> Option<Wrong> {
    let remedy =
        || format!("give that, too, or leave this out: without `{without}` it does nothing");
    is_stray.then(|| Wrong::new(format!("stands without `{without}`"), remedy()))
}

impl Keyed for Contacts {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        keys.take("law", &LAWS, &mut self.law)?;
        keys.take("poisson_ratio", &Maybe(POISSON_RATIO), &mut self.poisson_ratio)?;
        keys.take("wall_poisson_ratio", &Maybe(POISSON_RATIO), &mut self.wall_poisson_ratio)?;
        keys.take("restitution", &Maybe(RESTITUTION), &mut self.restitution)?;
        keys.take("wall_restitution", &Maybe(RESTITUTION), &mut self.wall_restitution)?;
        let rolling = ["rolling_friction", "rolling_stiffness_ratio", "rolling_damping_ratio"];
        self.rolling.keys(keys, rolling)?;
        let twisting = ["twisting_friction", "twisting_stiffness_ratio", "twisting_damping_ratio"];
        self.twisting.keys(keys, twisting)?;
        keys.take("adhesion", &MODELS, &mut self.adhesion)?;
        let force = number("N", Bound::Positive);
        keys.take("pull_off_force", &Maybe(force), &mut self.pull_off_force)?;
        let work = number("J/m²", Bound::Positive);
        keys.take("work_of_adhesion", &Maybe(work), &mut self.work_of_adhesion)?;
        self.rules(keys)
    }
}

impl Contacts {
    /// Keys that have no meaning beside the others, and those that are missing.
    fn rules(&self, keys: &Keys) -> Result<()> {
        let linear = self.law == NormalLaw::Linear;
        let hertz = "law = \"hertz-mindlin\"";
        keys.rule("poisson_ratio", stray(linear && self.poisson_ratio.is_some(), hertz))?;
        keys.rule("wall_poisson_ratio", stray(linear && self.wall_poisson_ratio.is_some(), hertz))?;
        let only_walls = self.wall_restitution.is_some() && self.restitution.is_none();
        keys.rule("wall_restitution", stray(only_walls, "restitution"))?;
        let theory = matches!(self.adhesion, AdhesionModel::Dmt | AdhesionModel::Jkr);
        let constant = self.adhesion == AdhesionModel::Constant;
        keys.rule(
            "adhesion",
            (theory && linear).then(|| {
                let problem = "is a theory of Hertz's contact, and the law is linear";
                Wrong::new(problem, "add `law = \"hertz-mindlin\"`, or take \"constant\"")
            }),
        )?;
        let missing = |key: &str, example: &str| {
            Wrong::new(format!("has no `{key}`"), format!("add it, as in `{key} = {example}`"))
        };
        let (force, work) = (self.pull_off_force, self.work_of_adhesion);
        let no_force = constant && force.is_none();
        keys.rule("adhesion", no_force.then(|| missing("pull_off_force", "1e-3")))?;
        let no_work = theory && work.is_none();
        keys.rule("adhesion", no_work.then(|| missing("work_of_adhesion", "0.1")))?;
        let stray_force = !constant && force.is_some();
        keys.rule("pull_off_force", stray(stray_force, "adhesion = \"constant\""))?;
        let stray_work = !theory && work.is_some();
        keys.rule("work_of_adhesion", stray(stray_work, "adhesion = \"dmt\" or \"jkr\""))
    }

    /// The effects of the contact law; none where it is the linear one.
    pub(super) fn effects(&self) -> GranularEffects {
        let hertz = (self.law == NormalLaw::HertzMindlin).then(|| {
            let poisson_ratio = self.poisson_ratio.unwrap_or(0.25);
            let wall_poisson_ratio = self.wall_poisson_ratio.unwrap_or(poisson_ratio);
            Hertz { poisson_ratio, wall_poisson_ratio }
        });
        let restitution = self.restitution.map(|spheres| Restitution {
            spheres,
            walls: self.wall_restitution.unwrap_or(spheres),
        });
        let adhesion = match self.adhesion {
            AdhesionModel::None => None,
            AdhesionModel::Constant => self.pull_off_force.map(Adhesion::Constant),
            AdhesionModel::Dmt => self.work_of_adhesion.map(Adhesion::Dmt),
            AdhesionModel::Jkr => self.work_of_adhesion.map(Adhesion::Jkr),
        };
        GranularEffects {
            hertz,
            restitution,
            rolling: self.rolling.resistance(),
            twisting: self.twisting.resistance(),
            adhesion,
            bonds: None,
        }
    }

    /// Whether something must turn for an effect to be one.
    pub(super) fn needs_rotation(&self) -> Option<&'static str> {
        match (self.rolling.friction, self.twisting.friction) {
            (Some(_), _) => Some("rolling_friction"),
            (None, Some(_)) => Some("twisting_friction"),
            (None, None) => None,
        }
    }

    /// Names of the effects of this table, where spheres move or not.
    pub(super) fn described(&self, moves: bool) -> [(&'static Effect, bool); 7] {
        let on = |effect: bool| moves && effect;
        [
            (&effects::HERTZ_MINDLIN, on(self.law == NormalLaw::HertzMindlin)),
            (&effects::RESTITUTION, on(self.restitution.is_some())),
            (&effects::ROLLING, on(self.rolling.friction.is_some())),
            (&effects::TWISTING, on(self.twisting.friction.is_some())),
            (&effects::CONSTANT_COHESION, on(self.adhesion == AdhesionModel::Constant)),
            (&effects::DMT, on(self.adhesion == AdhesionModel::Dmt)),
            (&effects::JKR, on(self.adhesion == AdhesionModel::Jkr)),
        ]
    }
}
