//! Folders that two runs want, and readers that go away.

use std::process::Stdio;
use std::time::Duration;

use crate::program::error;
use crate::specimen::{Specimen, scene};

/// A second run into a folder is refused (status 2) while the first goes on undisturbed. The lock
/// of a run that was killed does not stand in the way.
#[test]
fn a_folder_has_one_run() {
    let specimen = Specimen::new("lock", &scene(1200, [3, 20, 100]));
    let place = specimen.folder.0.join("out");
    let mut command = specimen.command("out");
    let mut first = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // The first file: from here on the folder is locked.
    while !place.join("history.csv").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let second = specimen.command("out").output().unwrap();
    let message = error(&second);
    assert_eq!(second.status.code(), Some(2), "{message}");
    assert!(message.contains("another run writes into"), "{message}");
    assert!(first.wait().unwrap().success());
    specimen.is_whole("out", "two runs into one folder");

    let mut killed = specimen.command("killed").stdout(Stdio::null()).spawn().unwrap();
    while !specimen.folder.0.join("killed/checkpoint.dempfv").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    specimen.goes_on_as_if_nothing_had_been("killed", "after a kill");
}

/// Readers of stdout and stderr that go away before the run does not keep it from its end.
#[test]
fn closed_pipes_do_not_end_a_run() {
    let specimen = Specimen::new("pipe", &scene(60, [3, 0, 0]));
    let mut command = specimen.command("out");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().unwrap().code(), Some(0));
    specimen.is_whole("out", "closed pipes");
}
