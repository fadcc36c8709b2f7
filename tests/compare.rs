//! The comparison with another program that is not there, crashes, or answers nonsense.
//! A shell script stands in for YADE.

mod program;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Output;

use program::{Folder, error};

/// What the stand-in does first: it has a version, and counts its calls.
const VERSION: &str = "if [ \"$1\" = --version ]; then echo 'Yade version: 2023.02a'; exit; fi\n\
                       echo \"$DEMPFV_JOB\" >> calls.txt\n";
/// The first script only asks for versions: an answer to it.
const STARTS: &str = "case \"$DEMPFV_JOB\" in */start.json)\n\
                      echo '{\"result\": {\"cgal\": \"5.5.1\"}, \"peak_memory_bytes\": 1}' \
                      > \"$DEMPFV_RESULT\"; exit;; esac\n";

/// A folder with a small packing and a program `bin/yade`.
fn folder(name: &str, yade: &str) -> Folder {
    let folder = Folder::new(name);
    // Spheres of a millimetre, pressed together by 1 kPa as those of the shipped packings.
    folder.done(&["pack", "--count", "60", "--edge", "0.009", "--stress", "1e3", "--out", "pack"]);
    fs::rename(folder.0.join("pack/packing.txt"), folder.0.join("p.txt")).unwrap();
    fs::create_dir(folder.0.join("bin")).unwrap();
    folder.write("bin/yade", &format!("#!/bin/sh\n{yade}"));
    let mode = fs::Permissions::from_mode(0o755);
    fs::set_permissions(folder.0.join("bin/yade"), mode).unwrap();
    folder
}

/// Compares times, with `bin` before everything else on the path.
fn compare(folder: &Folder, more: &[&str]) -> Output {
    let args = ["compare", "yade", "p.txt", "--part", "time", "--out", "out"];
    let path = format!("{}:/usr/bin:/bin", folder.0.join("bin").display());
    folder.command(&[&args, more].concat()).env("PATH", path).output().unwrap()
}

/// Exit status 3, one line with these words, no report.
fn fails(folder: &Folder, words: &[&str]) {
    let output = compare(folder, &[]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!folder.0.join("out/yade.md").exists());
}

#[test]
fn a_missing_yade_is_named_with_the_package_that_has_it() {
    let folder = folder("yade-missing", "");
    let output = folder
        .command(&["compare", "yade", "p.txt", "--out", "out"])
        .env("PATH", folder.0.join("nowhere"))
        .output()
        .unwrap();
    let message = error(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("yade --version"), "{message}");
    assert!(message.contains("install Debian's package `yade`"), "{message}");
    assert!(!folder.0.join("out").exists());
}

/// Something else of that name, a version without a number, and one that fails.
#[test]
fn what_is_not_yade_is_shown_by_what_it_says() {
    for (script, words) in [
        ("echo 'yet another decision engine 7'", ["yet another decision engine 7", "--yade"]),
        ("echo 'Yade version:'", ["`Yade version:`", "--yade"]),
        ("echo 'Yade version: 2023.02a'; exit 4", ["ends with status 4", "--yade"]),
        ("", ["says `nothing`", "--yade"]),
    ] {
        let folder = folder("yade-other", script);
        fails(&folder, &words);
        assert!(!folder.0.join("out").exists());
    }
}

/// The step and the log are named, and the log holds what was printed, errors included.
#[test]
fn a_crash_names_the_step_and_the_log() {
    let crash = "echo 'loading'; echo 'assertion failed' >&2; kill -SEGV $$\n";
    let folder = folder("yade-crash", &[VERSION, crash].concat());
    fails(&folder, &["start: YADE crashes (segmentation fault)", "out/logs/start.log"]);
    assert_eq!(folder.read("out/logs/start.log"), "loading\nassertion failed\n");
}

/// A later step fails: what is known stays known, and the next call begins there.
#[test]
fn a_failure_is_gone_on_from() {
    let folder = folder("yade-later", &[VERSION, STARTS, "exit 1\n"].concat());
    let step = "time-480-1-solver3-blas1-run0";
    fails(&folder, &[step, "ends with status 1", &format!("out/logs/{step}.log")]);
    let once = folder.read("calls.txt");
    assert_eq!(once.lines().count(), 2, "{once}");
    fails(&folder, &[step]);
    let twice = folder.read("calls.txt");
    assert_eq!(twice.lines().count(), 3, "the first step is not repeated: {twice}");
    assert!(twice.lines().last().unwrap().ends_with(&format!("{step}.json")));
}

#[test]
fn no_result_and_a_result_of_another_form_are_told_apart() {
    let answer = |text: &str| format!("echo '{text}' > \"$DEMPFV_RESULT\"\n");
    for (script, what) in [
        ("echo done\n".to_owned(), "ended without a result"),
        (answer("no JSON"), "left something unexpected"),
        (answer("{\"result\": 5, \"peak_memory_bytes\": 1}"), "left something unexpected"),
        (answer("{\"peak_memory_bytes\": 1}"), "left something unexpected"),
    ] {
        let folder = folder("yade-result", &[VERSION, STARTS, &script].concat());
        fails(&folder, &["time-480-1-", what, ".log"]);
    }
}

