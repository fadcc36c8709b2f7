//! What YADE computed for two small loadings, and what our program makes of them.
//!
//! The references name the version of YADE; `dempfv compare yade --write-reference
//! evidence/tests/reference` writes them anew. Each holds two courses: YADE as it is, and YADE
//! with its two known deviations taken out (the factor on the slip of contacts, the push
//! of corner pores that it leaves out).

mod program;

use std::path::Path;

use program::Folder;
use serde_json::Value;

const WALLS: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];

/// Largest differences from a course of YADE's.
#[derive(Debug)]
struct Gap {
    /// Stress on any wall, of the load.
    stress: f64,
    /// Displacement of the loaded wall, of the last one.
    displacement: f64,
    /// Pressure at any probe, of the load.
    pressure: f64,
    /// Contacts.
    contacts: f64,
}

fn reference(name: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("evidence/tests/reference");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Carries out the reference's scene; returns its history, column by column.
fn ours(name: &str, reference: &Value) -> impl Fn(&str, u64) -> f64 {
    let folder = Folder::new(name);
    let packing =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("evidence/tests/reference/loading-200.txt");
    std::fs::copy(packing, folder.0.join("loading-200.txt")).unwrap();
    folder.write("scene.toml", reference["scene"].as_str().unwrap());
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let text = folder.read("out/history.csv");
    let mut lines = text.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    let columns = lines.next().unwrap();
    let rows: Vec<Vec<String>> = lines.collect();
    move |column, step| {
        let at = |name: &str| columns.iter().position(|c| c == name).unwrap();
        let row = rows.iter().find(|r| r[at("step")] == step.to_string()).unwrap();
        row[at(column)].parse().unwrap()
    }
}

/// How far we are from a course of YADE's, up to a step.
fn gap(ours: &impl Fn(&str, u64) -> f64, reference: &Value, course: &str, last: u64) -> Gap {
    let (load, yade) = (reference["load"].as_f64().unwrap(), &reference[course]);
    let steps = yade["step"].as_array().unwrap();
    let number = |v: &Value| v.as_f64().unwrap();
    let end = number(yade["displacement"].as_array().unwrap().last().unwrap());
    let mut gap = Gap { stress: 0.0, displacement: 0.0, pressure: 0.0, contacts: 0.0 };
    let widen = |largest: &mut f64, difference: f64| *largest = largest.max(difference.abs());
    let steps = steps.iter().map(|s| s.as_u64().unwrap()).take_while(|s| *s <= last);
    for (i, step) in steps.enumerate() {
        for (w, wall) in WALLS.iter().enumerate() {
            let stress = ours(&format!("contact_stress_{wall}_pa"), step)
                + ours(&format!("fluid_stress_{wall}_pa"), step);
            widen(&mut gap.stress, (stress - number(&yade["stress"][i][w])) / load);
        }
        let moved = ours("wall_displacement_y_max_m", step);
        widen(&mut gap.displacement, (moved - number(&yade["displacement"][i])) / end);
        for (k, pressure) in yade["pressure"][i].as_array().unwrap().iter().enumerate() {
            let here = ours(&format!("probe_{}_pressure_pa", k + 1), step);
            widen(&mut gap.pressure, (here - number(pressure)) / load);
        }
        widen(&mut gap.contacts, ours("contacts", step) - number(&yade["contacts"][i]));
    }
    gap
}

impl Gap {
    fn is_within(&self, [stress, displacement, pressure, contacts]: [f64; 4]) -> bool {
        self.stress < stress
            && self.displacement < displacement
            && self.pressure < pressure
            && self.contacts <= contacts
    }
}

/// Found when the reference was made: 5e-5, 2e-7 and the same contacts where the equations
/// are the same, growing round-off; 7e-3 and one contact beside YADE as it is.
#[test]
fn a_dry_loading_is_that_of_yade() {
    let reference = reference("yade-dry.json");
    let ours = ours("yade-dry", &reference);
    let aligned = gap(&ours, &reference, "aligned", u64::MAX);
    assert!(aligned.is_within([2e-4, 1e-5, 1e-9, 0.0]), "{aligned:?}");
    let plain = gap(&ours, &reference, "plain", u64::MAX);
    assert!(plain.is_within([1e-2, 5e-3, 1e-9, 2.0]), "{plain:?}");
}

/// Found when the reference was made: 1e-4 on the first network, as the spheres move on
/// from where E was made; 2e-3 in all, just after the remeshes, for which YADE takes the
/// positions of one step earlier. YADE as it is lacks the push of the corner pores, which
/// is 9 % of the load on the base of this small packing.
#[test]
fn a_coupled_loading_is_that_of_yade() {
    let reference = reference("yade-coupled.json");
    let ours = ours("yade-coupled", &reference);
    let first = gap(&ours, &reference, "aligned", 50);
    assert!(first.is_within([3e-4, 1e-5, 3e-4, 0.0]), "{first:?}");
    let aligned = gap(&ours, &reference, "aligned", u64::MAX);
    assert!(aligned.is_within([5e-3, 1e-3, 5e-3, 0.0]), "{aligned:?}");
    let plain = gap(&ours, &reference, "plain", u64::MAX);
    assert!(plain.is_within([0.15, 5e-3, 3e-2, 4.0]), "{plain:?}");
}
