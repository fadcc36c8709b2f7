//! Runs that cannot go on, and results that must not be lost.

mod program;

use std::fs;

use program::{Folder, STAGES, error, scene};

/// Two spheres in contact with a time step a hundred times the stable one.
const BLOWS_UP: &str = r#"
[particles]
packing = "two.txt"
young = 1.0e9
[dem]
dt = 1.0
damping = 0.0
gravity = [0, -9.81, 0]
[[stage]]
kind = "run"
steps = 100000
[output]
history_every = 1
"#;

fn unstable(folder: &Folder, scene: &str) {
    folder.write("two.txt", "# box 0 0 0 1 1 1\n0.3 0.3 0.5 0.21\n0.7 0.32 0.5 0.21\n");
    folder.write("scene.toml", scene);
}

/// A time step far too large ends the run with status 3, and the message names
/// the step and the particle; the history so far, a checkpoint that loads and
/// a summary with the reason are kept.
#[test]
fn a_run_that_blows_up_keeps_what_it_has() {
    let folder = Folder::new("blow");
    unstable(&folder, BLOWS_UP);
    let output = folder.dempfv(&["run", "scene.toml", "--out", "out"]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("step ") && message.contains("particle "), "{message}");
    let summary = folder.json("out/summary.json");
    assert_eq!(summary["finished"], false);
    assert!(message.contains(summary["error"].as_str().unwrap()), "{message}");
    let steps = summary["steps"].as_u64().unwrap();
    assert_eq!(folder.read("out/history.csv").lines().count() as u64, steps + 1);
    // The checkpoint is one to go on from: it fails again at the same place.
    let again = folder.dempfv(&[
        "run",
        "scene.toml",
        "--out",
        "again",
        "--restart",
        "out/checkpoint.dempfv",
    ]);
    assert_eq!(again.status.code(), Some(3));
    let again = error(&again);
    let (restart, failure) = again.split_once('\n').unwrap();
    assert!(restart.starts_with("restart from out/checkpoint.dempfv"), "{restart}");
    assert_eq!(failure, message);
}

/// The same with fluid: the pore or the particle that fails first is named.
#[test]
fn a_coupled_run_that_blows_up_names_the_place() {
    let folder = Folder::new("blow-wet");
    let fluid = "[fluid]\nviscosity = 1.0\npressure = { y_max = 0.0 }\n[[stage]]";
    unstable(&folder, &BLOWS_UP.replacen("[[stage]]", fluid, 1));
    let output = folder.dempfv(&["run", "scene.toml", "--out", "out"]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("step "), "{message}");
    assert!(message.contains("particle ") || message.contains("pore "), "{message}");
    assert!(folder.0.join("out/checkpoint.dempfv").exists());
    assert_eq!(folder.json("out/summary.json")["finished"], false);
}

/// A stage that does not settle in its steps fails like a simulation (3), with
/// its numbers. With more steps allowed the run goes on from there and ends
/// with the bits of one that was allowed them at once.
#[test]
fn a_stage_that_does_not_settle_can_be_given_more_steps() {
    let folder = Folder::new("settle");
    let generous = scene(STAGES, "pictures = false");
    let compact = generous.replacen("stress = 1.0e4", "stress = 1.0e4\nmax_steps = 200", 1);
    let cycle = generous.replacen("cycles = 1", "cycles = 1\nmax_steps = 100", 1);
    folder.write("generous.toml", &generous);
    folder.done(&["run", "generous.toml", "--out", "whole"]);
    for (name, text, what) in [("compact", compact, "1.000000e4 Pa"), ("cycle", cycle, "100 steps")]
    {
        folder.write("scene.toml", &text);
        let output = folder.dempfv(&["run", "scene.toml", "--out", name]);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(3), "{message}");
        assert!(message.contains("step ") && message.contains(what), "{message}");
        let checkpoint = format!("{name}/checkpoint.dempfv");
        folder.done(&["run", "generous.toml", "--out", name, "--restart", &checkpoint]);
        let (a, b) =
            (folder.json(&format!("{name}/summary.json")), folder.json("whole/summary.json"));
        assert_eq!(a["state_hash"], b["state_hash"], "{name}");
        assert_eq!(folder.read(&format!("{name}/history.csv")), folder.read("whole/history.csv"));
    }
}

