//! `dempfv run --restart` with another scene: what its first lines and its summary say.

mod program;

use program::{Folder, error, packing};
use serde_json::Value;

/// A consolidated packing of 1,000 spheres that is squeezed for 60 steps.
fn scene() -> String {
    format!(
        r#"[particles]
packing = "{}"
young = 1.0e6
[dem]
[fluid]
viscosity = 1.0e-3
remesh_interval = 50
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
name = "load"
steps = 60
walls = {{ y_max = {{ stress = 1.1e3 }} }}
[output]
history_every = 10
checkpoint_every = 50
pictures = false
"#,
        packing("oedometer-1000.txt")
    )
}

/// A folder with the scene and a checkpoint of its first 30 steps.
fn begun(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("scene.toml", &scene());
    folder.done(&["run", "scene.toml", "--out", "first", "--steps", "30"]);
    folder
}

const FROM: &str = "first/checkpoint.dempfv";

fn edited(folder: &Folder, edits: &[(&str, &str)]) {
    let mut text = scene();
    for (old, new) in edits {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    folder.write("scene.toml", &text);
}

/// Load, length, viscosity and output are other ones: all are used, each is told on stderr before
/// the first step, on stdout, and in the summary with both values; what is odd is a warning too.
#[test]
fn what_has_changed_is_told() {
    let folder = begun("told");
    edited(
        &folder,
        &[
            ("stress = 1.1e3", "stress = 2.0e3"),
            ("steps = 60", "steps = 45"),
            ("viscosity = 1.0e-3", "viscosity = 2.0e-3"),
            ("history_every = 10", "history_every = 5"),
        ],
    );
    let output = folder.dempfv(&["run", "scene.toml", "--out", "second", "--restart", FROM]);
    assert!(output.status.success(), "{}", error(&output));
    let lines = [
        "restart from first/checkpoint.dempfv at step 30: 4 keys of the scene have changed",
        "`viscosity` in [fluid] is 0.002, was 0.001: used, which is odd in the midst of a run",
        "`history_every` in [output] is 5, was 10: used",
        "`steps` in stage \"load\" is 45, was 60: used",
        "`walls.y_max.stress` in stage \"load\" is 2000.0, was 1100.0: used",
    ];
    let (first, last) = (error(&output), String::from_utf8(output.stdout).unwrap());
    for line in lines {
        assert!(first.contains(line), "stderr lacks {line}:\n{first}");
        assert!(last.contains(line), "stdout lacks {line}:\n{last}");
    }
    assert!(first.starts_with(lines[0]), "{first}");
    let summary = folder.json("second/summary.json");
    assert_eq!(summary["steps"], 45);
    let restart = &summary["restart"];
    assert_eq!((&restart["from"], &restart["step"]), (&FROM.into(), &30.into()));
    let changed = restart["changed"].as_array().unwrap();
    let told: Vec<[&str; 4]> = changed
        .iter()
        .map(|c| ["key", "before", "now", "effect"].map(|key| c[key].as_str().unwrap()))
        .collect();
    assert_eq!(
        told,
        [
            ["fluid.viscosity", "0.001", "0.002", "odd"],
            ["output.history_every", "10", "5", "used"],
            ["stage.load.steps", "60", "45", "used"],
            ["stage.load.walls.y_max.stress", "1100.0", "2000.0", "used"],
        ]
    );
    let warnings = summary["warnings"].as_array().unwrap();
    let viscosity = |w: &&Value| w.as_str().unwrap().contains("`viscosity` in [fluid] is 0.002");
    assert_eq!(warnings.iter().filter(viscosity).count(), 1, "{warnings:?}");
}

/// A restart with the same scene says so; a run that is none has no such key.
#[test]
fn nothing_has_changed() {
    let folder = begun("same");
    assert_eq!(folder.json("first/summary.json")["restart"], Value::Null);
    let output = folder.dempfv(&["run", "scene.toml", "--out", "second", "--restart", FROM]);
    assert!(error(&output).contains("the scene is the one that it was made with"));
    let restart = &folder.json("second/summary.json")["restart"];
    assert_eq!(restart["changed"].as_array().unwrap().len(), 0);
}

/// Packing, box and number of spheres stay: exit status 2, one line with both values, nothing
/// written.
#[test]
fn what_cannot_change_is_refused() {
    let folder = begun("refused");
    folder.write("two.txt", "# box 0 0 0 1 1 1\n.3 .5 .5 .1\n.7 .5 .5 .1\n");
    let name = packing("oedometer-1000.txt");
    let other = packing("lattice-1000.txt");
    let boxed = "[box]\nmin = [-1, -1, -1]\nmax = [2, 2, 2]\n[particles]";
    for (old, new, words) in [
        (name.as_str(), "two.txt", "has 2 spheres, the run began with 1000"),
        (name.as_str(), other.as_str(), "other positions or radii than the 1000 spheres"),
        (
            "[particles]",
            boxed,
            "the box goes from [-1, -1, -1] to [2, 2, 2], it went from [0, 0, 0]",
        ),
    ] {
        edited(&folder, &[(old, new)]);
        let before = folder.files();
        let output = folder.dempfv(&["run", "scene.toml", "--out", "second", "--restart", FROM]);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("scene.toml: no restart with this scene: "), "{message}");
        assert!(message.contains(words) && message.contains("without --restart"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(folder.files() == before, "files were written");
    }
}
