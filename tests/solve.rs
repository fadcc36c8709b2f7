//! `dempfv solve` and `dempfv doctor`, run as a user runs them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn dempfv(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dempfv")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A folder of this test that is gone at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("dempfv-solve-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn write(&self, name: &str, contents: &str) -> String {
        std::fs::write(self.0.join(name), contents).unwrap();
        self.0.join(name).to_str().unwrap().to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The seven-point Laplacian on an m x m x m grid; the diagonal entry of
/// column `bad` (from 1) is -1 instead of 6.
fn laplacian(m: usize, bad: usize) -> String {
    let mut lines = Vec::new();
    for j in 0..m * m * m {
        let (x, y, z) = (j % m, j / m % m, j / (m * m));
        lines.push(format!("{0} {0} {1}", j + 1, if j + 1 == bad { -1 } else { 6 }));
        for (inside, stride) in [(x + 1 < m, 1), (y + 1 < m, m), (z + 1 < m, m * m)] {
            if inside {
                lines.push(format!("{} {} -1", j + stride + 1, j + 1));
            }
        }
    }
    let head = "%%MatrixMarket matrix coordinate integer symmetric";
    format!("{head}\n{0} {0} {1}\n{2}\n", m * m * m, lines.len(), lines.join("\n"))
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn laplacian_is_solved_to_round_off() {
    let folder = Folder::new("good");
    let matrix = folder.write("a.mtx", &laplacian(15, 0));
    let report = folder.0.join("report.json");
    let output = dempfv(&["solve", &matrix, "--json", report.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("cholmod     metis"));

    let report = json(&report);
    assert_eq!(report["unknowns"], 3375);
    let solver = &report["solvers"][0];
    assert!(solver["residual"].as_f64().unwrap() < 1e-12);
    assert!(solver["forward_error"].as_f64().unwrap() < 1e-12);
    for key in ["nnz_l", "flops", "analyze_s", "factor_s", "solve_s", "memory_bytes"] {
        assert!(solver[key].as_f64().unwrap() > 0.0, "{key}");
    }
}

/// With a right-hand side of the user's the solution is not known.
#[test]
fn right_hand_side_is_taken() {
    let folder = Folder::new("rhs");
    let matrix = folder.write("a.mtx", &laplacian(2, 0));
    let vector = folder
        .write("b.mtx", "%%MatrixMarket matrix array real general\n8 1\n1\n2\n3\n4\n5\n6\n7\n8\n");
    let output = dempfv(&["solve", &matrix, &vector, "--solver", "cholmod", "--json", "-"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["solvers"][0]["residual"].as_f64().unwrap() < 1e-15);
    assert!(report["solvers"][0]["forward_error"].is_null());
}

#[test]
fn indefinite_column_is_named_with_status_3() {
    let folder = Folder::new("bad");
    for column in [1, 300, 512] {
        let matrix = folder.write("a.mtx", &laplacian(8, column));
        let output = dempfv(&["solve", &matrix]);
        assert_eq!(output.status.code(), Some(3));
        let said = text(&output.stderr);
        assert!(said.contains(&format!("column {column} of the file (counted from 1)")), "{said}");
        assert!(
            said.contains("cholmod") && said.contains(&matrix) && said.lines().count() == 1,
            "{said}"
        );
    }
}

#[test]
fn wrong_input_is_told_with_status_2() {
    let folder = Folder::new("wrong");
    let matrix = folder.write("a.mtx", &laplacian(2, 0));
    let broken = folder.write("broken.mtx", &laplacian(2, 0).replace("2 1 -1", "2 1 minus"));
    let short = folder.write("b.mtx", "%%MatrixMarket matrix array real general\n3 1\n1\n2\n3\n");
    for (args, said) in [
        (vec![broken.as_str()], "broken.mtx:4: the value `minus`"),
        (vec![&matrix, &short], "b.mtx:2: the right-hand side is 3 x 1; it must be 8 x 1"),
        (vec!["nowhere.mtx"], "nowhere.mtx: cannot be read"),
        (
            vec![&matrix, "--solver", "colmod"],
            "unknown solver `colmod`; the solvers are: auto, cholmod",
        ),
    ] {
        let output = dempfv(&[vec!["solve"], args].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(said), "{}", text(&output.stderr));
    }
}

/// `doctor` names what a result depends on, with numbers where versions are due.
#[test]
fn doctor_tells_versions() {
    let output = dempfv(&["doctor", "--json", "-"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for name in ["suitesparse", "cholmod", "metis", "cgal", "rustc", "dempfv"] {
        let version = report["versions"][name].as_str().unwrap();
        assert!(version.starts_with(|c: char| c.is_ascii_digit()), "{name}: {version}");
    }
    assert!(!report["versions"]["blas"].as_str().unwrap().is_empty());
    assert!(report["cores"].as_u64().unwrap() >= 1);
    assert!(text(&dempfv(&["doctor"]).stdout).contains("GPU"));
}

/// Positive definite, with a positive entry off the diagonal: CHOLMOD's and not
/// the frontal solver's, which says so and leaves the rest alone, unless it is
/// the one that was asked for.
#[test]
fn a_matrix_of_no_network_is_solved_by_those_that_can() {
    let folder = Folder::new("other");
    let head = "%%MatrixMarket matrix coordinate integer symmetric";
    let matrix = folder.write("a.mtx", &format!("{head}\n2 2 3\n1 1 2\n2 1 1\n2 2 2\n"));
    let output = dempfv(&["solve", &matrix]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("frontal: the entry in row 1, column 0 is 1e0"), "{said}");
    assert!(said.contains("\ncholmod "), "{said}");
    let output = dempfv(&["solve", &matrix, "--solver", "frontal"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("use cholmod"));
}

/// Below the frontal solver's size `auto` is CHOLMOD, and says so.
#[test]
fn auto_tells_who_solves() {
    let folder = Folder::new("auto");
    let matrix = folder.write("a.mtx", &laplacian(6, 0));
    let report = folder.0.join("report.json");
    let out = dempfv(&["solve", &matrix, "--solver", "auto", "--json", report.to_str().unwrap()]);
    assert!(text(&out.stdout).contains("auto: by cholmod"), "{}", text(&out.stdout));
    assert_eq!(json(&report)["solvers"][0]["solved_by"], "cholmod");
}

/// What a right-hand side leaves out is zero, and the solution can be kept: of the Laplacian of
/// one cell beside that of two, say.
#[test]
fn a_sparse_right_hand_side_and_the_solution_as_a_file() {
    let folder = Folder::new("solution");
    let head = "%%MatrixMarket matrix coordinate real";
    let matrix = folder.write("a.mtx", &format!("{head} symmetric\n3 3 3\n1 1 2\n2 2 4\n3 3 5\n"));
    let rhs = folder.write("b.mtx", &format!("{head} general\n3 1 1\n2 1 8.0\n"));
    let solution = folder.0.join("x.mtx");
    let args = ["solve", &matrix, &rhs, "--solution", solution.to_str().unwrap()];
    let out = dempfv(&args);
    assert!(out.status.success(), "{}", text(&out.stderr));
    let x = std::fs::read_to_string(&solution).unwrap();
    assert_eq!(x, "%%MatrixMarket matrix array real general\n3 1\n0e0\n2e0\n0e0\n");
    let again = dempfv(&args);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("is there already"), "{}", text(&again.stderr));
}
