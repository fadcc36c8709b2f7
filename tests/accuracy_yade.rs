//! `dempfv accuracy-yade` with a shell script in YADE's place, of known errors and times: they arrive in the
//! page, beside ours. With YADE itself it is part of `make yade-test`.

mod program;

use std::fs;
use std::os::unix::fs::PermissionsExt;

use program::{Folder, error};

/// A course that is off by 8e-5 for each step of the interval, beside that of interval 0 or 1; 0.1 s, and
/// 10 s shared out over the interval.
const YADE: &str = r#"#!/bin/sh
if [ "$1" = --version ]; then echo 'Yade version: 2023.02a'; exit; fi
interval=$(sed -n 's/.*"remesh_interval": *\([0-9]*\).*/\1/p' "$DEMPFV_JOB")
awk -v n="$interval" 'BEGIN {
    factor = n > 1 ? 1 + 8e-5 * n : 1
    for (k = 1; k <= 32; k++) {
        moved = moved c sprintf("%.15g", -1e-6 * k * factor)
        row = ""; d = ""
        for (i = 1; i <= 45; i++) { row = row d sprintf("%.15g", (100 * k + i) * factor); d = "," }
        pressure = pressure c "[" row "]"; c = ","
    }
    printf "{\"result\": {\"displacement\": [%s], \"pressure\": [%s], \"pores\": 321,", moved, pressure
    print "\"seconds\": " 0.1 + 10 / n "}, \"peak_memory_bytes\": 1}"
}' > "$DEMPFV_RESULT"
"#;

/// A folder with a small packing that has settled at 1 kPa, and a program `yade`.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.done(&["pack", "--count", "60", "--edge", "0.009", "--stress", "1e3", "--out", "pack"]);
    folder.write("yade", YADE);
    fs::set_permissions(folder.0.join("yade"), fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

#[test]
fn both_programs_are_on_the_same_axes() {
    let folder = folder("accuracy-yade");
    let words = [
        "accuracy-yade",
        "pack/packing.txt",
        "--quick",
        "--yade",
        "./yade",
        "--out",
        "a",
        "--json",
        "-",
    ];
    // The script loads nothing, so the references have nothing in common: told after the report.
    let output = folder.dempfv(&words);
    assert_eq!(output.status.code(), Some(3), "{}", error(&output));
    assert!(error(&output).contains("2 outside the bounds, in a/yade.md"), "{}", error(&output));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 5 * 3);
    let of = |way: &str, interval: u64, key: &str| {
        let found = points.iter().find(|p| p["way"] == way && p["interval"] == interval);
        found.unwrap_or_else(|| panic!("{way} {interval}: {report}"))[key].clone()
    };
    let number = |way: &str, interval, key: &str| of(way, interval, key).as_f64().unwrap();
    for quantity in ["error_pressure", "error_settlement"] {
        // The script's.
        for interval in [10, 50, 200, 1000] {
            let off = number("yade", interval, quantity) / (8e-5 * interval as f64);
            assert!((off - 1.0).abs() < 1e-9, "{interval}: {off}");
        }
        // Ours: the reference is the network at each step; older networks are worse.
        assert_eq!(number("at_once", 1, quantity), 0.0);
        for way in ["at_once", "background"] {
            let [often, seldom] = [10, 1000].map(|interval| number(way, interval, quantity));
            assert!(0.0 < often && often < seldom && seldom < 1.0, "{way}: {often}, {seldom}");
        }
        // A network of a step before is worse than one of this step.
        assert!(number("background", 1, quantity) > 0.0);
    }
    // 1,199 steps of 1 µs after the first.
    let seconds = of("yade", 50, "seconds")[0].as_f64().unwrap();
    assert!((seconds * 1.199e-3 - 0.3).abs() < 1e-9, "{seconds}");

    // By hand: 1e-2 lies between 200 steps (1.6e-2 in 0.15 s) and 50 (4e-3 in 0.3 s), at ln 1.6 / ln 4 of
    // the way: 0.1897 s.
    let page = folder.read("a/yade.md");
    assert!(page.contains("pore pressure, error 0.01: YADE 158 s per s"), "{page}");
    assert!(page.contains("| 50 | 250 | 4.0e-3 | 4.0e-3 |"), "{page}");
    assert!(page.contains("YADE 2023.02a solves by `useSolver = 3`"), "{page}");
    assert_eq!(folder.read("a/yade.csv").lines().count(), 1 + 5 * 3);
    assert!(folder.0.join("a/yade.png").is_file());

    // What is there stays.
    let again = folder.dempfv(&words);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));
}

#[test]
fn a_packing_or_a_yade_that_is_not_there_is_named() {
    let folder = folder("accuracy-yade-missing");
    for (words, status, what) in [
        (&["none.txt"][..], 2, "none.txt"),
        (&[], 2, "name a packing file"),
        (&["pack/packing.txt", "--yade", "./nowhere"], 3, "install Debian's package `yade`"),
    ] {
        let output = folder.dempfv(&[&["accuracy-yade", "--out", "a"], words].concat());
        assert_eq!(output.status.code(), Some(status), "{words:?}: {}", error(&output));
        assert!(error(&output).contains(what), "{words:?}: {}", error(&output));
    }
    assert!(!folder.0.join("a").exists());
}
