//! A disk that is full, or fails, at any moment.

use std::process::Output;

use crate::preload::preload;
use crate::program::error;
use crate::specimen::{Specimen, count, output_of, scene};

/// No space left on device.
const ENOSPC: i32 = 28;
/// Read-only file system.
const EROFS: i32 = 30;

/// Every call that changes the folder of a run fails in turn, once or for good: the run ends
/// with one message and a status that is not zero, what it leaves is sound, and it goes on from
/// there with the bytes of the undisturbed run.
#[test]
fn a_full_disk_at_any_moment_spoils_nothing() {
    let specimen = Specimen::new("disk", &scene(60, [3, 8, 20]));
    let stride = count("DEMPFV_DISK_STRIDE", 9) as u64;
    for for_good in [false, true] {
        let (mut cases, mut at, mut kinds) = (0, 1, std::collections::BTreeSet::new());
        loop {
            let out = format!("out{for_good}{at}");
            let context = format!("call {at}, for good: {for_good}");
            let (output, failed) = disturbed(&specimen, &out, at, for_good, ENOSPC);
            let Some(call) = failed else {
                assert!(output.status.success(), "{context}: {}", error(&output));
                break;
            };
            let message = error(&output);
            let code = output.status.code();
            assert!(matches!(code, Some(2 | 3)), "{context}, {call}: {code:?}: {message}");
            assert_eq!(message.lines().count(), 1, "{context}, {call}: {message}");
            assert!(message.contains("No space left on device"), "{context}, {call}: {message}");
            specimen.is_sound(&out, &context);
            specimen.goes_on_as_if_nothing_had_been(&out, &format!("{context}, {call}"));
            std::fs::remove_dir_all(specimen.folder.0.join(&out)).unwrap();
            kinds.insert(call);
            cases += 1;
            at += stride;
        }
        let how = if for_good { "for good" } else { "once" };
        println!("disk: {cases} calls failed {how} ({kinds:?}); 0 bytes lost");
    }
}

/// A folder that may not be written to is refused before anything is computed (status 2).
#[test]
fn a_read_only_folder_is_refused() {
    let specimen = Specimen::new("read-only", &scene(20, [3, 0, 0]));
    std::fs::create_dir(specimen.folder.0.join("out")).unwrap();
    let (output, call) = disturbed(&specimen, "out", 1, true, EROFS);
    let message = error(&output);
    assert_eq!((output.status.code(), call.as_deref()), (Some(2), Some("mkdir")), "{message}");
    assert!(message.contains("Read-only") && message.contains("may write to"), "{message}");
    assert_eq!(std::fs::read_dir(specimen.folder.0.join("out")).unwrap().count(), 0);
}

/// A run whose `at`-th call fails, and the call that it was, if it came to that.
fn disturbed(
    specimen: &Specimen,
    out: &str,
    at: u64,
    for_good: bool,
    errno: i32,
) -> (Output, Option<String>) {
    let folder = &specimen.folder.0;
    let mut command = specimen.command(out);
    let settings = [
        ("FAIL_UNDER", folder.join(out).to_str().unwrap().to_owned()),
        ("FAIL_CALL", at.to_string()),
        ("FAIL_ERRNO", errno.to_string()),
        ("FAIL_FOR_GOOD", u8::from(for_good).to_string()),
    ];
    let log = preload(&mut command, folder, &settings);
    let output = output_of(&mut command, &format!("call {at}"));
    (output, log.failure().map(|(call, _)| call))
}
