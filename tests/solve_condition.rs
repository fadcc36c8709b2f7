//! `dempfv solve` says how many digits of a solution are right, and refuses one that has none.

use std::path::PathBuf;
use std::process::{Command, Output};

fn solve(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dempfv")).arg("solve").args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A matrix file that is gone at the end of its test.
struct Matrix(PathBuf);

impl Matrix {
    /// From entries (row, column, value) of the lower triangle.
    fn new(name: &str, n: usize, entries: &[(usize, usize, f64)]) -> Matrix {
        let file = format!("dempfv-condition-{}-{name}.mtx", std::process::id());
        let path = std::env::temp_dir().join(file);
        let head = "%%MatrixMarket matrix coordinate real symmetric";
        let lines = entries.iter().map(|(i, j, v)| format!("{} {} {v:e}\n", i + 1, j + 1));
        let lines: String = lines.collect();
        std::fs::write(&path, format!("{head}\n{n} {n} {}\n{lines}", entries.len())).unwrap();
        Matrix(path)
    }

    /// n unknowns in a row, joined by 1, of which the first leaks: the inverse has rows of sum
    /// n / leak and more, so that the condition is 4 n / leak for small leaks.
    fn leaking_row(name: &str, n: usize, leak: f64) -> Matrix {
        let mut entries = vec![(0, 0, 1.0 + leak)];
        for k in 1..n {
            entries.push((k, k - 1, -1.0));
            entries.push((k, k, if k + 1 < n { 2.0 } else { 1.0 }));
        }
        Matrix::new(name, n, &entries)
    }

    fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }
}

impl Drop for Matrix {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn report(matrix: &Matrix, solver: &str) -> serde_json::Value {
    let output = solve(&[matrix.path(), "--solver", solver, "--json", "-"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The warnings of the condition; another one is of the BLAS, on newer processors.
fn warnings(report: &serde_json::Value) -> Vec<&str> {
    let all = report["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap());
    all.filter(|warning| warning.contains("condition number")).collect()
}

/// Well conditioned: the condition is told, and nobody is warned. n = 31 unknowns between two that
/// are zero: ‖A‖₁ = 4, ‖A⁻¹‖₁ = 32² / 8.
#[test]
fn a_good_matrix_has_its_condition_and_no_warning() {
    let n = 31;
    let entries: Vec<_> =
        (0..n).map(|k| (k, k, 2.0)).chain((1..n).map(|k| (k, k - 1, -1.0))).collect();
    let matrix = Matrix::new("good", n, &entries);
    for solver in ["cholmod", "frontal", "auto"] {
        let report = report(&matrix, solver);
        let condition = report["solvers"][0]["condition"].as_f64().unwrap();
        assert!((condition / 512.0 - 1.0).abs() < 1e-12, "{solver}: {condition}");
        assert!(report["solvers"][0]["error_estimate"].as_f64().unwrap() < 1e-12);
        assert!(warnings(&report).is_empty(), "{report}");
    }
    assert!(text(&solve(&[matrix.path()]).stdout).contains("5.1e2"));
}

/// A condition of 10¹¹ leaves four digits and more of sixteen: ε 10¹¹ = 2·10⁻⁵. One of 8·10¹² leaves two
/// and a condition of 10¹⁵ the first, with an error that is seen and a residual that is perfect.
#[test]
fn few_digits_are_told() {
    let enough = report(&Matrix::leaking_row("enough", 100, 4e-9), "cholmod");
    assert!(warnings(&enough).is_empty(), "{enough}");
    for (name, n, leak, said) in [
        ("two", 20_000, 1e-8, "about 2 digits of the solution are right"),
        ("first", 100, 4e-13, "hardly the first digit of the solution is right"),
    ] {
        let matrix = Matrix::leaking_row(name, n, leak);
        let report = report(&matrix, "cholmod");
        let solver = &report["solvers"][0];
        let ratio = solver["condition"].as_f64().unwrap() / (4.0 * n as f64 / leak);
        assert!(ratio > 1.0 / 3.0 && ratio < 1.5, "{ratio}");
        assert!(solver["residual"].as_f64().unwrap() < 1e-15);
        let error = solver["forward_error"].as_f64().unwrap();
        assert!(error > 1e-5 && error < solver["error_estimate"].as_f64().unwrap(), "{report}");
        let [warning] = warnings(&report)[..] else { panic!("{report}") };
        assert!(warning.starts_with("cholmod: the condition number"), "{warning}");
        assert!(warning.ends_with(said), "{warning}");
        let out = solve(&[matrix.path(), "--solver", "cholmod"]);
        assert!(text(&out.stdout).contains(&format!("warning: {warning}\n")));
    }
}

/// Beyond 1 / ε: status 3, one line with the number, and no solution is written. CHOLMOD's residual is
/// perfect and its error 77 % of the solution; the frontal solver leaves a residual that it refuses.
#[test]
fn a_solution_without_a_digit_is_refused() {
    let matrix = Matrix::leaking_row("none", 3000, 1e-13);
    let solution = std::env::temp_dir().join(format!("dempfv-condition-{}-x", std::process::id()));
    for (solver, said) in [
        ("cholmod", "its condition number is about 2.8e16"),
        ("auto", "its condition number is about 2.8e16"),
        ("frontal", "the solution leaves a relative residual"),
    ] {
        let to = solution.to_str().unwrap();
        let out = solve(&[matrix.path(), "--solver", solver, "--solution", to]);
        let error = text(&out.stderr);
        assert_eq!(out.status.code(), Some(3), "{solver}: {error}");
        assert!(error.contains(said) && error.lines().count() == 1, "{solver}: {error}");
        assert!(error.contains(matrix.path()) && !solution.exists());
    }
}

/// A small residual is not small enough where the condition is 4·10¹⁴: the frontal solver leaves
/// 3·10⁻⁹, which hides an error of 3 % here and could hide any.
#[test]
fn a_residual_that_the_condition_magnifies_is_refused() {
    let out = solve(&[Matrix::leaking_row("residual", 10, 1e-13).path(), "--solver", "frontal"]);
    assert_eq!(out.status.code(), Some(3), "{}", text(&out.stdout));
    assert!(text(&out.stderr).contains("no digit can be trusted"), "{}", text(&out.stderr));
}

/// Without a leak the row is singular, with a negative entry on the diagonal indefinite: each solver
/// that takes such matrices says so and gives no number.
#[test]
fn singular_and_indefinite_matrices_are_refused_by_all() {
    let singular = Matrix::leaking_row("singular", 100, 0.0);
    let indefinite = Matrix::leaking_row("indefinite", 100, -3.0);
    for solver in ["cholmod", "frontal", "auto"] {
        for (matrix, words) in [
            (&singular, ["singular to working precision", "not positive definite"]),
            (&indefinite, ["not positive definite", "not positive definite"]),
        ] {
            let out = solve(&[matrix.path(), "--solver", solver]);
            let error = text(&out.stderr);
            assert_eq!(out.status.code(), Some(3), "{solver}: {error}");
            assert!(words.iter().any(|word| error.contains(word)), "{solver}: {error}");
        }
    }
}