/// A result stays as it is unless --force is given; then it is replaced.
#[test]
fn results_are_not_overwritten() {
    let folder = Folder::new("force");
    folder.write("scene.toml", &scene("", "pictures = false"));
    folder.done(&["run", "scene.toml", "--out", "out", "--steps", "20"]);
    let before = folder.files();
    let output = folder.dempfv(&["run", "scene.toml", "--out", "out", "--steps", "30"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("--force"), "{}", error(&output));
    assert!(folder.files() == before);
    folder.done(&["run", "scene.toml", "--out", "out", "--steps", "30", "--force"]);
    assert_eq!(folder.json("out/summary.json")["steps"], 30);
    // A finished run is a result too, also for a restart from its own folder.
    folder.done(&["run", "scene.toml", "--out", "done", "--steps", "500"]);
    let checkpoint = "done/checkpoint.dempfv";
    folder.done(&["run", "scene.toml", "--out", "done", "--restart", checkpoint]);
    let before = folder.files();
    let output = folder.dempfv(&["run", "scene.toml", "--out", "done", "--restart", checkpoint]);
    assert_eq!(output.status.code(), Some(2));
    assert!(folder.files() == before);
}

/// Wrong input leaves no trace: no folder where there was none, and a folder
/// with results as it was, even with --force.
#[test]
fn bad_input_leaves_the_output_alone() {
    let folder = Folder::new("alone");
    folder.write("scene.toml", &scene("", "pictures = false"));
    folder.write("typo.toml", &scene("", "picturs = false"));
    folder.write("singular.toml", &scene(STAGES, "").replace("pressure = { y_max = 0.0 }", ""));
    let missing =
        "[particles]\npacking = \"none.txt\"\n[dem]\n[[stage]]\nkind = \"run\"\nsteps = 1\n";
    folder.write("missing.toml", missing);
    folder.done(&["run", "scene.toml", "--out", "out", "--steps", "20"]);
    let before = folder.files();
    for scene in ["typo.toml", "singular.toml", "missing.toml", "absent.toml"] {
        for out in ["out", "new"] {
            let output = folder.dempfv(&["run", scene, "--out", out, "--force"]);
            assert_eq!(output.status.code(), Some(2), "{scene}: {}", error(&output));
            assert!(folder.files() == before, "{scene}: files changed");
        }
        assert!(!folder.0.join("new").exists(), "{scene}");
    }
    fs::write(folder.0.join("file"), "a file").unwrap();
    let output = folder.dempfv(&["run", "scene.toml", "--out", "file"]);
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert_eq!(folder.read("file"), "a file");
}

/// Stage names are free text: none of their characters makes a folder, leaves
/// the output folder or hides a file.
#[test]
fn stage_names_do_not_become_paths() {
    let folder = Folder::new("names");
    let stages: String = ["../../up", "a/b", "..", "nul\u{0000}? *:\"<>|", "é 2, \"x\""]
        .iter()
        .map(|name| {
            let name = name.replace('"', "\\\"").replace('\u{0}', "\\u0000");
            format!("[[stage]]\nkind = \"run\"\nname = \"{name}\"\nsteps = 5\nfluid = false\n")
        })
        .collect();
    folder.write("scene.toml", &scene(&stages, ""));
    folder.done(&["run", "scene.toml", "--out", "deep/out"]);
    let out = folder.0.join("deep/out");
    let mut pictures = 0;
    for path in folder.files().keys().filter(|p| !p.ends_with("scene.toml")) {
        assert_eq!(path.parent(), Some(&*out), "{}", path.display());
        let name = path.file_name().unwrap().to_str().unwrap();
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        assert!(name.chars().all(plain) && !name.starts_with('.'), "{name}");
        pictures += usize::from(name.ends_with(".svg"));
    }
    assert_eq!(pictures, 5, "each stage has its own picture");
    // In the table a name is one cell whatever it has in it.
    let history = folder.read("deep/out/history.csv");
    let columns = history.lines().next().unwrap().split(',').count();
    assert!(history.lines().all(|l| l.split(',').count() == columns));
}
