//! Memory that runs out at any moment.

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;

use crate::preload::preload;
use crate::program::error;
use crate::specimen::{Random, Specimen, count, output_of, scene};

/// SIGABRT: how Rust ends a program whose allocation fails.
const ABORTED: i32 = 6;

/// An allocation of a run fails, or all large ones from there on: the run ends at once with a
/// message, or goes on without, and what it leaves is sound: it goes on from there with the bytes
/// of the undisturbed run.
#[test]
fn a_failing_allocation_spoils_nothing() {
    let specimen = Specimen::new("allocations", &scene(60, [3, 8, 20]));
    let folder = &specimen.folder.0;
    let mut command = specimen.command("counted");
    let log = preload(&mut command, folder, &[]);
    assert!(command.output().unwrap().status.success());
    let total = log.total("allocations").expect("a run that ends counts its allocations");
    let cases = count("DEMPFV_ALLOCATIONS", 16);
    let mut random = Random::new(5);
    let mut ends = BTreeMap::new();
    for k in 0..cases {
        // What is allocated once, at the start, is as likely as what each network takes.
        let range = if k % 2 == 0 { total } else { total.min(4000) };
        let (at, for_good) = (1 + random.below(range), k % 4 >= 2);
        let out = format!("out{k}");
        let context = format!("allocation {at}, for good: {for_good}");
        let mut command = specimen.command(&out);
        let settings = [
            ("FAIL_ALLOCATION", at.to_string()),
            ("FAIL_FOR_GOOD", u8::from(for_good).to_string()),
            ("FAIL_FROM", "4096".to_owned()),
        ];
        let log = preload(&mut command, folder, &settings);
        let output = output_of(&mut command, &context);
        let message = error(&output);
        let bytes = log.failure().map_or(0, |(_, bytes)| bytes);
        let context = format!("{context}, {bytes} bytes: {:?} {message}", output.status);
        let end = match (output.status.code(), output.status.signal()) {
            (Some(0), _) => "went on without",
            (Some(2 | 3), _) => {
                assert!(message.starts_with("error: "), "{context}");
                "an error of its own"
            }
            (_, Some(ABORTED)) if message.contains("memory allocation of") => {
                "ended at once with the number of bytes"
            }
            // Rust's and the C library's beginnings have words of their own.
            (_, Some(ABORTED)) => {
                assert!(!message.is_empty() && !folder.join(&out).exists(), "{context}");
                "ended at once, before anything was written"
            }
            _ => panic!("{context}"),
        };
        *ends.entry(end).or_insert(0) += 1;
        specimen.is_sound(&out, &context);
        specimen.goes_on_as_if_nothing_had_been(&out, &context);
        std::fs::remove_dir_all(folder.join(&out)).unwrap();
    }
    println!("allocations: {cases} of {total} failed: {ends:?}; 0 bytes lost");
}
