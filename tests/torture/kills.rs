//! kill −9 at any moment, and restarts from the last checkpoint.

use std::process::Stdio;
use std::time::Duration;

use crate::specimen::{Random, Specimen, count, ends, scene};

/// A run is killed at random moments and goes on from its last checkpoint, again and again, until
/// it ends: no row is missing or doubled, every frame is there and whole, nothing else is left,
/// and state and files have the bytes of the undisturbed run.
#[test]
fn killed_runs_lose_nothing() {
    let specimen = Specimen::new("kills", &scene(1200, [3, 17, 40]));
    let mut random = Random::new(1);
    let kills = count("DEMPFV_KILLS", 8);
    let (mut killed, mut runs, mut latest) = (0, 0, 0);
    while killed < kills {
        let out = format!("out{runs}");
        loop {
            let mut command = specimen.command(&out);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            // Half of the time of a whole run: most runs are killed two times or more.
            let moment = random.below(specimen.time.as_micros() as u64 / 2);
            if ends(&mut child, Duration::from_micros(moment)) {
                assert!(child.wait().unwrap().success(), "run {runs}, after {killed} kills");
                break;
            }
            killed += 1;
            latest = latest.max(moment);
            specimen.is_sound(&out, &format!("run {runs}, kill {killed} after {moment} µs"));
        }
        specimen.is_whole(&out, &format!("run {runs}"));
        std::fs::remove_dir_all(specimen.folder.0.join(&out)).unwrap();
        runs += 1;
    }
    println!(
        "kills: {killed} kills in {runs} runs, up to {latest} µs after the start; 0 bytes lost"
    );
}

/// A chain of restarts, each after a random number of steps, from a checkpoint that the end of
/// `--steps` has left or an earlier part: all bits are those of one run.
#[test]
fn chains_of_restarts_keep_all_bits() {
    let specimen = Specimen::new("chains", &scene(400, [3, 7, 50]));
    let mut random = Random::new(2);
    let (chains, mut parts) = (count("DEMPFV_CHAINS", 2), 0);
    for chain in 0..chains {
        let out = format!("out{chain}");
        loop {
            let steps = (1 + random.below(90)).to_string();
            let output = specimen.command(&out).args(["--steps", &steps]).output().unwrap();
            assert!(output.status.success(), "{}", crate::program::error(&output));
            parts += 1;
            if specimen.folder.json(&format!("{out}/summary.json"))["finished"] == true {
                break;
            }
            specimen.is_sound(&out, &format!("chain {chain}"));
        }
        specimen.is_whole(&out, &format!("chain {chain}"));
    }
    println!("chains: {chains} of {parts} parts; 0 bytes lost");
}
