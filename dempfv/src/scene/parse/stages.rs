//! The stages of a scene.

use crate::domain::{Axis, WallId};
use crate::input::InputError;
use crate::scene::keys;
use crate::scene::plan::*;
use crate::scene::table::{Bound, Table, Value};

type Result<T> = std::result::Result<T, InputError>;

/// What the scene said before its stages.
struct Before<'a> {
    walls: &'a Walls,
    has_fluid: bool,
}

/// Reads all stages, in order.
pub(super) fn read(root: &Table, walls: &Walls, has_fluid: bool) -> Result<Vec<Stage>> {
    const WANTED: &str = "one or more [[stage]] tables";
    let value = root.need("stage", WANTED)?;
    let items = value.items(WANTED)?;
    if items.is_empty() {
        return Err(value.error("is empty", format!("add {WANTED}")));
    }
    let before = Before { walls, has_fluid };
    let mut stages: Vec<Stage> = Vec::with_capacity(items.len());
    for item in items {
        let (kind, table) = read_kind(&item, &before)?;
        let name = read_name(&table, &kind, &stages)?;
        stages.push(Stage { name, kind });
    }
    Ok(stages)
}

fn read_name(table: &Table, kind: &StageKind, earlier: &[Stage]) -> Result<String> {
    let taken = |name: &str| earlier.iter().any(|s| s.name == name);
    let Some(value) = table.get("name") else {
        let kind = kind.name();
        let mut name = kind.to_owned();
        let mut number = 1;
        while taken(&name) {
            number += 1;
            name = format!("{kind} {number}");
        }
        return Ok(name);
    };
    let name = value.text("the stage's name")?;
    if name.trim().is_empty() || taken(name) {
        return Err(value.error(
            &format!("is \"{name}\", which is empty or the name of an earlier stage"),
            "give every stage a name of its own, or none",
        ));
    }
    Ok(name.to_owned())
}

#[derive(Clone, Copy)]
enum Kind {
    Compact,
    Cycle,
    Permeability,
    Consolidate,
    Run,
}

fn read_kind<'a>(stage: &Value<'a>, before: &Before) -> Result<(StageKind, Table<'a>)> {
    const KINDS: [(&str, Kind); 5] = [
        ("compact", Kind::Compact),
        ("cycle", Kind::Cycle),
        ("permeability", Kind::Permeability),
        ("consolidate", Kind::Consolidate),
        ("run", Kind::Run),
    ];
    let Some(kind) = stage.peek("kind") else {
        let known: Vec<_> = KINDS.iter().map(|(name, _)| *name).collect();
        return Err(stage.source.error(
            stage.at,
            "a [[stage]] has no `kind`",
            format!("add `kind = \"...\"`, one of {}", known.join(", ")),
        ));
    };
    Ok(match kind.choice(&KINDS)? {
        Kind::Compact => {
            let table = stage.table(&keys::COMPACT)?;
            (StageKind::Compact(read_compact(&table)?), table)
        }
        Kind::Cycle => {
            let table = stage.table(&keys::CYCLE)?;
            (StageKind::Cycle(read_cycle(&table, before)?), table)
        }
        Kind::Permeability => {
            let table = stage.table(&keys::PERMEABILITY)?;
            (StageKind::Permeability(Permeability { axis: read_axis(&table)? }), table)
        }
        Kind::Consolidate => {
            let table = stage.table(&keys::CONSOLIDATE)?;
            (StageKind::Consolidate(read_consolidate(&table, before)?), table)
        }
        Kind::Run => {
            let table = stage.table(&keys::RUN)?;
            (StageKind::Run(read_run(&table, before)?), table)
        }
    })
}

const A_WALL: &str = "the wall that moves, as in \"y_max\"";

fn read_axis(table: &Table) -> Result<Axis> {
    table
        .need("axis", "\"x\", \"y\" or \"z\"")?
        .choice(&[Axis::X, Axis::Y, Axis::Z].map(|a| (a.name(), a)))
}

fn read_compact(table: &Table) -> Result<Compact> {
    Ok(Compact {
        stress: table.need_number("stress", "Pa", Bound::Positive)?,
        friction_angle: table.get("friction_angle").map(|v| v.angle()).transpose()?,
        unbalanced: table.number_or("unbalanced", "", Bound::InsideUnit, 1e-3)?,
        tolerance: table.number_or("tolerance", "", Bound::InsideUnit, 1e-3)?,
        max_steps: table.count_or("max_steps", 1, 500_000)?,
    })
}

fn read_cycle(table: &Table, before: &Before) -> Result<Cycle> {
    let from = table.need_number("from", "Pa", Bound::Positive)?;
    let upper = table.need("to", "a number above `from` in Pa")?;
    let to = upper.number("Pa", Bound::Positive)?;
    if to <= from {
        return Err(upper.error(
            &format!("is {to}, not above `from` = {from}"),
            "give a number above `from` in Pa",
        ));
    }
    Ok(Cycle {
        wall: table.need("wall", A_WALL)?.wall()?,
        from,
        to,
        cycles: table.get("cycles").map_or(Ok(2), |v| v.count32(1))?,
        unbalanced: table.number_or("unbalanced", "", Bound::InsideUnit, 1e-3)?,
        tolerance: table.number_or("tolerance", "", Bound::InsideUnit, 1e-3)?,
        max_velocity: read_max_velocity(table, before)?,
        max_steps: table.count_or("max_steps", 1, 500_000)?,
    })
}

