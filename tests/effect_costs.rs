//! `dempfv effect-costs` on a small packing: every scene of it runs, and its page and table say of each
//! what it takes and adds.

mod program;

use program::{Folder, error};

const PACKING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/packings/oedometer-1000.txt");

#[test]
fn every_effect_has_a_cost() {
    let folder = Folder::new("effect-costs");
    let words = ["effect-costs", PACKING, "--turns", "1", "--out", "e"];
    let said = folder.done(&words);
    assert!(said.contains("JKR adhesion"), "{said}");
    let page = folder.read("e/effect-costs.md");
    assert!(page.contains("| fluid compressibility | pore flow |"), "{page}");
    let table = folder.read("e/effect-costs.csv");
    for row in table.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let [effect, over, adds, step] = cells[..] else { panic!("{row}") };
        assert!(step.parse::<f64>().unwrap() > 0.0, "{row}");
        assert_eq!(over.is_empty(), effect == "contacts", "{row}");
        assert_eq!(adds.parse::<f64>().is_err(), over.is_empty(), "{row}");
    }
    // What is there is not overwritten.
    let again = folder.dempfv(&words);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));
}
