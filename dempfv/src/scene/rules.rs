//! What must hold between the parts of a scene.

use super::plan::*;
use super::table::Table;
use crate::domain::{Axis, WallId};
use crate::input::InputError;

type Result = std::result::Result<(), InputError>;

/// Checks the parts of a plan against each other; `root` tells where they stand.
pub(super) fn check(plan: &Plan, root: &Table) -> Result {
    let stages = match root.get("stage") {
        Some(value) => value.items("")?,
        None => Vec::new(),
    };
    for (i, value) in stages.iter().enumerate() {
        check_stage(plan, i).map_err(|(what, remedy)| root.source.error(value.at, what, remedy))?;
    }
    check_pressure(plan, root)
}

/// What is wrong, and what would be right.
type Fault = (String, String);

fn check_stage(plan: &Plan, i: usize) -> std::result::Result<(), Fault> {
    let stage = &plan.stages[i];
    let kind = &stage.kind;
    let fault = |problem: &str, remedy: &str| {
        Err((format!("stage \"{}\" {problem}", stage.name), remedy.to_owned()))
    };
    if kind.moves() && plan.dem.is_none() {
        return fault("moves spheres, but there is no [dem]", "add [dem] (it may be empty)");
    }
    let needs_fluid = kind.is_coupled() || matches!(kind, StageKind::Permeability(_));
    if needs_fluid && plan.fluid.is_none() {
        return fault(
            "needs a fluid, but there is no [fluid]",
            "add [fluid] with `viscosity` in Pa·s",
        );
    }
    match kind {
        StageKind::Consolidate(stage) => check_consolidate(plan, i, stage),
        StageKind::Run(run) => check_run(run).or_else(|(problem, remedy)| fault(&problem, remedy)),
        _ => Ok(()),
    }
}

/// A strain must be within reach of the walls.
fn check_run(run: &Run) -> std::result::Result<(), (String, &'static str)> {
    let Until::Strain { axis, strain, .. } = run.until else { return Ok(()) };
    let mut shortening = 0.0;
    for wall in WallId::ALL.into_iter().filter(|w| Axis::of(*w) == axis) {
        match run.walls[wall.index()] {
            WallControl::Fixed => {}
            WallControl::Velocity { velocity } => shortening += velocity * wall.inward(),
            // The servo goes where the stress leads it.
            WallControl::Stress { .. } => return Ok(()),
        }
    }
    let axis = axis.name();
    if shortening == 0.0 {
        return Err((
            format!("waits for a strain along {axis}, but the walls there do not move"),
            "give one of them a velocity or a stress",
        ));
    }
    if shortening * strain < 0.0 {
        return Err((
            format!(
                "waits for a strain of {strain} along {axis}, but the walls move the other way"
            ),
            "strain is positive in compression, velocity towards larger coordinates",
        ));
    }
    Ok(())
}

/// Consolidation needs a measured c_v, and drains along its own axis only: Terzaghi's
/// theory, by which T_v is defined, is one-dimensional.
fn check_consolidate(plan: &Plan, i: usize, stage: &Consolidate) -> std::result::Result<(), Fault> {
    let axis = Axis::of(stage.wall);
    let name = &plan.stages[i].name;
    let before = &plan.stages[..i];
    let modulus =
        before.iter().any(|s| matches!(&s.kind, StageKind::Cycle(c) if Axis::of(c.wall) == axis));
    let permeability =
        before.iter().any(|s| matches!(&s.kind, StageKind::Permeability(p) if p.axis == axis));
    let missing = match (modulus, permeability) {
        (true, true) => None,
        (false, _) => Some(("oedometric modulus", "cycle", format!("wall = \"{}\"", stage.wall))),
        (true, false) => {
            Some(("permeability", "permeability", format!("axis = \"{}\"", axis.name())))
        }
    };
    if let Some((what, kind, key)) = missing {
        return Err((
            format!(
                "stage \"{name}\" needs the {what} along {}, which no stage before it measures",
                axis.name()
            ),
            format!("put a [[stage]] with kind = \"{kind}\" and {key} before it"),
        ));
    }
    let Some(fluid) = &plan.fluid else { return Ok(()) };
    let remedy = format!("impose a pressure on {} or {} only", stage.wall, stage.wall.opposite());
    if let Some((side, _)) = fluid.pressure_walls().find(|(w, _)| Axis::of(*w) != axis) {
        return Err((
            format!(
                "stage \"{name}\" consolidates along {}, but {side} drains across it",
                axis.name()
            ),
            remedy,
        ));
    }
    let both = [stage.wall, stage.wall.opposite()].map(|w| fluid.pressure[w.index()]);
    match both {
        [Some(_), Some(_)] => Err((
            format!(
                "stage \"{name}\" drains at both ends of {}; its theory knows one",
                axis.name()
            ),
            remedy,
        )),
        _ => Ok(()),
    }
}

/// An incompressible fluid whose pressure is imposed nowhere has a singular system.
fn check_pressure(plan: &Plan, root: &Table) -> Result {
    let coupled = plan.stages.iter().find(|s| s.kind.is_coupled());
    let (Some(fluid), Some(value), Some(stage)) = (&plan.fluid, root.get("fluid"), coupled) else {
        return Ok(());
    };
    if fluid.pressure_walls().next().is_some() {
        return Ok(());
    }
    Err(value.error(
        &format!(
            "has no wall with imposed pressure and no storage: pressures in stage \"{}\" are undetermined",
            stage.name
        ),
        "add `pressure = { y_max = 0.0 }` (Pa) for at least one wall",
    ))
}
