//! `dempfv accuracy` on a small scene with a short window: every setting has its error and its time, the
//! page needs nothing beside itself, a chosen scene is one, and a sweep that was stopped goes on.

mod program;

use program::{Folder, error};

const PACKING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/packings/oedometer-1000.txt");

/// A packing in water that is pressed from above.
fn scene(stage: &str) -> String {
    format!(
        "[particles]\npacking = {PACKING:?}\n[dem]\n\
         [fluid]\nviscosity = 1e-3\nbulk_modulus = 1e7\npressure = {{ y_max = 0.0, y_min = 0.0 }}\n\
         {stage}"
    )
}

const RUN: &str = "[[stage]]\nkind = \"run\"\nname = \"press\"\nsteps = 400\n\
                   walls = { y_max = { velocity = -0.01 } }\n";

#[test]
fn settings_have_errors_and_times() {
    let folder = Folder::new("accuracy");
    folder.write("a.toml", &scene(RUN));
    let words = [
        "accuracy",
        "a.toml",
        "--quick",
        "--seconds",
        "0.2",
        "--target",
        "0.05",
        "--out",
        "a",
        "--json",
        "-",
    ];
    let said = folder.done(&words);
    let report: serde_json::Value = serde_json::from_str(&said).unwrap();
    let points = report["points"].as_array().unwrap();
    let knobs: Vec<&str> = points.iter().map(|p| p["knob"].as_str().unwrap()).collect();
    for knob in
        ["scene", "remesh interval", "update", "solver", "tolerance", "time step", "effects"]
    {
        assert!(knobs.contains(&knob), "{knob} of {knobs:?}");
    }
    for point in points {
        assert!(point["failed"].is_null(), "{point}");
        assert!(point["seconds"].as_f64().unwrap() > 0.0, "{point}");
        assert!(point["error"].as_f64().unwrap() < 2.0 && point["setting"].is_string(), "{point}");
    }
    // Coarser steps are worse than the finest, and a fluid as stiff as water is no soft one.
    let own = |setting: &str| {
        let found = points.iter().find(|p| p["setting"].as_str().unwrap().starts_with(setting));
        found.unwrap_or_else(|| panic!("{setting}"))["own"]["pressure"].as_f64().unwrap()
    };
    assert!(own("dt = 0.8 ") > 1e-3 && own("without bulk_modulus") > 1e-3);
    assert!(own("update = \"every step\", tolerance = 1e-4") < 1e-2);

    let chosen = &report["chosen"][0];
    assert_eq!(chosen["target"], 0.05);
    assert_eq!(chosen["met"], chosen["point"]["error"].as_f64().unwrap() <= 0.05);
    assert!(chosen["elsewhere"].as_f64().unwrap() < 1.0, "{chosen}");
    folder.done(&["check", "a/chosen.toml"]);

    assert_eq!(folder.read("a/accuracy.csv").lines().count(), points.len() + 2);
    let page = folder.read("a/accuracy.html");
    assert!(page.contains("<svg") && page.contains("remesh_interval = 1"), "{page}");
    let linked = page.replace("http://www.w3.org/2000/svg", "").contains("http");
    assert!(!linked, "the page needs the network");

    // What is there stays.
    let again = folder.dempfv(&words);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));
    // A sweep that was stopped before its end goes on with the runs that it has: the same times.
    let table = folder.read("a/accuracy.csv");
    std::fs::remove_file(folder.0.join("a/accuracy.json")).unwrap();
    folder.done(&words);
    assert_eq!(folder.read("a/accuracy.csv"), table);
}

/// A dry stage of so many steps, with a wall that is driven: all runs see the same time, errors are of
/// what is not prescribed, and a packing beside the scene is found from wherever its copy lies.
#[test]
fn steps_are_a_time_and_driven_walls_no_answer() {
    let folder = Folder::new("accuracy-dry");
    std::fs::create_dir(folder.0.join("s")).unwrap();
    std::fs::copy(PACKING, folder.0.join("s/p.txt")).unwrap();
    let stage = RUN.replace("400", "60").replace("-0.01", "-1.0");
    folder.write("s/a.toml", &format!("[particles]\npacking = \"p.txt\"\n[dem]\n{stage}"));
    let words = ["accuracy", "s/a.toml", "--quick", "--target", "0.5", "--out", "a", "--json", "-"];
    let report: serde_json::Value = serde_json::from_str(&folder.done(&words)).unwrap();
    for point in report["points"].as_array().unwrap() {
        assert!(point["failed"].is_null() && point["error"].is_f64(), "{point}");
    }
    let chosen = &report["chosen"][0]["point"];
    assert!(chosen["errors"]["displacement"].as_f64().unwrap() < 1e-9, "{chosen}");
    assert!(chosen["error"].as_f64().unwrap() <= 0.5, "{chosen}");
    // Driven walls are where they are; what steps do shows in stresses.
    let coarse = report["points"].as_array().unwrap().iter().map(|p| p["error"].as_f64().unwrap());
    assert!(coarse.fold(0.0, f64::max) > 1e-6, "{report}");
    folder.done(&["check", "a/chosen.toml"]);
}

