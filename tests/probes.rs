//! Probes: pore pressures at points, in the history of a run.

mod program;

use program::{Folder, error};

const STAGES: &str =
    "[[stage]]\nkind = \"run\"\nsteps = 100\nwalls = { y_max = { stress = 1.1e4 } }";

/// The last probe sits in the drained pores at the top.
const PROBES: &str = "probes = [[0.5, 0.05, 0.5], [0.5, 0.5, 0.5], [0.5, 0.99, 0.5]]";

/// Rows of a column, as they are written.
fn column(history: &str, name: &str) -> Vec<String> {
    let at = history.lines().next().unwrap().split(',').position(|c| c == name).unwrap();
    history.lines().skip(1).map(|l| l.split(',').nth(at).unwrap().to_owned()).collect()
}

#[test]
fn the_history_has_a_column_for_each_probe() {
    let folder = Folder::new("probes");
    folder.write("scene.toml", &program::scene(STAGES, PROBES));
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let history = folder.read("out/history.csv");
    let number = |cell: &String| cell.parse::<f64>().unwrap();
    let stage = column(&history, "stage");
    let largest: Vec<f64> = column(&history, "largest_pressure_pa").iter().map(number).collect();
    for k in 1..=3 {
        let pressure: Vec<f64> =
            column(&history, &format!("probe_{k}_pressure_pa")).iter().map(number).collect();
        for i in 0..stage.len() {
            // Nothing flows while the packing grows.
            assert_eq!(pressure[i].is_nan(), stage[i] == "compact", "row {i}");
            assert!(pressure[i].is_nan() || pressure[i] <= largest[i]);
        }
        let last = *pressure.last().unwrap();
        assert_eq!(last == 0.0, k == 3, "probe {k}: {last}");
        // The packing is pressed together: pressures are above the drained top's.
        assert!(k == 3 || last > 0.0, "probe {k}: {last}");
    }
}

/// A restarted run finds the pores of the network that it goes on with.
#[test]
fn a_restarted_run_writes_the_same_pressures() {
    let folder = Folder::new("probes-restart");
    folder.write("scene.toml", &program::scene(STAGES, PROBES));
    folder.done(&["run", "scene.toml", "--out", "whole"]);
    let whole = folder.read("whole/history.csv");
    let steps: u64 = column(&whole, "step").last().unwrap().parse().unwrap();
    // 35 steps before the end, between two remeshes.
    let part = (steps - 35).to_string();
    folder.done(&["run", "scene.toml", "--out", "part", "--steps", &part]);
    let from = "part/checkpoint.dempfv";
    folder.done(&["run", "scene.toml", "--out", "part", "--restart", from]);
    assert_eq!(whole, folder.read("part/history.csv"));
}

#[test]
fn a_probe_that_can_show_nothing_is_an_error() {
    let folder = Folder::new("probes-wrong");
    let packing = "# box 0 0 0 1 1 1\n0.5 0.5 0.5 0.4\n";
    folder.write("one.txt", packing);
    let outside = "probes = [[0.5, 0.5, 0.5], [0.5, 1.5, 0.5]]";
    let of_packing = format!(
        "[particles]\npacking = \"one.txt\"\n[fluid]\nviscosity = 1\n[[stage]]\nkind = \"permeability\"\n\
         axis = \"x\"\n[output]\n{outside}\n"
    );
    let dry = program::scene("", PROBES).replace("[fluid]\nviscosity = 10.0\nremesh_interval = 40\nremesh_strain = 1e-3\npressure = { y_max = 0.0 }\n", "");
    let line = |scene: &str| 1 + scene.lines().position(|l| l.starts_with("probes")).unwrap();
    let in_box = program::scene(STAGES, outside);
    let cases = [
        (
            &in_box,
            format!("scene.toml:{}: ", line(&in_box)),
            "has probe 2 at [0.5, 1.5, 0.5], outside the box",
        ),
        (&of_packing, "scene.toml: ".to_owned(), "has probe 2 at [0.5, 1.5, 0.5], outside the box"),
        (&dry, format!("scene.toml:{}: ", line(&dry)), "there is no [fluid]"),
    ];
    for (scene, place, what) in cases {
        folder.write("scene.toml", scene);
        let output = folder.dempfv(&["run", "scene.toml", "--out", "out"]);
        let said = error(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(&place) && said.contains(what), "{said}");
        assert!(!folder.0.join("out").exists());
    }
}