/// A result from an earlier version of the script does not pass for that of this run.
#[test]
fn an_old_result_is_not_taken_for_a_new_one() {
    let folder = folder("yade-old", &[VERSION, "exit 0\n"].concat());
    fs::create_dir_all(folder.0.join("out/jobs")).unwrap();
    let old = "{\"result\": {\"cgal\": \"5.5.1\"}, \"peak_memory_bytes\": 1}";
    folder.write("out/jobs/start.result.json", old);
    fails(&folder, &["start", "ended without a result"]);
}

/// Clocks of an engine that runs as many steps as it is told: 1 ms in every engine and 9 in
/// the flow engine, of it 5 in the solve; a network of 10 ms at the first step, factorized
/// in 30.
const CLOCKS: &str = r#"
steps=$(sed -n 's/.*"steps": *\([0-9]*\).*/\1/p' "$DEMPFV_JOB")
awk -v n="$steps" 'BEGIN {
    for (i = 1; i <= n; i++) {
        clock = clock c (0.014 * i + 0.050); c = ","
        e = 1e6 * i
        engines = engines d "[" e "," e "," e "," (9e6 * i + 40e6) "," e "," e ",0]"
        flow = flow d "[10e6," 2e6 * i "," (5e6 * i + 30e6) "," 2e6 * i ",0]"; d = ","
    }
    printf "{\"result\": {\"clock_s\": [%s], \"engines_ns\": [%s], \"flow_ns\": [%s],", clock, engines, flow
    print "\"engine_names\": [\"ForceResetter\", \"InsertionSortCollider\", \"InteractionLoop\","
    print " \"FlowEngine\", \"TriaxialStressController\", \"NewtonIntegrator\", \"PyRunner\"],"
    print "\"flow_names\": [\"Triangulating\", \"Update_Volumes\", \"Factorize + Solve\","
    print " \"compute_Forces\", \"triangulate + init volumes\"],"
    print "\"pores\": 321, \"base_memory_bytes\": 9000000}, \"peak_memory_bytes\": 44000000}"
}' > "$DEMPFV_RESULT"
"#;

/// The whole way with a YADE of known times: they arrive in the report, beside ours, and a
/// report stays unless --force is given.
#[test]
fn times_arrive_in_the_report() {
    let folder = folder("yade-times", &[VERSION, STARTS, CLOCKS].concat());
    let output = compare(&folder, &["--json", "report.json"]);
    assert!(output.status.success(), "{}", error(&output));
    let page = folder.read("out/yade.md");
    // 14 ms a step, and 40 every 200 steps.
    for words in ["| 60 | 321 | 1 | 14.2 |", "| 480 | 321 | 1 | 14.2 |", "44 MB", "9 MB of YADE's"]
    {
        assert!(page.contains(words), "`{words}` is not in:\n{page}");
    }
    let row = |name: &str| {
        let line = page.lines().find(|line| line.starts_with(&format!("| {name} |")));
        line.and_then(|l| l.split('|').nth(2)).unwrap_or("missing").trim().to_owned()
    };
    assert_eq!(row("contacts"), "3");
    assert_eq!(row("integration, servo"), "2");
    assert_eq!(row("volumes"), "2");
    assert_eq!(row("solve"), "5");
    assert_eq!(row("forces"), "2");
    assert_eq!(row("remesh: network"), "10");
    assert_eq!(row("remesh: order, analyse, factorize"), "30");
    assert!(page.contains("](yade/time.png)") && folder.0.join("out/yade/time.png").exists());
    assert_eq!(folder.json("report.json")["yade"], "2023.02a");
    let before = folder.files();
    let again = compare(&folder, &[]);
    assert_eq!(again.status.code(), Some(2), "{}", error(&again));
    assert!(error(&again).contains("--force"), "{}", error(&again));
    assert!(folder.files() == before);
}

/// A YADE without a clock that its times need.
#[test]
fn a_missing_clock_is_named() {
    let clocks = CLOCKS.replace("Factorize + Solve", "Solve");
    let folder = folder("yade-clock", &[VERSION, STARTS, &clocks].concat());
    fails(&folder, &["time-480-1-", "no clock `Factorize + Solve`", ".log"]);
}

#[test]
fn wrong_arguments_end_with_status_2_and_leave_nothing() {
    let folder = folder("yade-arguments", VERSION);
    for (args, what) in [
        (&["yade", "none.txt"][..], "none.txt"),
        (&["yade", "p.txt", "--part", "colour"], "colour"),
        (&["yade"], "name packings"),
        (&["lammps"], "lammps"),
    ] {
        let output = folder.dempfv(&[&["compare"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", error(&output));
        assert!(error(&output).contains(what), "{args:?}: {}", error(&output));
    }
    assert!(!folder.0.join("out").exists());
}
