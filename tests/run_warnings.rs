//! What a run says of itself, and of the machine, before and after.

mod program;

#[cfg(target_os = "linux")]
use std::process::{Command, Output};

#[cfg(target_os = "linux")]
use program::{Folder, error, scene};

const STAGE: &str = "
[[stage]]
kind = \"run\"
steps = 20
";

/// A tolerance that no solve meets is told in the summary, with the first step and the worst
/// value: 1e-17 is less than the round-off of doubles, so that nearly every
/// coupled step counts.
#[test]
fn an_unmet_tolerance_is_told() {
    let folder = Folder::new("unmet");
    let strict =
        scene(STAGE, "pictures = false").replacen("[fluid]", "[fluid]\ntolerance = 1e-17", 1);
    folder.write("scene.toml", &strict);
    let said = folder.done(&["run", "scene.toml", "--out", "out"]);
    let summary = folder.json("out/summary.json");
    let warnings = summary["warnings"].as_array().unwrap();
    let unmet = warnings.iter().filter_map(|w| w.as_str()).find(|w| w.contains("tolerance"));
    let unmet = unmet.unwrap_or_else(|| panic!("{warnings:?}"));
    let solves: u32 = unmet.split(' ').next().unwrap().parse().unwrap();
    assert!((15..=20).contains(&solves) && unmet.contains("the first at step"), "{unmet}");
    assert!(said.contains(unmet), "{said}");
    folder.write("scene.toml", &strict.replacen("1e-17", "1e-6", 1));
    folder.done(&["run", "scene.toml", "--out", "met"]);
    assert_eq!(folder.json("met/summary.json")["warnings"].as_array().map(Vec::len), Some(0));
}

/// A cloud that no machine has room for is refused in words, before any of it is made.
#[test]
fn a_run_that_cannot_fit_is_refused() {
    let folder = Folder::new("fit");
    folder.write("scene.toml", &scene(STAGE, "").replacen("count = 120", "count = 4000000000", 1));
    let output = folder.dempfv(&["run", "scene.toml", "--out", "out"]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("B of memory") && message.contains("fewer spheres"), "{message}");
    assert!(!folder.0.join("out").exists());
}

/// The same for a packing.
#[test]
fn a_packing_that_cannot_fit_is_refused() {
    let folder = Folder::new("fit-pack");
    let output = folder.dempfv(&["pack", "--count", "4000000000", "--out", "out"]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("B of memory") && message.contains("fewer spheres"), "{message}");
}

/// Where a limit leaves little more than the run takes, it goes on with a warning; where it leaves
/// far less, it is refused. 300,000 spheres take about 0.4 GB dry, by the estimate.
#[test]
#[cfg(target_os = "linux")]
fn a_tight_limit_is_told() {
    let folder = Folder::new("tight");
    let text = scene("", "").replacen("count = 120", "count = 300000", 1);
    folder.write("scene.toml", &text);
    // What the program itself takes of the address space is some 0.1 GB.
    let tight = limited(&folder, "check scene.toml --threads 1 --json -", 550_000);
    assert!(tight.status.success(), "{}", error(&tight));
    let said = String::from_utf8_lossy(&tight.stdout).into_owned();
    assert!(said.contains("it may run out of memory") && said.contains("ulimit -v"), "{said}");
    let hopeless = limited(&folder, "check scene.toml --threads 1 --json -", 300_000);
    let said = String::from_utf8_lossy(&hopeless.stdout).into_owned();
    assert!(said.contains("it is refused here"), "{said}");
    let refused = limited(&folder, "run scene.toml --threads 1 --out out", 300_000);
    let message = error(&refused);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("left by ulimit -v"), "{message}");
}

/// The program with a limit on its address space.
#[cfg(target_os = "linux")]
fn limited(folder: &Folder, command: &str, kilobytes: u64) -> Output {
    let program = env!("CARGO_BIN_EXE_dempfv");
    let line = format!("ulimit -v {kilobytes}; exec {program} {command}");
    let mut shell = Command::new("sh");
    shell.current_dir(&folder.0).args(["-c", &line]).env("OPENBLAS_NUM_THREADS", "1");
    shell.output().unwrap()
}
