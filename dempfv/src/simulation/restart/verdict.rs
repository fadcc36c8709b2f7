//! What becomes of each key.

use crate::scene::{Difference, ParticleSource, Plan};

/// What becomes of a changed key, and why.
pub(super) enum Verdict {
    /// It holds from here on.
    Used(String),
    /// It holds, though hardly anybody means that.
    Odd(String),
    /// Nothing that is still to come depends on it.
    NoEffect(String),
    /// It cannot hold.
    Refused(String),
}

/// How far a run had come.
pub(in crate::simulation) struct UnderWay<'a> {
    /// Names of the stages that are over.
    pub over: Vec<&'a str>,
    /// Name and kind of the stage that had begun, and its steps.
    pub stage: Option<(&'a str, &'static str, u64)>,
}

impl UnderWay<'_> {
    /// The kind of the stage that had begun.
    fn is_in(&self, kind: &str) -> bool {
        self.stage.is_some_and(|(_, other, _)| other == kind)
    }
}

/// What becomes of a difference.
pub(super) fn verdict(plan: &Plan, difference: &Difference, under_way: &UnderWay) -> Verdict {
    let path: Vec<&str> = difference.path.iter().map(String::as_str).collect();
    match path[..] {
        ["seed"] => seed(plan),
        // Whichever of the two says it, the box itself has been compared.
        ["box", ..] => Verdict::NoEffect("the box is the same".to_owned()),
        ["cell", ..] => Verdict::Refused("a restart goes on with the cell that it has".to_owned()),
        ["particles", ref keys @ ..] => particles(plan, keys),
        ["walls", "max_velocity"] => used("by stages that give none of their own"),
        ["walls", ..] => Verdict::Odd(MEASURED.to_owned()),
        ["contacts", ref keys @ ..] => contacts(keys, difference),
        ["bonds", ref keys @ ..] => bonds(keys, difference),
        ["material" | "pair", ..] => Verdict::Refused(
            "a restart goes on with the materials that the run began with".to_owned(),
        ),
        ["motion", ..] => {
            Verdict::Refused("spheres go on with the motions that the run began with".to_owned())
        }
        ["dem", "gravity" | "rotation"] | ["fluid"] | ["dem"] => Verdict::Odd(String::new()),
        ["dem", "dt" | "damping"] => used("by stages that give none of their own"),
        ["fluid", ref keys @ ..] => fluid(keys, under_way),
        ["stage"] => used("of those to come"),
        ["stage", name] => whole_stage(name, difference, under_way),
        ["stage", name, ref keys @ ..] => key_of_stage(name, keys, difference, under_way),
        _ => used(""),
    }
}

/// What finished stages have found out stays.
const MEASURED: &str = "forces jump, and what finished stages measured is of the value before";

fn used(note: &str) -> Verdict {
    Verdict::Used(note.to_owned())
}

fn seed(plan: &Plan) -> Verdict {
    match plan.particles.source {
        ParticleSource::Cloud(_) => Verdict::Refused("it draws other spheres".to_owned()),
        ParticleSource::Packing(_) => Verdict::NoEffect("nothing is drawn".to_owned()),
    }
}

fn particles(plan: &Plan, keys: &[&str]) -> Verdict {
    match (keys, &plan.particles.source) {
        (["packing", ..], ParticleSource::Packing(_)) => used("its spheres are the same"),
        (["packing" | "cloud" | "clump", ..], _) => {
            Verdict::Refused("a restart goes on with the spheres that it has".to_owned())
        }
        (["density"], _) => Verdict::Odd("masses change, velocities stay".to_owned()),
        _ => Verdict::Odd(MEASURED.to_owned()),
    }
}

/// Contacts remember what their law has left there: only its constants may change.
fn contacts(keys: &[&str], difference: &Difference) -> Verdict {
    let is_constant = difference.before.is_some() && difference.now.is_some();
    match keys {
        [key] if is_constant && !["law", "adhesion"].contains(key) => {
            Verdict::Odd(MEASURED.to_owned())
        }
        _ => Verdict::Refused(
            "what contacts remember is of the law that the run began with".to_owned(),
        ),
    }
}

fn bonds(keys: &[&str], difference: &Difference) -> Verdict {
    match keys {
        ["tension" | "cohesion"] => Verdict::Odd(MEASURED.to_owned()),
        ["from" | "interaction_range"] => used("where the bonds are not made yet"),
        _ => contacts(keys, difference),
    }
}

fn fluid(keys: &[&str], under_way: &UnderWay) -> Verdict {
    let consolidates = under_way.is_in("consolidate");
    match keys {
        ["pressure", ..] if consolidates => Verdict::Refused(
            "the consolidation under way is reckoned from the walls that drain and their pressure"
                .to_owned(),
        ),
        ["viscosity"] if consolidates => Verdict::Odd(
            "pressures jump, and T_v of the stage under way goes on by the value before".to_owned(),
        ),
        ["viscosity" | "bulk_modulus" | "slip_walls" | "clamp" | "coupling"] => {
            Verdict::Odd("pressures jump".to_owned())
        }
        ["darcy_permeability" | "conductance_factor" | "conductance_regions" | "blocked", ..] => {
            Verdict::Odd("pressures jump".to_owned())
        }
        _ => used(""),
    }
}

fn whole_stage(name: &str, difference: &Difference, under_way: &UnderWay) -> Verdict {
    match (&difference.now, under_way.over.contains(&name)) {
        (_, true) => Verdict::NoEffect("the stage is over".to_owned()),
        (Some(_), _) => used("a stage to come"),
        (None, _) => used("the stage is left out"),
    }
}

fn key_of_stage(
    name: &str,
    keys: &[&str],
    difference: &Difference,
    under_way: &UnderWay,
) -> Verdict {
    if under_way.over.contains(&name) {
        return Verdict::NoEffect("the stage is over".to_owned());
    }
    let Some((_, kind, steps)) = under_way.stage.filter(|(stage, _, _)| *stage == name) else {
        return used("when the stage comes");
    };
    match (kind, keys) {
        ("consolidate", ["wall" | "stress"]) => Verdict::Refused(
            "degree and T_v of the consolidation under way are those of the load that it began with; \
             let it end, and put another stage behind it"
                .to_owned(),
        ),
        ("consolidate", ["profiles"]) => used("but for T_v that have gone by"),
        ("cycle", ["wall"]) => Verdict::Refused(
            "the cycles under way measure the modulus along its axis; let them end, and put another \
             stage behind them"
                .to_owned(),
        ),
        ("run", ["steps"]) => match difference.now.as_ref().and_then(|n| n.parse::<u64>().ok()) {
            Some(now) if now <= steps => {
                Verdict::Used(format!("the stage has done {steps} already and ends at once"))
            }
            _ => used("counted from the start of the stage"),
        },
        ("run", ["time" | "until", ..]) => used("counted from the start of the stage"),
        _ => used(""),
    }
}
