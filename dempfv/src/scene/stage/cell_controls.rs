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

/// A shear stress that is given by both its components.
fn twice(controls: &CellControls) -> Option<Wrong> {
    let held = |a: usize, b: usize| matches!(controls[a][b], CellControl::Stress(_));
    let (a, b) = [(0, 1), (0, 2), (1, 2)].into_iter().find(|&(a, b)| held(a, b) && held(b, a))?;
    let (first, second) = (COMPONENTS[3 * a + b], COMPONENTS[3 * b + a]);
    let problem = format!("has both {first} and {second}, but a stress is symmetric");
    Some(Wrong::new(problem, "give one, and a velocity gradient for the other, or none"))
}
