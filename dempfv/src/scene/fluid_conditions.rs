//! Keys of `[fluid]` for conditions beside the pressures of walls, and for conductances.

use super::keys::Keys;
use super::kind::{Array, Maybe, number};
use super::region::{
    BlockedRegion, Condition, Conditioned, FactorRegion, IMPOSED, SOURCES, is_outside, overlap,
};
use super::table::Bound;
use super::wrong::Wrong;
use crate::TimeFunction;
use crate::coupling::FluidEffects;
use crate::domain::Aabb;
use crate::input::InputError;
use crate::pfv::terms::PoreSource;
use crate::pfv::{ConductanceRules, ImposedPressure, PoreSelection};

const FORM: &str = "an array of tables, as in [{ center = [0.0, 0.0, 0.0], radius = 0.1, ... }]";

/// Passes over the keys.
pub(super) fn keys(keys: &mut Keys, effects: &mut FluidEffects) -> Result<(), InputError> {
    let FluidEffects { imposed, imposed_in_time, sources, sources_in_time, conductances, .. } =
        effects;
    let given = imposed.iter().map(|i| (&i.pores, i.pressure));
    let mut all = joined(given, imposed_in_time);
    let kind = Array { items: Conditioned { schema: &IMPOSED, unit: "Pa" }, form: FORM };
    keys.take("imposed", &kind, &mut all)?;
    *imposed_in_time = in_time(&all);
    let at_start = |c: Condition| ImposedPressure { pressure: c.value.value(0.0), pores: c.pores };
    *imposed = all.into_iter().map(at_start).collect();

    let given = sources.iter().map(|s| (&s.pores, s.rate));
    let mut all = joined(given, sources_in_time);
    let kind = Array { items: Conditioned { schema: &SOURCES, unit: "m³/s" }, form: FORM };
    keys.take("sources", &kind, &mut all)?;
    *sources_in_time = in_time(&all);
    let at_start = |c: Condition| PoreSource { rate: c.value.value(0.0), pores: c.pores };
    *sources = all.into_iter().map(at_start).collect();

    let ConductanceRules { darcy_permeability, factor, regions, blocked } = conductances;
    keys.take("darcy_permeability", &Maybe(number("m²", Bound::Positive)), darcy_permeability)?;
    keys.take("conductance_factor", &Maybe(number("", Bound::Positive)), factor)?;
    let items = FactorRegion(number("", Bound::Positive));
    keys.take("conductance_regions", &Array { items, form: FORM }, regions)?;
    keys.take("blocked", &Array { items: BlockedRegion, form: FORM }, blocked)
}

/// Conditions at the start, with what they are in time.
fn joined<'e>(
    at_start: impl Iterator<Item = (&'e PoreSelection, f64)>,
    in_time: &[Option<TimeFunction>],
) -> Vec<Condition> {
    let condition = |(k, (pores, value)): (usize, (&PoreSelection, f64))| {
        let changing = in_time.get(k).cloned().flatten();
        Condition { pores: pores.clone(), value: changing.unwrap_or(TimeFunction::Constant(value)) }
    };
    at_start.enumerate().map(condition).collect()
}

/// Those that change with time, by their places; empty where none does.
fn in_time(conditions: &[Condition]) -> Vec<Option<TimeFunction>> {
    let changing = |c: &Condition| {
        Some(c.value.clone()).filter(|value| !matches!(value, TimeFunction::Constant(_)))
    };
    let all: Vec<_> = conditions.iter().map(changing).collect();
    if all.iter().any(Option::is_some) { all } else { vec![] }
}

/// Every selection of pores with the key and the number of its entry.
fn selections(
    effects: &FluidEffects,
) -> impl Iterator<Item = (&'static str, usize, &PoreSelection)> {
    let numbered = |key: &'static str| move |(k, pores)| (key, k, pores);
    let ConductanceRules { regions, blocked, .. } = &effects.conductances;
    let imposed = effects.imposed.iter().map(|i| &i.pores).enumerate().map(numbered("imposed"));
    let sources = effects.sources.iter().map(|s| &s.pores).enumerate().map(numbered("sources"));
    let factors = regions.iter().map(|r| &r.pores).enumerate();
    let blocked = blocked.iter().enumerate().map(numbered("blocked"));
    imposed.chain(sources).chain(factors.map(numbered("conductance_regions"))).chain(blocked)
}

/// What is wrong with regions that would tell one pore two things.
pub(super) fn contradiction(effects: &FluidEffects) -> Option<Wrong> {
    let value = |k: usize| {
        let changing = effects.imposed_in_time.get(k).and_then(Option::as_ref);
        (changing, effects.imposed[k].pressure)
    };
    let told: Vec<_> = selections(effects).collect();
    for (i, (key, k, pores)) in told.iter().enumerate() {
        for (other, l, others) in &told[..i] {
            let apart = match (*other, *key) {
                ("imposed", "imposed") => value(*l) == value(*k),
                ("imposed", "sources") | ("imposed" | "sources", "blocked") => false,
                _ => true,
            };
            if !apart && overlap(pores, others) {
                let problem = format!(
                    "has an entry {} of `{key}` that overlaps entry {} of `{other}`",
                    k + 1,
                    l + 1
                );
                let remedy = "a pore has one condition: move or shrink one of the two";
                return Some(Wrong::new(problem, remedy));
            }
        }
    }
    None
}

/// What is wrong with the first region that has no pore in a box.
pub(super) fn outside(effects: &FluidEffects, bounds: &Aabb) -> Option<Wrong> {
    let (key, k, _) = selections(effects).find(|(_, _, pores)| is_outside(pores, bounds))?;
    let Aabb { min, max } = bounds;
    let problem = format!(
        "has an entry {} of `{key}` outside the box from [{}, {}, {}] to [{}, {}, {}]",
        k + 1,
        min.x,
        min.y,
        min.z,
        max.x,
        max.y,
        max.z
    );
    Some(Wrong::new(problem, "move it into the box"))
}
