//! docs/outputs.md is what the program says of its results, and results have what it says.
//!
//! `DEMPFV_WRITE_DOCS=1 cargo test --test outputs_page` writes the page anew.

mod program;

use std::collections::BTreeSet;
use std::path::Path;

use dempfv_report::outputs::{frames, page, summary};
use program::{Folder, STAGES, scene};
use serde_json::Value;

#[test]
fn the_page_is_what_results_say_of_themselves() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/outputs.md");
    let page = page();
    if std::env::var_os("DEMPFV_WRITE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        there == page,
        "docs/outputs.md is old; DEMPFV_WRITE_DOCS=1 cargo test --test outputs_page"
    );
}

/// Paths of a value's keys, as the page writes them.
fn paths(value: &Value, at: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(table) => table.iter().for_each(|(key, value)| {
            let path = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            paths(value, &path, found);
        }),
        Value::Array(items) if items.is_empty() => drop(found.insert(format!("{at}[]"))),
        Value::Array(items) => items.iter().for_each(|item| paths(item, &format!("{at}[]"), found)),
        _ => drop(found.insert(at.to_owned())),
    }
}

const CELL: &str = r#"
[cell]
size = [0.1, 0.1, 0.1]
[particles]
cloud = { count = 150, sizes = [[0.006, 0.6], [0.007, 0.4]] }
[dem]
[fluid]
viscosity = 1e-3
[bonds]
tension = 1e4
cohesion = 1e4
from = "run"
[[stage]]
kind = "compact"
stress = 1e4
[[stage]]
kind = "permeability"
axis = "x"
[[stage]]
kind = "run"
steps = 30
velocity_gradient = { xy = 2.0 }
[output]
contacts = true
state = true
"#;

const FLOW: &str = r#"
[box]
min = [0, 0, 0]
max = [1, 1, 1]
[particles]
cloud = { count = 60, radius = 0.05 }
[fluid]
viscosity = 1e-3
pressure = { y_max = 0.0 }
imposed = [{ pressure = 1.0, points = [[0.5, 0.1, 0.5]] }]
[[stage]]
kind = "flow"
"#;

const KEPT: &str = r#"
[box]
min = [0, 0, 0]
max = [1, 1, 1]
[particles]
cloud = { count = 60, radius = 0.05 }
[dem]
[fluid]
viscosity = 1.0
pressure = { y_max = 0.0 }
[accuracy]
target = 0.1
[[stage]]
kind = "run"
steps = 20
walls = { y_min = { velocity = 0.1 } }
"#;

/// A run between walls with the kinds of stages that move spheres, whose networks follow these, one that
/// goes on from a checkpoint with another scene, one in a periodic cell, one that only flows, and one that keeps to an error: every key of their summaries is
/// described, and every key that is described is there, but for what only a GPU has. So it is with the
/// arrays of their snapshots.
#[test]
fn results_have_what_is_described() {
    let folder = Folder::new("outputs");
    let output = "state = true\ncontacts = true\nprobes = [[0.5, 0.5, 0.5]]\n\
                  regions = [{ min = [0, 0, 0], max = [1, 0.5, 1] }]";
    let walls = scene(STAGES, output)
        .replace("remesh_strain = 1e-3", "update = \"every step\"\ndensity = 1000.0")
        .replace("damping = 0.2", "damping = 0.2\ngravity = [0, -9.81, 0]");
    folder.write("walls.toml", &walls);
    folder.write("other.toml", &walls.replace("steps = 150", "steps = 140"));
    folder.write("cell.toml", CELL);
    folder.done(&["run", "walls.toml", "--out", "walls", "--steps", "100"]);
    folder.done(&["run", "other.toml", "--restart", "walls/checkpoint.dempfv", "--out", "other"]);
    folder.done(&["run", "cell.toml", "--out", "cell"]);
    let mut found = BTreeSet::new();
    folder.write("flow.toml", FLOW);
    folder.done(&["run", "flow.toml", "--out", "flow"]);
    folder.write("kept.toml", KEPT);
    folder.done(&["run", "kept.toml", "--out", "kept"]);
    for run in ["walls", "other", "cell", "flow", "kept"] {
        paths(&folder.json(&format!("{run}/summary.json")), "", &mut found);
    }
    let known: Vec<&str> = summary::keys().map(|key| key.name).collect();
    let is = |known: &str, path: &str| match known.strip_suffix('*') {
        Some(table) => path.starts_with(table),
        None => known == path,
    };
    // What is null may stand for a table or an array.
    let leads = |path: &str| {
        known.iter().any(|k| k.strip_prefix(path).is_some_and(|rest| rest.starts_with(['.', '['])))
    };
    let unknown: Vec<_> = found
        .iter()
        .filter(|path| !known.iter().any(|known| is(known, path)) && !leads(path))
        .collect();
    assert!(unknown.is_empty(), "not described: {unknown:?}");
    let missing: Vec<_> = known
        .iter()
        .filter(|known| !known.starts_with("gpu.") && !found.iter().any(|path| is(known, path)))
        .collect();
    assert!(missing.is_empty(), "described, but not there: {missing:?}");

    for file in &frames::FILES {
        let run = if file.name == "cell" { "cell" } else { "other" };
        let name = snapshot(&folder, run, file.name);
        let text = String::from_utf8_lossy(&std::fs::read(name).unwrap()).into_owned();
        let of_grid = ["Points", "connectivity", "offsets", "types"];
        let arrays: BTreeSet<&str> = text
            .split("<DataArray ")
            .skip(1)
            .filter_map(|array| array.split_once("Name=\"")?.1.split('"').next())
            .filter(|name| !of_grid.contains(name))
            .collect();
        assert_eq!(arrays, file.arrays.iter().map(|a| a.name).collect(), "{}", file.name);
    }
}

/// The last snapshot of a kind.
fn snapshot(folder: &Folder, run: &str, kind: &str) -> std::path::PathBuf {
    let entries = std::fs::read_dir(folder.0.join(run)).unwrap().map(|entry| entry.unwrap().path());
    let of_kind = entries.filter(|path| {
        let name = path.file_name().unwrap().to_str().unwrap();
        name.starts_with(&format!("{kind}-")) && name.ends_with(".vtu")
    });
    of_kind.max().unwrap_or_else(|| panic!("no snapshot of {kind}"))
}
