//! `[bonds]`: what cements the spheres, and when.

use serde::Serialize;

use super::keys::{Keyed, Keys};
use super::kind::{Maybe, number};
use super::schema::Schema;
use super::stage::{Stage, StageKind, StageName, begins_with};
use super::table::Bound;
use super::wrong::Wrong;
use crate::Effect;
use crate::dem::effects::BONDS;
use crate::dem::law;
use crate::excerpt::Brief;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static SCHEMA: Schema =
    Schema::table("[bonds]", &["tension", "cohesion", "interaction_range", "from"]);

/// Brittle bonds between spheres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bonds {
    /// Their strength and range. Default: none, and spheres that touch; a scene must give the
    /// strengths.
    #[serde(flatten)]
    pub strength: law::Bonds,
    /// Name of the stage that begins with making them. Default: the first.
    pub from: Option<String>,
}

impl Default for Bonds {
    fn default() -> Bonds {
        let strength = law::Bonds { tension: 0.0, cohesion: 0.0, interaction_range: 1.0 };
        Bonds { strength, from: None }
    }
}

/// Tension over the modulus from which on a bond would stretch by a third of a radius.
const MOST_TENSION: f64 = 0.1;

impl Keyed for Bonds {
    fn schema(&self) -> &'static Schema {
        &SCHEMA
    }

    fn keys(&mut self, keys: &mut Keys) -> Result<()> {
        let strength = number("Pa", Bound::NotNegative);
        keys.need_number("tension", strength, &mut self.strength.tension)?;
        keys.need_number("cohesion", strength, &mut self.strength.cohesion)?;
        let range = number("", Bound::InteractionRange);
        keys.take("interaction_range", &range, &mut self.strength.interaction_range)?;
        keys.take("from", &Maybe(StageName), &mut self.from)
    }
}

impl Bonds {
    /// Whether this stage begins with making the bonds.
    pub(crate) fn begin_with(&self, stage: &str, is_first: bool) -> bool {
        begins_with(self.from.as_deref(), stage, is_first)
    }

    /// What is wrong between the bonds, the modulus of the spheres (Pa) and the stages.
    pub(super) fn wrong_in(&self, young: f64, stages: &[Stage]) -> Option<Wrong> {
        if self.strength.tension > MOST_TENSION * young {
            let problem = format!(
                "has a tension of {} Pa for a modulus of {} Pa: a bond would stretch by a third of a radius \
                 before it breaks",
                Brief(self.strength.tension),
                Brief(young)
            );
            return Some(Wrong::new(problem, "give a tenth of `young` in [particles] at most"));
        }
        let begins = |(k, stage): (usize, &Stage)| self.begin_with(&stage.name, k == 0);
        let Some(first) = stages.iter().enumerate().position(begins) else {
            let from = self.from.as_deref().unwrap_or_default();
            let names: Vec<&str> = stages.iter().map(|s| s.name.as_str()).collect();
            let remedy = format!("give one of {}", names.join(", "));
            return Some(Wrong::new(format!("is from \"{from}\", which is no stage"), remedy));
        };
        if !stages[first].kind.moves() {
            let problem = format!("is from \"{}\", in which nothing moves", stages[first].name);
            return Some(Wrong::new(problem, "make the bonds from a stage that moves spheres"));
        }
        let grows = |stage: &&Stage| matches!(stage.kind, StageKind::Compact(_));
        let compact = stages[first..].iter().find(grows)?;
        let problem = format!(
            "would be made before the radii grow in stage \"{}\", against what they hold",
            compact.name
        );
        Some(Wrong::new(problem, "add `from` with the name of a later stage"))
    }

    /// Names of the effects of this table.
    pub(super) fn described(of: Option<&Bonds>, moves: bool) -> [(&'static Effect, bool); 1] {
        [(&BONDS, moves && of.is_some())]
    }
}
