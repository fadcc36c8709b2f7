//! `dempfv representative-volume` on small packings: seeds scatter, walls matter less in larger ones, and a
//! series that was stopped goes on.

mod program;

use program::{Folder, error};
use serde_json::Value;

const WORDS: [&str; 9] =
    ["representative-volume", "--spheres", "800,100", "--seeds", "3", "--out", "v", "--json", "-"];

#[test]
fn larger_specimens_feel_their_walls_less() {
    let folder = Folder::new("representative-volume");
    let report: Value = serde_json::from_str(&folder.done(&WORDS)).unwrap();
    let sizes = report["sizes"].as_array().unwrap();
    let of = |size: usize, quantity: &str, key: &str| {
        let all = sizes[size]["statistics"].as_array().unwrap();
        let found = all.iter().find(|s| s["quantity"] == quantity);
        found.unwrap_or_else(|| panic!("{quantity}: {report}"))[key].as_f64().unwrap()
    };
    assert_eq!((&sizes[0]["spheres"], &sizes[1]["spheres"]), (&100.into(), &800.into()));
    for size in 0..2 {
        // Kozeny and Carman with the porosity and the constant 5 of packings of spheres.
        let porosity = of(size, "porosity", "mean");
        let kozeny = porosity.powi(3) / (180.0 * (1.0 - porosity).powi(2));
        let ratio = of(size, "permeability", "mean") / kozeny;
        assert!((0.6..1.7).contains(&ratio), "{ratio}");
        for quantity in ["permeability", "permeability_along_load", "modulus_pa", "porosity"] {
            let [mean, deviation, error] =
                ["mean", "standard_deviation", "standard_error"].map(|key| of(size, quantity, key));
            assert!(0.0 < deviation && deviation < 0.3 * mean, "{quantity}: {deviation} of {mean}");
            assert!((error * 3f64.sqrt() / deviation - 1.0).abs() < 1e-9, "{quantity}");
        }
    }
    // Spheres find less room at walls: a box of eight times the spheres is denser, stiffer and tighter.
    assert!(of(1, "porosity", "mean") < of(0, "porosity", "mean") - 0.01);
    assert!(of(1, "modulus_pa", "mean") > 1.05 * of(0, "modulus_pa", "mean"));
    assert!(of(1, "permeability", "mean") < 0.9 * of(0, "permeability", "mean"));
    assert!(of(1, "core_permeability", "mean") < of(1, "permeability", "mean"));

    let page = folder.read("v/representative-volume.md");
    assert!(page.contains("One specimen of 100 spheres") && page.contains("| 800 | 3 |"), "{page}");
    assert_eq!(folder.read("v/representative-volume.csv").lines().count(), 1 + 2 * 5);
    for picture in ["representative-volume.svg", "representative-volume-spread.png"] {
        assert!(folder.0.join("v").join(picture).is_file(), "{picture}");
    }
    // What is there stays.
    let again = folder.dempfv(&WORDS);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));
    // A series that was stopped before its end has the specimens that are done: their times as well.
    let table = folder.read("v/representative-volume.json");
    std::fs::remove_file(folder.0.join("v/representative-volume.json")).unwrap();
    std::fs::remove_file(folder.0.join("v/points/100-2.json")).unwrap();
    folder.done(&WORDS);
    let seconds = |text: &str| -> Vec<f64> {
        let report: Value = serde_json::from_str(text).unwrap();
        let sizes = report["sizes"].as_array().unwrap().iter();
        let all = sizes.flat_map(|size| size["specimens"].as_array().unwrap().clone());
        all.map(|specimen| specimen["seconds"].as_f64().unwrap()).collect()
    };
    let (before, after) = (seconds(&table), seconds(&folder.read("v/representative-volume.json")));
    let same: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a == b).collect();
    assert_eq!(same, [true, false, true, true, true, true]);
}

#[test]
fn what_is_no_series_is_refused() {
    let folder = Folder::new("representative-volume-refused");
    for (words, what) in [
        (["--spheres", "200,200"], "--spheres has 200 twice"),
        (["--spheres", "20"], "20"),
        (["--seeds", "1"], "1"),
    ] {
        let output = folder.dempfv(&[&["representative-volume"], &words[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", error(&output));
        assert!(error(&output).contains(what), "{words:?}: {}", error(&output));
    }
    assert!(folder.files().is_empty());
}
