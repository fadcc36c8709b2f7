//! `dempfv paper` keeps what it measures, and its page says what it has.

mod program;

use std::path::Path;

use program::{Folder, error};

/// Runs the program where it finds the project's packings, with results in the folder.
fn paper(folder: &Folder, args: &[&str]) -> std::process::Output {
    let out = folder.0.join("p");
    let mut command = folder.command(&["paper", "--out", out.to_str().unwrap()]);
    command.args(args).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

/// A column of the raw timings.
fn column(folder: &Folder, name: &str) -> Vec<String> {
    let text = folder.read("p/paper/timings.csv");
    let mut rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let at = rows.next().unwrap().iter().position(|c| c == name).unwrap();
    rows.map(|row| row[at].clone()).collect()
}

/// The page is written of every point that is known, and its pictures are there.
fn assert_page_is_complete(folder: &Folder) {
    let page = folder.read("p/paper.md");
    let links: Vec<&str> =
        page.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()).collect();
    assert!(links.len() > 10, "{links:?}");
    for link in links {
        assert!(folder.0.join("p").join(link).is_file(), "{link}");
    }
    for figure in [2, 5, 6, 7, 8, 9, 10] {
        assert!(page.contains(&format!("## Figure {figure}:")), "Figure {figure}");
    }
    // The paper's summary has seven claims.
    let claims = page.split("## The claims").nth(1).unwrap().split("##").next().unwrap();
    assert_eq!(claims.lines().filter(|line| line.starts_with('|')).count(), 2 + 7);
}

#[test]
fn points_are_kept_and_only_what_is_missing_is_measured() {
    let folder = Folder::new("paper");
    let first = paper(&folder, &["--figure", "10", "--sizes", "1000", "--threads", "2"]);
    assert!(first.status.success(), "{}", error(&first));
    assert_page_is_complete(&folder);
    assert_eq!(column(&folder, "mode"), ["one-core", "all-cores", "cholmod"]);
    // The promise of equal bits on one core and on two.
    let hashes = column(&folder, "state_hash");
    assert!(!hashes[0].is_empty() && hashes[0] == hashes[1], "{hashes:?}");

    // One point is lost: the other stays as it is, to the byte.
    let kept = folder.read("p/points/run-1000-one-core.json");
    std::fs::remove_file(folder.0.join("p/points/run-1000-all-cores.json")).unwrap();
    let second = paper(&folder, &["--figure", "10", "--sizes", "1000", "--threads", "2"]);
    assert!(second.status.success(), "{}", error(&second));
    assert_eq!(folder.read("p/points/run-1000-one-core.json"), kept);
    assert_eq!(column(&folder, "mode"), ["one-core", "all-cores", "cholmod"]);

    // What another machine has measured on its GPU gets its column, unless no GPU worked.
    std::fs::create_dir_all(folder.0.join("p/gpu")).unwrap();
    let one_core = folder.json("p/runs/run-1000-one-core/summary.json");
    let mut with_gpu = one_core.clone();
    let file = |with_gpu: &serde_json::Value| {
        let measured = serde_json::json!({
            "name": "H1", "gpu": {}, "machine": "m", "day": "d", "with_gpu": with_gpu, "warm": { "analyze_s": 1.0, "factor_s": 0.5 },
            "one_core": one_core, "all_cores": { "analyze_s": 1.0, "factor_s": 1.0 }, "threads": 16,
        });
        folder.write("p/gpu/H1-1000.json", &measured.to_string());
    };
    file(&with_gpu);
    let refused = paper(&folder, &["--figure", "10", "--sizes", "1000", "--threads", "2"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(error(&refused).contains("H1-1000.json"), "{}", error(&refused));
    with_gpu["gpu"] = serde_json::json!({ "syrk_calls": 5, "share": 0.5, "fallbacks": 0 });
    file(&with_gpu);
    let third = paper(&folder, &["--figure", "10", "--sizes", "1000", "--threads", "2"]);
    assert!(third.status.success(), "{}", error(&third));
    assert_eq!(column(&folder, "device"), ["cpu", "cpu", "cpu", "H1", "cpu beside H1"]);
    assert!(folder.read("p/paper.md").contains("| 1 core | 2 cores | CHOLMOD, 1 core | H1 |"));

    // Force measures again: the same bits in another time.
    let again = paper(&folder, &["--figure", "10", "--sizes", "1000", "--threads", "2", "--force"]);
    assert!(again.status.success(), "{}", error(&again));
    assert_ne!(folder.read("p/points/run-1000-one-core.json"), kept);
    assert_eq!(column(&folder, "state_hash")[..3], hashes);
}

#[test]
fn what_there_is_no_specimen_of_is_refused_before_anything_is_written() {
    let folder = Folder::new("paper-sizes");
    let output = paper(&folder, &["--sizes", "1000,1001"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("--sizes 1001"), "{}", error(&output));
    assert!(error(&output).contains("1000, 5000"), "{}", error(&output));
    assert!(!Path::new(&folder.0.join("p")).exists());
}

/// Away from a checkout there are no packings to begin with.
#[test]
fn a_missing_packing_is_named() {
    let folder = Folder::new("paper-elsewhere");
    let output = folder.dempfv(&["paper", "--figure", "10", "--sizes", "1000"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("oedometer-1000.txt"), "{}", error(&output));
    assert!(folder.files().is_empty());
}
