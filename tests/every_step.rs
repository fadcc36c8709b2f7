//! `dempfv every-step` on a small packing: its page has what it measured, and a network that
//! is renewed more often is closer to one that is renewed at every step.

mod program;

use program::{Folder, error};

#[test]
fn errors_grow_with_the_remesh_interval() {
    let folder = Folder::new("every-step");
    folder.done(&["pack", "--count", "60", "--edge", "0.009", "--stress", "1e3", "--out", "pack"]);
    let said = folder.done(&["every-step", "pack/packing.txt", "--out", "e"]);
    assert!(said.contains("every-step.md"), "{said}");
    let page = folder.read("e/every-step.md");
    assert!(page.contains("## 60 spheres"), "{page}");
    assert!(folder.0.join("e/every-step/error-60.png").is_file());

    let points = folder.read("e/every-step/points-60.csv");
    let error_of = |start: &str| -> f64 {
        let row = points.lines().find(|line| line.starts_with(start)).unwrap();
        row.split(',').nth_back(1).unwrap().parse().unwrap()
    };
    assert_eq!(points.lines().count(), 1 + 2 * 5, "{points}");
    for update in ["remesh", "every step"] {
        let often = error_of(&format!("20,{update},"));
        let seldom = error_of(&format!("2000,{update},"));
        assert!(0.0 < often && often < seldom, "{update}: {often}, {seldom}");
    }
    // What is there is not overwritten.
    let again = folder.dempfv(&["every-step", "pack/packing.txt", "--out", "e"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));
}
