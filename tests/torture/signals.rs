//! Signals that end a run cleanly.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::specimen::{Random, Specimen, count, ends, scene};

/// Ctrl-C, SIGTERM, and SIGHUP of a terminal that is closed: exit status 130, a checkpoint, and
/// the rest gives the bytes of the undisturbed run. None of these runs writes checkpoints of its
/// own accord.
#[test]
fn signals_end_with_a_checkpoint() {
    let specimen = Specimen::new("signals", &scene(1200, [3, 0, 0]));
    let mut random = Random::new(3);
    let rounds = count("DEMPFV_SIGNALS", 1);
    for round in 0..rounds {
        for signal in ["INT", "TERM", "HUP"] {
            let out = format!("{signal}{round}");
            let mut command = specimen.command(&out);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            // The handlers stand before the first file is there.
            let place = specimen.folder.0.join(&out);
            while !place.join("history.csv").exists() {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(specimen.time / 400 * random.below(100) as u32);
            send(signal, child.id());
            assert!(ends(&mut child, Duration::from_secs(60)), "SIG{signal}: does not end");
            assert_eq!(child.wait().unwrap().code(), Some(130), "SIG{signal}");
            assert!(place.join("checkpoint.dempfv").exists(), "SIG{signal}");
            let summary = specimen.folder.json(&format!("{out}/summary.json"));
            assert_eq!(summary["interrupted"], true, "SIG{signal}");
            specimen.is_sound(&out, signal);
            specimen.goes_on_as_if_nothing_had_been(&out, signal);
        }
    }
    println!("signals: {} of INT, TERM and HUP; 0 bytes lost", 3 * rounds);
}

fn send(signal: &str, process: u32) {
    let kill = format!("kill -{signal} {process}");
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}
