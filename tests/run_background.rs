//! `dempfv run` with networks from the background.

mod program;

use program::{Folder, error, packing, scene};
use serde_json::Value;

const STAGE: &str = r#"
[[stage]]
kind = "run"
steps = 90
walls = { x_min = { velocity = 0.05 }, y_max = { stress = 1.2e4 } }
[[stage]]
kind = "run"
steps = 35
walls = { z_max = { stress = 1.1e4 } }
"#;

/// The test scene with another way to remesh.
fn with_fluid(stages: &str, keys: &str) -> String {
    let text = scene(stages, "pictures = false");
    let usual = "remesh_interval = 40\nremesh_strain = 1e-3";
    assert!(text.contains(usual));
    text.replace(usual, keys)
}

fn remeshed(summary: &Value) -> &Value {
    &summary["remesh"]
}

/// All accelerations together leave the state, the stages and the history of
/// the plain path with the same swap points. The interval is 8, so networks
/// come into use after 8, 16, ... steps, the last after 120; a network that was
/// half an interval old is 12 steps old at its end.
#[test]
fn all_accelerations_leave_the_results_of_the_plain_path() {
    let folder = Folder::new("background");
    let plain = "remesh_interval = 8\nremesh = \"ahead\"";
    let all = "remesh_interval = 8\nremesh = \"background\"\nparallel_tasks = true";
    folder.write("plain.toml", &with_fluid(STAGE, plain));
    folder.write("all.toml", &with_fluid(STAGE, all));
    folder.done(&["run", "plain.toml", "--out", "plain"]);
    let expected = folder.json("plain/summary.json");
    for threads in ["1", "2"] {
        let said = folder.done(&["run", "all.toml", "--out", threads, "--threads", threads]);
        let summary = folder.json(&format!("{threads}/summary.json"));
        for key in ["state_hash", "stages", "remeshes", "largest_residual"] {
            assert_eq!(summary[key], expected[key], "{key}, {threads} threads");
        }
        let history = folder.read(&format!("{threads}/history.csv"));
        assert_eq!(history, folder.read("plain/history.csv"));
        let remesh = remeshed(&summary);
        assert_eq!((&remesh["mode"], &remesh["swap"]), (&"background".into(), &"when due".into()));
        assert_eq!(remesh["largest_age"], 12);
        assert_eq!((&remesh["failures"], &remesh["interval"]), (&0.into(), &8.into()));
        assert!(remesh["waits"].as_u64() <= Some(15));
        assert!(remesh["background_ms"]["factor"].as_f64() > Some(0.0));
        assert!(said.contains("networks: background "), "{said}");
        let effects = summary["effects"].as_array().unwrap();
        for effect in ["background remesh", "parallel tasks"] {
            assert!(effects.contains(&effect.into()), "{effect}");
        }
    }
    assert_eq!(expected["remeshes"], 1 + 124 / 8);
    let ages = (8 + 14 * 12) as f64 / 15.0;
    assert!((remeshed(&expected)["mean_age"].as_f64().unwrap() - ages).abs() < 1e-12);
}

/// Ctrl-C while the background is at work (it always is, with an interval of
/// 1): exit status 130, and the rest gives the bits of the whole.
#[test]
fn an_interrupted_background_goes_on() {
    let folder = Folder::new("background-cut");
    let text = format!(
        r#"
[particles]
packing = "{}"
[dem]
dt = 1e-6
[fluid]
viscosity = 1e-3
remesh_interval = 1
remesh = "background"
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
steps = 60
walls = {{ y_max = {{ velocity = -1e-3 }} }}
[output]
history_every = 1
pictures = false
"#,
        packing("oedometer-1000.txt")
    );
    folder.write("scene.toml", &text);
    folder.interrupt(&["run", "scene.toml", "--out", "cut"], "cut/history.csv");
    folder.done(&["run", "scene.toml", "--out", "cut", "--restart", "cut/checkpoint.dempfv"]);
    folder.done(&["run", "scene.toml", "--out", "whole"]);
    let (joined, whole) = (folder.json("cut/summary.json"), folder.json("whole/summary.json"));
    assert_eq!(joined["state_hash"], whole["state_hash"]);
    assert_eq!(folder.read("cut/history.csv"), folder.read("whole/history.csv"));
}

/// The automatic interval is in the history with what it follows from.
#[test]
fn an_automatic_interval_leaves_its_trail() {
    let folder = Folder::new("background-auto");
    let auto = "remesh_interval = \"auto\"\nremesh = \"background\"";
    let text = with_fluid(STAGE, auto).replace("history_every = 10", "history_every = 1");
    folder.write("scene.toml", &text);
    let output = folder.dempfv(&["run", "scene.toml", "--out", "out"]);
    assert!(output.status.success(), "{}", error(&output));
    let history = folder.read("out/history.csv");
    let mut lines = history.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|c| *c == name).unwrap();
    let stage = column("stage");
    let (interval, background, pace) =
        (column("remesh_interval"), column("background_s"), column("steps_per_s"));
    let mut rows = 0;
    for line in lines {
        let values: Vec<&str> = line.split(',').collect();
        if values[stage] == "compact" {
            continue;
        }
        let [interval, background, pace] =
            [interval, background, pace].map(|c| values[c].parse::<f64>().unwrap());
        let bound = 2.0 * background * pace;
        assert!(bound > 0.0 && interval >= bound, "{interval} steps, {bound} by eq. 15");
        rows += 1;
    }
    assert_eq!(rows, 125);
}
