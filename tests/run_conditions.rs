//! Conditions of the fluid through the program: what is called for and what is not, the flow stage, and
//! regions that fit no pore.

mod program;

use program::{Folder, error, packing};
use serde_json::Value;

fn scene(fluid: &str, rest: &str) -> String {
    format!("[particles]\npacking = \"{}\"\n{fluid}\n{rest}\n", packing("oedometer-1000.txt"))
}

const FLUID: &str =
    "[fluid]\nviscosity = 1e-3\npressure = { y_min = 1.0, y_max = 0.0 }\nsolver = \"cholmod\"";
const FLOW: &str = "[[stage]]\nkind = \"flow\"";
const RUN: &str = "[dem]\n[[stage]]\nkind = \"run\"\nsteps = 3";

fn calls(folder: &Folder, text: &str) -> Value {
    folder.write("scene.toml", text);
    folder.done(&["run", "scene.toml", "--out", "out", "--force"]);
    folder.json("out/summary.json")
}

fn count(summary: &Value, key: &str) -> u64 {
    summary["calls"][key].as_u64().unwrap()
}

/// A scene pays for what it names: a dry one never enters CGAL, CHOLMOD or METIS, one with flow alone
/// builds no neighbour list and finds no contact; a coupled one needs all of them.
#[test]
fn only_what_a_scene_names_is_called() {
    let folder = Folder::new("calls");
    let fluid = ["triangulations", "analyses", "factorizations"];
    let dry = calls(&folder, &scene("", RUN));
    assert!(fluid.iter().all(|key| count(&dry, key) == 0) && count(&dry, "neighbour_lists") > 0);
    // Permeability is measured with and without slip at walls.
    for (stages, flows) in [(FLOW, 1), ("[[stage]]\nkind = \"permeability\"\naxis = \"y\"", 2)] {
        let flow = calls(&folder, &scene(FLUID, stages));
        assert!(fluid.iter().all(|key| count(&flow, key) == flows), "{}", flow["calls"]);
        assert_eq!(count(&flow, "neighbour_lists"), 0, "{stages}");
        assert_eq!(flow["contacts"], 0);
    }
    let coupled = calls(&folder, &scene(FLUID, RUN));
    let all = fluid.into_iter().chain(["neighbour_lists"]);
    assert!(all.into_iter().all(|key| count(&coupled, key) > 0), "{}", coupled["calls"]);
}

/// A flow stage has the flux of a permeability test of the same packing, 1 Pa to 0 Pa; with a ramp in
/// time the pressures of its end, in history.csv too, from one factorization.
#[test]
fn a_flow_stage_follows_its_conditions() {
    let folder = Folder::new("flow-stage");
    let both = format!("{FLOW}\n[[stage]]\nkind = \"permeability\"\naxis = \"y\"");
    let summary = calls(&folder, &scene(FLUID, &both));
    let flux = summary["stages"][0]["flow"]["flux_m3_s"].as_array().unwrap()[2].as_f64().unwrap();
    let measured = summary["stages"][1]["permeability"]["flux_m3_s"].as_f64().unwrap();
    assert!((flux / measured - 1.0).abs() < 1e-12, "{flux} {measured}");

    let ramp = FLUID.replace("y_min = 1.0", "y_min = { ramp = [[0.0, 0.0], [2.0, 8.0]] }");
    let stage = format!("{FLOW}\ntime = 2.0\nsteps = 4\n[output]\nhistory_every = 1");
    let summary = calls(&folder, &scene(&ramp, &stage));
    let last = summary["stages"][0]["flow"]["flux_m3_s"].as_array().unwrap()[2].as_f64().unwrap();
    assert!((last / (8.0 * flux) - 1.0).abs() < 1e-9, "{last} {flux}");
    assert_eq!((count(&summary, "factorizations"), summary["steps"].as_u64()), (1, Some(4)));
    let history = folder.read("out/history.csv");
    let head: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|c| *c == name).unwrap();
    let (time, largest) = (column("time_s"), column("largest_pressure_pa"));
    let rows: Vec<[f64; 2]> = history
        .lines()
        .skip(1)
        .map(|row| row.split(',').collect::<Vec<_>>())
        .map(|row| [time, largest].map(|c| row[c].parse().unwrap()))
        .collect();
    let expected = [[0.5, 2.0], [1.0, 4.0], [1.5, 6.0], [2.0, 8.0]];
    assert!(rows.ends_with(&expected), "{rows:?}");
}

