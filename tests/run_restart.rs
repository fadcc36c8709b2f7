//! `dempfv run` in parts: steps, restarts, interruption, threads.

mod program;

use program::{Folder, STAGES, error, packing, scene};
use serde_json::Value;

fn hash(summary: &Value) -> &str {
    summary["state_hash"].as_str().unwrap()
}

/// N steps, then a restart for the rest, leave the history, the result and the
/// stages' outcomes that one run leaves: cut in every kind of stage, the last
/// time between two stages. The folder of the first part is gone on with as
/// it is: nothing in it is replaced that was not continued.
#[test]
fn parts_make_the_whole() {
    let folder = Folder::new("parts");
    folder.write("scene.toml", &scene(STAGES, "pictures = false"));
    folder.done(&["run", "scene.toml", "--out", "whole"]);
    let whole = folder.json("whole/summary.json");
    assert_eq!(whole["finished"], true);
    let stages: Vec<u64> =
        whole["stages"].as_array().unwrap().iter().map(|s| s["steps"].as_u64().unwrap()).collect();
    let [compact, cycle, 0, consolidate, 150] = stages[..] else { panic!("{stages:?}") };
    let before = compact + cycle;
    let cuts = [303, compact + 207, before + 31, before + consolidate + 77, before];
    for (k, cut) in cuts.into_iter().enumerate() {
        let out = format!("part{k}");
        let n = cut.to_string();
        folder.done(&["run", "scene.toml", "--out", &out, "--steps", &n]);
        let half = folder.json(&format!("{out}/summary.json"));
        assert_eq!((&half["steps"], &half["finished"]), (&cut.into(), &false.into()));
        let checkpoint = format!("{out}/checkpoint.dempfv");
        folder.done(&["run", "scene.toml", "--out", &out, "--restart", &checkpoint]);
        let joined = folder.json(&format!("{out}/summary.json"));
        assert_eq!(hash(&joined), hash(&whole), "cut at {cut}");
        for key in ["stages", "steps", "model_time_s", "remeshes", "finished", "contacts"] {
            assert_eq!(joined[key], whole[key], "{key}, cut at {cut}");
        }
        let (a, b) = (folder.read("whole/history.csv"), folder.read(&format!("{out}/history.csv")));
        let other = a.lines().zip(b.lines()).find(|(a, b)| a != b);
        assert!(a == b, "cut at {cut}: {other:?}");
    }
}

/// The first Ctrl-C ends the run after its step: exit status 130, a summary
/// that says so, and a checkpoint from which the rest gives the bits of a run
/// that nobody interrupted.
#[test]
fn an_interrupted_run_goes_on() {
    let folder = Folder::new("interrupt");
    let stage = r#"
[[stage]]
kind = "run"
steps = 3000
walls = { y_max = { velocity = -1e-4 } }
"#;
    folder.write("scene.toml", &scene(stage, ""));
    folder.interrupt(&["run", "scene.toml", "--out", "cut"], "cut/history.csv");
    let cut = folder.json("cut/summary.json");
    assert_eq!((&cut["interrupted"], &cut["finished"]), (&true.into(), &false.into()));
    folder.done(&["run", "scene.toml", "--out", "cut", "--restart", "cut/checkpoint.dempfv"]);
    folder.done(&["run", "scene.toml", "--out", "whole"]);
    let (joined, whole) = (folder.json("cut/summary.json"), folder.json("whole/summary.json"));
    assert_eq!(hash(&joined), hash(&whole));
    assert!(cut["steps"].as_u64() < whole["steps"].as_u64());
}

/// 5,000 spheres share their work out; `--threads` changes only the time.
#[test]
fn threads_change_no_bit() {
    let folder = Folder::new("threads");
    folder.write(
        "scene.toml",
        &format!(
            r#"
[particles]
packing = "{}"
[dem]
dt = 1e-6
[fluid]
viscosity = 1e-3
remesh_interval = 5
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
steps = 12
walls = {{ y_max = {{ stress = 1e3 }} }}
[output]
pictures = false
"#,
            packing("oedometer-5000.txt")
        ),
    );
    let hashes: Vec<String> = ["1", "2", "2"]
        .into_iter()
        .enumerate()
        .map(|(k, threads)| {
            let out = format!("out{k}");
            folder.done(&["run", "scene.toml", "--out", &out, "--threads", threads]);
            let summary = folder.json(&format!("{out}/summary.json"));
            assert_eq!(summary["threads"].as_u64().unwrap().to_string(), threads);
            hash(&summary).to_owned()
        })
        .collect();
    assert_eq!(hashes[0], hashes[1]);
    assert_eq!(hashes[1], hashes[2]);
}

/// A checkpoint of another scene, or no checkpoint at all, is the user's error.
#[test]
fn a_restart_from_something_else_is_refused() {
    let folder = Folder::new("else");
    folder.write("scene.toml", &scene(STAGES, ""));
    folder.write("no.dempfv", "no checkpoint");
    folder.write("short.toml", &scene("", ""));
    for (checkpoint, scene, what) in [
        ("missing.dempfv", "scene.toml", "no such checkpoint"),
        ("no.dempfv", "scene.toml", "not a checkpoint"),
    ] {
        let before = folder.files();
        let output = folder.dempfv(&["run", scene, "--restart", checkpoint, "--out", "out"]);
        assert_eq!(output.status.code(), Some(2), "{}", error(&output));
        assert!(error(&output).contains(what), "{}", error(&output));
        assert!(folder.files() == before, "{checkpoint}: files were written");
    }
    folder.done(&["run", "scene.toml", "--out", "first", "--steps", "2000"]);
    let output =
        folder.dempfv(&["run", "short.toml", "--restart", "first/checkpoint.dempfv", "--out", "o"]);
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert!(error(&output).contains("the scene has 1"), "{}", error(&output));
    assert!(!folder.0.join("o").exists());
}
