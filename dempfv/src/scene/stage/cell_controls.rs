//! `velocity_gradient` and `cell_stress` of a run stage: what moves the periodic cell.

use crate::dem::{CellControl, CellControls};
use crate::input::InputError;
use crate::scene::keys::Keys;
use crate::scene::kind::{Kind, Number, inline, number};
use crate::scene::schema::Schema;
use crate::scene::table::Bound;
use crate::scene::wrong::Wrong;

type Result<T> = std::result::Result<T, InputError>;

const COMPONENTS: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];

pub(in crate::scene) static GRADIENT: Schema =
    Schema::by_component("`velocity_gradient`", &COMPONENTS);
pub(in crate::scene) static STRESS: Schema = Schema::by_component("`cell_stress`", &COMPONENTS);

/// What is left of a sum of three rates, over the largest.
const ROUND_OFF: f64 = 1e-14;

const RATE: Number = number("1/s", Bound::Finite);
const PRESSURE: Number = number("Pa", Bound::Finite);

/// The entry of a component.
fn at(component: usize) -> (usize, usize) {
    (component / 3, component % 3)
}

/// Passes over both keys.
pub(super) fn keys(keys: &mut Keys, controls: &mut CellControls) -> Result<()> {
    each(
        keys,
        ("velocity_gradient", &GRADIENT),
        &RATE,
        controls,
        Part {
            of: |control| match control {
                CellControl::Rate(rate) if rate != 0.0 => Some(rate),
                _ => None,
            },
            made: CellControl::Rate,
        },
    )?;
    each(
        keys,
        ("cell_stress", &STRESS),
        &PRESSURE,
        controls,
        Part {
            of: |control| match control {
                CellControl::Stress(stress) => Some(stress),
                CellControl::Rate(_) => None,
            },
            made: CellControl::Stress,
        },
    )?;
    keys.rule("cell_stress", twice(controls))
}

/// One of the two kinds of control.
struct Part {
    /// Its value, where a control is of it and says something.
    of: fn(CellControl) -> Option<f64>,
    made: fn(f64) -> CellControl,
}

fn each(
    keys: &mut Keys,
    (key, schema): (&'static str, &'static Schema),
    kind: &Number,
    controls: &mut CellControls,
    part: Part,
) -> Result<()> {
    let mut written = vec![];
    match keys {
        Keys::Read(table) => {
            let Some(found) = table.get(key) else { return Ok(()) };
            let inner = found.table(schema)?;
            if COMPONENTS.iter().all(|name| inner.get(name).is_none()) {
                let remedy = "name a component, as in { yy = 1.0 }, or leave the key out";
                return Err(found.error("names no component", remedy));
            }
            for (k, name) in COMPONENTS.into_iter().enumerate() {
                let (a, b) = at(k);
                let Some(value) = inner.get(name) else { continue };
                if matches!(controls[a][b], CellControl::Rate(rate) if rate != 0.0) {
                    let problem = "is given, and a velocity gradient too";
                    return Err(value.error(problem, "keep one of the two"));
                }
                controls[a][b] = (part.made)(kind.read(&value)?);
            }
            return Ok(());
        }
        Keys::Check(_) | Keys::Write(_) => {
            for (k, name) in COMPONENTS.into_iter().enumerate() {
                let (a, b) = at(k);
                let Some(value) = (part.of)(controls[a][b]) else { continue };
                match keys {
                    Keys::Check(_) => {
                        let wrong = kind.wrong(&value).map(|w| w.of(&schema.name_of(name)));
                        wrong.map_or(Ok(()), Err)?;
                    }
                    _ => written.extend(kind.write(&value).map(|text| (name, text))),
                }
            }
        }
    }
    if !written.is_empty() {
        keys.push((key, inline(&written)));
    }
    Ok(())
}

/// The first component of a stress that spheres of this modulus (Pa) cannot carry; a tension is
/// none where nothing pulls.
pub(super) fn beyond_reach(controls: &CellControls, young: f64, pulls: bool) -> Option<Wrong> {
    COMPONENTS.into_iter().enumerate().find_map(|(k, name)| {
        let (a, b) = at(k);
        let CellControl::Stress(stress) = controls[a][b] else { return None };
        if stress.abs() > young {
            let problem = format!(
                "asks for `cell_stress` {name} = {stress:e} Pa of spheres whose modulus is {young:e} Pa"
            );
            return Some(Wrong::new(problem, "give a stress below `young` in [particles]"));
        }
        let problem = format!(
            "asks for the tension `cell_stress` {name} = {stress:e} Pa, but nothing holds the spheres together"
        );
        let remedy = "give 0 or more (compression is positive), or add [bonds] or adhesion";
        (a == b && stress < 0.0 && !pulls).then(|| Wrong::new(problem, remedy))
    })
}

/// How a cell would change its volume, which an incompressible fluid cannot follow.
pub(super) fn changes_volume(controls: &CellControls) -> Option<Wrong> {
    let (mut sum, mut size, mut held) = (0.0, 0.0f64, None);
    for (k, row) in controls.iter().enumerate() {
        match row[k] {
            CellControl::Rate(rate) => (sum, size) = (sum + rate, size.max(rate.abs())),
            CellControl::Stress(_) => held = held.or(Some(COMPONENTS[4 * k])),
        }
    }
    let problem = match held {
        Some(name) => {
            format!("asks for `cell_stress` {name}, for which the cell changes its volume")
        }
        None if sum.abs() > ROUND_OFF * size => {
            format!("changes the volume of the cell, by {sum:e} of itself per second")
        }
        None => return None,
    };
    let problem = problem + ", and the fluid is incompressible";
    let remedy = "give xx, yy and zz rates whose sum is 0, or the fluid a `bulk_modulus` (Pa), or the stage \
                  `fluid = false`";
    Some(Wrong::new(problem, remedy))
}

/// A shear stress that is given by both its components.
fn twice(controls: &CellControls) -> Option<Wrong> {
    let held = |a: usize, b: usize| matches!(controls[a][b], CellControl::Stress(_));
    let (a, b) = [(0, 1), (0, 2), (1, 2)].into_iter().find(|&(a, b)| held(a, b) && held(b, a))?;
    let (first, second) = (COMPONENTS[3 * a + b], COMPONENTS[3 * b + a]);
    let problem = format!("has both {first} and {second}, but a stress is symmetric");
    Some(Wrong::new(problem, "give one, and a velocity gradient for the other, or none"))
}