fn read_max_velocity(table: &Table, before: &Before) -> Result<f64> {
    table.number_or("max_velocity", "m/s", Bound::Positive, before.walls.max_velocity)
}

fn read_consolidate(table: &Table, before: &Before) -> Result<Consolidate> {
    let until_tv = table.need_number("until_tv", "(dimensionless time)", Bound::Positive)?;
    let mut profiles: Vec<f64> = Vec::new();
    if let Some(value) = table.get("profiles") {
        for item in value.items("an array of T_v, as in [0.1, 0.5]")? {
            let tv = item.number("(dimensionless time)", Bound::Positive)?;
            let last = profiles.last().copied().unwrap_or(0.0);
            if tv <= last || tv > until_tv {
                return Err(item.error(
                    &format!("holds {tv} after {last}"),
                    format!("give T_v in ascending order, up to `until_tv` = {until_tv}"),
                ));
            }
            profiles.push(tv);
        }
    }
    Ok(Consolidate {
        wall: table.need("wall", A_WALL)?.wall()?,
        stress: table.need_number("stress", "Pa", Bound::Positive)?,
        until_tv,
        profiles,
        max_velocity: read_max_velocity(table, before)?,
        max_steps: table.count_or("max_steps", 1, 5_000_000)?,
    })
}

fn read_run(table: &Table, before: &Before) -> Result<Run> {
    let mut walls = [WallControl::Fixed; 6];
    if let Some(value) = table.get("walls") {
        let controls = value.table(&keys::RUN_WALLS)?;
        for wall in WallId::ALL {
            if let Some(control) = controls.get(wall.name()) {
                walls[wall.index()] = read_control(&control, wall, before)?;
            }
        }
    }
    Ok(Run {
        until: read_until(table)?,
        fluid: table.flag_or("fluid", before.has_fluid)?,
        walls,
        friction_angle: table.get("friction_angle").map(|v| v.angle()).transpose()?,
    })
}

fn read_until(table: &Table) -> Result<Until> {
    const ENDS: &str = "give one of `steps = 600`, `time = 0.1` (s), \
                        `until = { strain = 0.2, axis = \"y\" }`";
    match (table.get("steps"), table.get("time"), table.get("until")) {
        (Some(steps), None, None) => Ok(Until::Steps(steps.count(1)?)),
        (None, Some(time), None) => Ok(Until::Time(time.number("s", Bound::Positive)?)),
        (None, None, Some(until)) => read_strain(&until.table(&keys::UNTIL)?),
        (None, None, None) => {
            Err(table.source.error(table.at, "a run stage does not say when it ends", ENDS))
        }
        (steps, time, until) => {
            let last = [steps, time, until].iter().flatten().map(|v| v.at).max();
            let at = last.unwrap_or(table.at);
            Err(table.source.error(at, "a run stage has more than one end", ENDS))
        }
    }
}

fn read_strain(until: &Table) -> Result<Until> {
    let goal = until.need("strain", "logarithmic strain, positive in compression")?;
    let strain = goal.number("", Bound::Finite)?;
    if strain == 0.0 {
        return Err(goal.error("is 0", "give a strain to reach, as in 0.2"));
    }
    Ok(Until::Strain {
        strain,
        axis: read_axis(until)?,
        max_steps: until.count_or("max_steps", 1, 5_000_000)?,
    })
}

fn read_control(value: &Value, wall: WallId, before: &Before) -> Result<WallControl> {
    if value.is_text() {
        return value.choice(&[("fixed", WallControl::Fixed)]);
    }
    if !value.is_table() {
        return Err(value.error(
            "is no wall control",
            "give \"fixed\", { velocity = 0.01 } (m/s) or { stress = 1e3 } (Pa)",
        ));
    }
    let table = value.table(&keys::CONTROL)?;
    match (table.get("stress"), table.get("velocity")) {
        (Some(stress), None) => Ok(WallControl::Stress {
            stress: stress.number("Pa", Bound::NotNegative)?,
            max_velocity: read_max_velocity(&table, before)?,
        }),
        (None, Some(velocity)) => {
            if let Some(limit) = table.get("max_velocity") {
                return Err(limit.error("stands beside `velocity`", "it belongs to `stress`"));
            }
            Ok(WallControl::Velocity { velocity: velocity.number("m/s", Bound::Finite)? })
        }
        (Some(a), Some(b)) => Err(table.source.error(
            a.at.max(b.at),
            format!("{wall} has two conditions: a stress and a velocity"),
            "keep one of the two",
        )),
        (None, None) => Err(value.error(
            "says neither a stress nor a velocity",
            "give \"fixed\", { velocity = 0.01 } (m/s) or { stress = 1e3 } (Pa)",
        )),
    }
}
