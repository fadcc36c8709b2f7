//! Matrix Market files: what is read back, and what is said of wrong ones.

mod solver_systems;

use std::path::PathBuf;

use dempfv::io::IoError;
use dempfv::io::matrix_market::{read_matrix, read_vector, write_matrix, write_vector};
use solver_systems::{network, numbers};

/// A file of this test that is gone at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, text: &str) -> Scratch {
        let path = std::env::temp_dir().join(format!("dempfv-{}-{name}.mtx", std::process::id()));
        std::fs::write(&path, text).unwrap();
        Scratch(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// What the reader says of a matrix: line, fault and remedy.
fn complaint(name: &str, text: &str) -> (usize, String) {
    let file = Scratch::new(name, text);
    match read_matrix(&file.0) {
        Err(IoError::Input(e)) => {
            assert_eq!(e.file.as_ref(), Some(&file.0));
            (e.line.unwrap(), format!("{}; {}", e.what, e.remedy))
        }
        other => panic!("{other:?}"),
    }
}

const SYMMETRIC: &str = "%%MatrixMarket matrix coordinate real symmetric\n";
const GENERAL: &str = "%%MatrixMarket matrix coordinate real general\n";

/// All layouts of | 4 -1 0 |, | -1 4 -2 |, | 0 -2 4 |: unsorted, upper or lower
/// half, Fortran's exponents, comments, blank lines and carriage returns. The
/// product with (1, 10, 100) tells every entry.
#[test]
fn every_layout_gives_the_same_matrix() {
    let layouts = [
        format!("{SYMMETRIC}% words\n\n3 3 5\n3 2 -2\n1 1 4.0\n2 2 4\n2 1 -1e0\n  3 3  4\n"),
        format!("{SYMMETRIC}3 3 5\r\n1 1 4\r\n1 2 -1\r\n2 2 4\r\n2 3 -0.2D+1\r\n3 3 4\r\n"),
        format!("{GENERAL}3 3 7\n1 1 4\n2 1 -1\n1 2 -1\n2 2 4\n3 2 -2\n2 3 -2\n3 3 4\n"),
        "%%matrixmarket MATRIX Array Integer General\n3 3\n4\n-1\n0\n-1\n4\n-2\n0\n-2\n4\n"
            .to_owned(),
        "%%MatrixMarket matrix array real symmetric\n3 3\n4\n-1\n0\n4\n-2\n4\n".to_owned(),
        "\u{feff}%%MatrixMarket matrix array real symmetric\n3 3\n4\n-1\n0\n4\n-2\n4\n".to_owned(),
    ];
    for (k, text) in layouts.iter().enumerate() {
        let a = read_matrix(&Scratch::new(&format!("layout-{k}"), text).0).unwrap();
        a.validate().unwrap();
        let mut y = [0.0; 3];
        a.multiply(&[1.0, 10.0, 100.0], &mut y).unwrap();
        assert_eq!(y, [-6.0, -161.0, 380.0], "layout {k}");
    }
}

#[test]
fn what_was_written_is_read_back_bit_for_bit() {
    let (a, b) = (network(8, 1), numbers(512, 2));
    let (matrix, vector) = (Scratch::new("matrix", ""), Scratch::new("vector", ""));
    write_matrix(&matrix.0, &a).unwrap();
    write_vector(&vector.0, &b).unwrap();
    assert_eq!(read_matrix(&matrix.0).unwrap(), a);
    assert_eq!(read_vector(&vector.0, 512).unwrap(), b);
}

/// A missing diagonal entry is a zero, which a solver then finds indefinite.
#[test]
fn missing_diagonal_is_zero() {
    let text = format!("{SYMMETRIC}2 2 2\n1 1 1\n2 1 5\n");
    let a = read_matrix(&Scratch::new("diagonal", &text).0).unwrap();
    assert_eq!(a.values, [1.0, 5.0, 0.0]);
    a.validate().unwrap();
}

#[test]
fn asymmetric_entry_is_named() {
    let (line, said) =
        complaint("asymmetric", &format!("{GENERAL}2 2 4\n1 1 1\n2 1 5\n1 2 5.5\n2 2 9\n"));
    assert_eq!(line, 4);
    assert!(said.contains("entry (2, 1) is 5 but entry (1, 2) is 5.5"), "{said}");
    let (line, said) = complaint("one-sided", &format!("{GENERAL}2 2 3\n1 1 1\n1 2 5\n2 2 9\n"));
    assert_eq!(line, 4);
    assert!(said.contains("entry (1, 2) is 5 but entry (2, 1) is 0"), "{said}");
}

#[test]
fn each_fault_is_told_with_its_line() {
    let faults = [
        ("empty", String::new(), 1, "no Matrix Market file"),
        ("words", "1 2 3\n".to_owned(), 1, "no Matrix Market file"),
        ("complex", SYMMETRIC.replace("real", "complex"), 1, "coordinate complex symmetric"),
        ("pattern", SYMMETRIC.replace("real", "pattern"), 1, "coordinate pattern symmetric"),
        ("no-size", format!("{SYMMETRIC}% only words\n"), 1, "the size line is missing"),
        ("bad-size", format!("{SYMMETRIC}3 3\n"), 2, "`3 3` is no size line"),
        ("negative", format!("{SYMMETRIC}-3 3 3\n"), 2, "`-3 3 3` is no size line"),
        ("oblong", format!("{GENERAL}2 3 2\n1 1 1\n2 2 1\n"), 2, "2 rows and 3 columns"),
        (
            "huge",
            format!("{SYMMETRIC}9000000000000000 9000000000000000 1\n1 1 1\n"),
            2,
            "cannot fill",
        ),
        (
            "wide",
            "%%MatrixMarket matrix array real symmetric\n3 18446744073709551615\n4\n".to_owned(),
            2,
            "3 rows and 18446744073709551615 columns",
        ),
        (
            "hollow",
            "%%MatrixMarket matrix array real general\n0 18446744073709551615\n".to_owned(),
            2,
            "0 rows and 18446744073709551615 columns",
        ),
        ("short", format!("{SYMMETRIC}2 2 3\n1 1 1\n2 2 1\n"), 4, "ends after 2 entries"),
        ("long", format!("{SYMMETRIC}2 2 2\n1 1 1\n2 2 1\n2 1 1\n"), 5, "after the last entry"),
        ("row", format!("{SYMMETRIC}2 2 2\n1 1 1\n3 2 1\n"), 4, "row 3 does not exist"),
        ("column", format!("{SYMMETRIC}2 2 2\n1 1 1\n2 0 1\n"), 4, "column 0 does not exist"),
        ("nan", format!("{SYMMETRIC}2 2 2\n1 1 NaN\n2 2 1\n"), 3, "the value `NaN`"),
        ("word", format!("{SYMMETRIC}2 2 2\n1 1 one\n2 2 1\n"), 3, "the value `one`"),
        ("three", format!("{SYMMETRIC}2 2 2\n1 1 1 1\n2 2 1\n"), 3, "is no entry"),
        ("twice", format!("{SYMMETRIC}2 2 3\n1 1 1\n2 1 1\n1 2 1\n"), 5, "given on line 4 already"),
    ];
    for (name, text, at, what) in faults {
        let (line, said) = complaint(name, &text);
        assert!(line == at && said.contains(what), "{name}: line {line}: {said}");
    }
}

#[test]
fn right_hand_side_must_fit() {
    let file =
        Scratch::new("rhs", "%%MatrixMarket matrix array real general\n3 2\n1\n2\n3\n4\n5\n6\n");
    let error = read_vector(&file.0, 3).unwrap_err();
    assert!(
        error.is_input() && error.to_string().contains("is 3 x 2; it must be 3 x 1"),
        "{error}"
    );
    let file = Scratch::new("rhs-sparse", &format!("{GENERAL}4 1 1\n4 1 7\n"));
    assert_eq!(read_vector(&file.0, 4).unwrap(), [0.0, 0.0, 0.0, 7.0]);
}

#[test]
fn missing_file_is_wrong_input() {
    let error = read_matrix(std::path::Path::new("nowhere.mtx")).unwrap_err();
    assert!(
        error.is_input() && error.to_string().starts_with("nowhere.mtx: cannot be read"),
        "{error}"
    );
}