/// Stopped and taken up, a flow stage writes the same history.
#[test]
fn a_flow_stage_restarts() {
    let folder = Folder::new("flow-restart");
    let fluid = format!("{FLUID}\nbulk_modulus = 1e6");
    let stage = format!("{FLOW}\ntime = 1e-5\nsteps = 8\n[output]\nhistory_every = 1");
    folder.write("scene.toml", &scene(&fluid, &stage));
    folder.done(&["run", "scene.toml", "--out", "whole"]);
    folder.done(&["run", "scene.toml", "--out", "part", "--steps", "3"]);
    folder.done(&["run", "scene.toml", "--out", "part", "--restart", "part/checkpoint.dempfv"]);
    assert_eq!(folder.read("whole/history.csv"), folder.read("part/history.csv"));
    let hash = |name: &str| folder.json(name)["state_hash"].clone();
    assert_eq!(hash("whole/summary.json"), hash("part/summary.json"));
}

/// Regions that hold no pore, or pores that have another condition, are told by `check` and `run`
/// with status 2 and one message, before anything is written.
#[test]
fn regions_that_fit_no_pore_are_refused_before_anything_is_written() {
    let folder = Folder::new("misplaced");
    let ball = |x: f64, y: f64, r: f64| format!("center = [{x}, {y}, 0.0114], radius = {r}");
    let middle = ball(0.0114, 0.0114, 0.003);
    for (keys, says) in [
        (
            format!("imposed = [{{ {}, pressure = 1.0 }}]", ball(0.011_1, 0.011_1, 1e-6)),
            "selects no pore",
        ),
        (
            format!("imposed = [{{ {}, pressure = 2.0 }}]", ball(0.0114, 0.0, 0.004)),
            "by the wall y_min",
        ),
        (format!("imposed = [{{ {}, pressure = 2.0 }}]", ball(1.0, 0.0, 0.004)), "outside the box"),
        (format!("sources = [{{ {}, rate = 1.0 }}]", ball(0.0114, 0.0, 0.004)), "imposed pressure"),
        (
            "sources = [{ points = [[0.01, 0.01, 0.01], [9.0, 0.0, 0.0]], rate = 1.0 }]".to_owned(),
            "outside the box",
        ),
        (
            format!("blocked = [{{ {} }}]", ball(0.011_1, 0.011_1, 1e-6)),
            "`blocked` in [fluid], entry 1: selects no pore",
        ),
        (
            format!("imposed = [{{ {middle}, pressure = 2.0 }}, {{ {middle}, pressure = 3.0 }}]"),
            "entry 2 of `imposed` that overlaps entry 1 of `imposed`",
        ),
        (
            format!(
                "imposed = [{{ {middle}, pressure = 2.0 }}]\nsources = [{{ {middle}, rate = 1.0 }}]"
            ),
            "entry 1 of `sources` that overlaps entry 1 of `imposed`",
        ),
    ] {
        for stages in [FLOW, RUN] {
            folder.write("scene.toml", &scene(&format!("{FLUID}\n{keys}"), stages));
            let before = folder.files();
            for command in [&["check", "scene.toml"][..], &["run", "scene.toml", "--out", "out"]] {
                let output = folder.dempfv(command);
                let text = error(&output);
                assert_eq!(output.status.code(), Some(2), "{keys}: {text}");
                assert!(text.contains(says) && text.contains("scene.toml"), "{keys}: {text}");
                assert_eq!(folder.files(), before, "{keys}");
            }
        }
    }
}

/// Every key, written and read again; a pressure along a wall and each function of time on walls, points
/// and regions.
#[test]
fn all_conditions_run_together() {
    let folder = Folder::new("all-conditions");
    let fluid = r#"[fluid]
viscosity = 1e-3
bulk_modulus = 1e6
coupling = "one-way"
conductance_factor = 2.0
conductance_regions = [{ min = [0.0, 0.0, 0.0], max = [0.01, 0.01, 0.01], factor = 0.5 }]
blocked = [{ center = [0.018, 0.011, 0.011], radius = 0.002 }]
imposed = [{ points = [[0.006, 0.006, 0.006]], pressure = { mean = 1.0, amplitude = 0.5, frequency = 10.0 } }]
sources = [{ center = [0.011, 0.016, 0.011], radius = 0.002, rate = { ramp = [[0.0, 0.0], [1e-3, 1e-9]] } }]

[fluid.pressure]
y_min = { along = "x", points = [[0.0, 2.0], [0.02, 1.0]], plus = { ramp = [[0.0, 0.0], [1.0, 5.0]] } }
y_max = 0.0
"#;
    let summary = calls(&folder, &scene(fluid, RUN));
    let effects: Vec<&str> =
        summary["effects"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for name in [
        "conditions in time",
        "pressure profiles",
        "conductance factors",
        "blocked pores",
        "one-way coupling",
        "pressures of regions",
        "fluid sources",
    ] {
        assert!(effects.contains(&name), "{name}: {effects:?}");
    }
}
