//! Whether a packing has the spheres that motions choose, and the fluid's conditions fit the pores that
//! they are first meant for.

use crate::pfv::PfvError;
use crate::scene::{Plan, Stage};
use crate::{Aabb, Result, Vec3};

/// Refuses, before a run has written anything, motions of spheres that are not there, and regions that
/// select no pore, or pores that something else holds already, in the network of spheres at these
/// places (m). Where spheres move before the motion or the fluid comes, nobody knows yet.
///
/// # Errors
/// What contradicts what; why there is no network.
pub fn check_conditions(
    plan: &Plan,
    position: &[Vec3],
    radius: &[f64],
    bounds: Aabb,
) -> Result<()> {
    check_motions(plan, position, radius)?;
    let first = plan.stages.iter().find(|stage| stage.kind.moves() || stage.kind.has_conditions());
    let meant_for = first.filter(|stage| stage.kind.has_conditions());
    let Some((fluid, stage)) = plan.fluid.as_ref().zip(meant_for) else { return Ok(()) };
    // Under the stage's own pressures, if it has some.
    let fluid = stage.kind.fluid(fluid, 0.0);
    let effects = &fluid.effects;
    let conditions = effects.conditions();
    let rules = &conditions.conductances;
    let regions = [effects.sources.len(), effects.imposed.len(), rules.regions.len()];
    if regions.iter().sum::<usize>() + rules.blocked.len() == 0 {
        return Ok(());
    }
    let checked = conditions.check(position, radius, bounds, &fluid.fluid, &effects.sources);
    checked.map_err(|error| {
        let PfvError::InvalidInput { argument, index: Some(k), problem } = &error else {
            return error.into();
        };
        let Some(key) = key(argument) else { return error.into() };
        let (problem, remedy) =
            problem.split_once("; ").unwrap_or((problem, "choose other pores, or a larger region"));
        plan.error(format!("`{key}` in [fluid], entry {}: {problem}", k + 1), remedy).into()
    })
}

/// No stage changes how many spheres there are.
fn check_motions(plan: &Plan, position: &[Vec3], radius: &[f64]) -> Result<()> {
    for (place, given) in plan.motions.iter().enumerate() {
        let (motion, spheres) = (place + 1, position.len());
        let mut numbers = given.which.numbers.iter().flatten();
        if let Some(number) = numbers.find(|number| **number as usize >= spheres) {
            let what = format!("`numbers` in [[motion]] {motion} have {number}");
            let remedy = format!("there are {spheres} spheres, and their numbers begin at 0");
            return Err(plan.error(what, remedy).into());
        }
        let begins = |(i, stage): (usize, &Stage)| given.begin_with(&stage.name, i == 0);
        let begins = plan.stages.iter().enumerate().position(begins).unwrap_or(0);
        let known = !plan.stages[..begins].iter().any(|stage| stage.kind.moves());
        if known && given.which.chosen(position, radius).is_empty() {
            let stage = plan.stages.get(begins).map_or("", |stage| &stage.name);
            let what = format!("[[motion]] {motion} has no sphere when stage \"{stage}\" begins");
            return Err(plan.error(what, "give a region with the centre of a sphere in it").into());
        }
    }
    Ok(())
}

/// The key of a scene whose entries an argument has.
fn key(argument: &str) -> Option<&'static str> {
    match argument {
        "imposed pressure" => Some("imposed"),
        "sources" => Some("sources"),
        "conductance regions" => Some("conductance_regions"),
        "blocked pores" => Some("blocked"),
        _ => None,
    }
}
