//! `ulimit -v`: OpenBLAS asks for its buffers without end where the system refuses them, and waits for
//! its threads when the process exits. No command may hang on it.
#![cfg(target_os = "linux")]

mod program;

use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

use program::{Folder, error, packing};

/// Longer than any of these takes on a busy machine (s).
const PATIENCE: u64 = 120;

/// Runs the program with so many kilobytes of address space, and expects it to end.
fn within(folder: &Folder, kilobytes: u64, args: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_dempfv");
    let limit = format!("ulimit -v {kilobytes} && exec \"$@\"");
    let mut child = std::process::Command::new("sh")
        .current_dir(&folder.0)
        .args(["-c", &limit, "sh", program])
        .args(args)
        // More than one on any machine: each takes 128 MiB, or asks for it without end.
        .env("OPENBLAS_NUM_THREADS", "3")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert!(has_ended(&mut child), "{args:?} hangs within {kilobytes} kB");
    child.wait_with_output().unwrap()
}

/// Kills one that does not end.
fn has_ended(child: &mut Child) -> bool {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(PATIENCE) {
        if child.try_wait().unwrap().is_some() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    false
}

/// The default solver needs no buffer of OpenBLAS: 300,000 kB are enough for 5,000 spheres, whose
/// network has 28,230 unknowns.
#[test]
fn the_default_solver_is_done_where_openblas_has_no_room() {
    let folder = Folder::new("address-space-auto");
    let packing = packing("oedometer-5000.txt");
    let output = within(&folder, 300_000, &["network", &packing, "--threads", "2"]);
    assert!(output.status.success(), "{}", error(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("28,230 unknown"));
}

/// CHOLMOD does need one: what is missing is told in bytes, before OpenBLAS is called, and with room
/// for it the network is solved.
#[test]
fn cholmod_tells_how_much_openblas_needs() {
    let folder = Folder::new("address-space-cholmod");
    let packing = packing("oedometer-1000.txt");
    let args = ["network", &packing, "--solver", "cholmod", "--threads", "1"];
    let output = within(&folder, 200_000, &args);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("cholmod needs 134225920 bytes of address space"), "{message}");
    assert!(message.contains("ulimit -v") && message.lines().count() == 1, "{message}");
    let output = within(&folder, 1_000_000, &args);
    assert!(output.status.success(), "{}", error(&output));
}