/// What only the background knows of goes with it.
#[test]
fn networks_that_are_taken_when_ready_are_no_obstacle() {
    let folder = Folder::new("accuracy-ready");
    let text =
        scene(RUN).replace("bulk_modulus = 1e7", "remesh = \"background\"\nswap = \"when ready\"");
    folder.write("a.toml", &text);
    let words = ["accuracy", "a.toml", "--quick", "--seconds", "0.2", "--out", "a", "--json", "-"];
    let report: serde_json::Value = serde_json::from_str(&folder.done(&words)).unwrap();
    for point in report["points"].as_array().unwrap() {
        assert!(point["failed"].is_null(), "{point}");
    }
}

/// YADE's bounds of conductances hold 10 % of the permeability of millimetre grains.
#[test]
fn a_permeability_has_an_accuracy() {
    let folder = Folder::new("accuracy-permeability");
    folder.write("p.toml", &scene("[[stage]]\nkind = \"permeability\"\naxis = \"y\"\n"));
    let said =
        folder.done(&["accuracy", "p.toml", "--target", "0.01", "--out", "p", "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&said).unwrap();
    let points = report["points"].as_array().unwrap();
    let error = |setting: &str| {
        let found = points.iter().find(|p| p["setting"] == setting);
        found.unwrap_or_else(|| panic!("{setting}: {said}"))["error"].as_f64().unwrap()
    };
    assert_eq!(error("clamp = \"none\""), 0.0);
    let yade = error("clamp = \"yade\"");
    assert!((0.01..0.5).contains(&yade), "{yade}");
    assert!(error("slip_walls = false") > 0.01 && error("as it is") < 1e-9);
    assert!(report["chosen"][0]["met"] == true && report["chosen"][0]["elsewhere"].is_null());
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = Folder::new("accuracy-refused");
    folder.write("p.toml", &scene("[[stage]]\nkind = \"flow\"\ntime = 1.0\n"));
    folder.write("a.toml", &scene(RUN));
    for (words, what) in [
        (vec!["accuracy", "p.toml"], "no stage of this scene steps or measures a permeability"),
        (vec!["accuracy", "a.toml", "--target", "2"], "--target is 2"),
        (vec!["accuracy", "a.toml", "--seconds", "0"], "--seconds is 0"),
        (vec!["accuracy", "b.toml"], "b.toml"),
    ] {
        let output = folder.dempfv(&words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", error(&output));
        assert!(error(&output).contains(what), "{words:?}: {}", error(&output));
    }
    assert!(!folder.0.join("out").exists());
}

/// A run that keeps to an error states it, with what it has chosen; a sweep sets the statement beside the
/// true error, which is within a factor of 4 (of a short window, in which little was looked at).
#[test]
fn a_run_states_its_error() {
    let folder = Folder::new("accuracy-kept");
    let drained = scene(RUN).replace("bulk_modulus = 1e7\n", "");
    folder.write("k.toml", &format!("{drained}[accuracy]\ntarget = 0.05\n"));
    folder.done(&["run", "k.toml", "--out", "k"]);
    let summary: serde_json::Value = serde_json::from_str(&folder.read("k/summary.json")).unwrap();
    let stated = |key: &str| summary["accuracy"][key].as_f64().unwrap();
    assert_eq!(stated("target"), 0.05);
    let parts = ["network", "time_step", "solver"].map(|p| stated(&format!("estimated_{p}_error")));
    let sum = parts.iter().map(|p| p * p).sum::<f64>().sqrt();
    assert!((sum - stated("estimated_error")).abs() < 1e-12 && sum > 0.0 && sum < 0.1, "{parts:?}");
    let history = folder.read("k/history.csv");
    for column in ["time_step_share", "remesh_strain", "estimated_error"] {
        assert!(history.lines().next().unwrap().contains(column), "{column}");
    }
    folder.write("f.toml", &drained);
    let words = ["accuracy", "f.toml", "--quick", "--seconds", "2", "--out", "f", "--json", "-"];
    let report: serde_json::Value = serde_json::from_str(&folder.done(&words)).unwrap();
    let points = report["points"].as_array().unwrap();
    let kept: Vec<_> = points.iter().filter(|p| p["knob"] == "error control").collect();
    assert!(kept.len() >= 2, "{points:?}");
    for point in kept {
        let [estimate, error] = ["estimate", "error"].map(|key| point[key].as_f64().unwrap());
        assert!(estimate > 0.25 * error && estimate < 4.0 * error, "{point}");
    }
}
