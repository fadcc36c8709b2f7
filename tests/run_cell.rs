//! A periodic cell through the program: what `check` says, what a run leaves, a packing that keeps
//! its cell.

mod program;

use program::{Folder, error};

const SCENE: &str = r#"title = "cell"
[cell]
edges = [[0.1, 0, 0], [0.02, 0.1, 0], [0, 0, 0.1]]
[particles]
cloud = { count = 150, spread = 0.2, porosity = 0.75 }
[dem]
[[stage]]
kind = "compact"
stress = 1e4
friction_angle = 5.0
[[stage]]
kind = "run"
name = "shear"
steps = 300
velocity_gradient = { xy = 2.0 }
cell_stress = { yy = 1e4 }
[output]
history_every = 100
vtk_every = 300
"#;

#[test]
fn a_cell_is_checked_run_and_written() {
    let folder = Folder::new("cell");
    folder.write("scene.toml", SCENE);
    let plan = folder.done(&["check", "scene.toml"]);
    // |b| = √(0.02² + 0.1²) m, at atan(0.1 / 0.02) to a.
    assert!(plan.contains("100 mm × 102 mm × 100 mm at 90°, 90°, 78.7°"), "{plan}");
    assert!(plan.contains("L_xy = 2/s, σ_yy at 10 kPa"), "{plan}");
    assert!(plan.contains("periodic cell") && !plan.contains("walls fixed"), "{plan}");

    folder.done(&["run", "scene.toml", "--out", "out"]);
    let summary = folder.json("out/summary.json");
    let shear = &summary["stages"][1]["run"]["cell"];
    let strain = shear["strain"][0][1].as_f64().unwrap();
    let time = summary["stages"][1]["model_time_s"].as_f64().unwrap();
    assert!((strain / (2.0 * time) - 1.0).abs() < 1e-12);
    let history = folder.read("out/history.csv");
    let header: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let last: Vec<&str> = history.lines().last().unwrap().split(',').collect();
    let value = |name: &str| -> f64 {
        last[header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("{name}"))]
            .parse()
            .unwrap()
    };
    // The reader of JSON may be off by the last bit.
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
    assert!(same(value("cell_strain_xy"), strain));
    assert!(same(value("cell_stress_yy_pa"), shear["stress_pa"][1][1].as_f64().unwrap()));
    assert_eq!(value("cell_a_m"), 0.1);
    assert!(same(value("cell_alpha_deg"), 90.0));
    // σ_yy of 300 steps under the servo.
    assert!(
        (value("cell_stress_yy_pa") / 1e4 - 1.0).abs() < 0.02,
        "{}",
        value("cell_stress_yy_pa")
    );
    assert!(value("cell_stress_xy_pa") < 0.0);
    for file in ["out/stress-shear.svg", "out/cell.pvd", "out/spheres.pvd"] {
        assert!(folder.0.join(file).exists(), "{file}");
    }

    folder.done(&["pack", "scene.toml", "--out", "packed"]);
    let name = std::fs::read_dir(folder.0.join("packed"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().is_some_and(|e| e == "txt"))
        .unwrap();
    let name = name.to_str().unwrap();
    assert!(std::fs::read_to_string(name).unwrap().contains("# cell 0.1 0.0 0.0 0.02 0.1 0.0 "));
    folder.done(&["permeability", name, "--json", "k.json"]);
    let k = folder.json("k.json");
    let of = |a: usize, b: usize| k["tensor_m2"][a][b].as_f64().unwrap();
    assert_eq!(k["axes"][1]["permeability_m2"].as_f64().unwrap(), of(1, 1));
    assert!(of(0, 0) > 0.0 && (of(0, 1) - of(1, 0)).abs() < 1e-9 * of(0, 0), "{k}");
    // A command that knows walls only says so, with what would be right.
    let refused = folder.dempfv(&["network", name]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(error(&refused).contains("periodic cell"), "{}", error(&refused));
}

/// A fluid in the cell: the plan names its gradient, the history its velocity, frames hold its pores.
#[test]
fn a_wet_cell_is_checked_run_and_written() {
    let folder = Folder::new("wet-cell");
    let fluid = "[fluid]\nviscosity = 1e-3\npressure_gradient = [-50.0, 0.0, 0.0]\n[dem]";
    let wet = SCENE.replace("[dem]", fluid).replace("cell_stress = { yy = 1e4 }", "").replace(
        "kind = \"run\"",
        "kind = \"permeability\"\naxis = \"x\"\n[[stage]]\nkind = \"run\"",
    );
    folder.write("scene.toml", &wet);
    let plan = folder.done(&["check", "scene.toml"]);
    assert!(plan.contains("mean gradient -50, 0, 0 Pa/m"), "{plan}");
    assert!(plan.contains("fluid forces on spheres, pressure gradient, energy by cause"), "{plan}");
    let said = folder.done(&["run", "scene.toml", "--out", "out"]);
    assert!(said.contains("k_x = "), "{said}");
    let summary = folder.json("out/summary.json");
    let test = &summary["stages"][1]["permeability"];
    assert_eq!(test["tensor_m2"][0][0], test["permeability_m2"]);
    let energy = &summary["energy"];
    assert!(energy["cell_work"].as_f64().is_some_and(|w| w != 0.0), "{energy}");
    let history = folder.read("out/history.csv");
    let header: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let last: Vec<&str> = history.lines().last().unwrap().split(',').collect();
    let at = header.iter().position(|h| *h == "cell_fluid_velocity_x_m_s").unwrap();
    // Darcy's: k/μ times the gradient, of a packing that has been sheared by some per mille since.
    let velocity: f64 = last[at].parse().unwrap();
    let expected = 50.0 * test["permeability_m2"].as_f64().unwrap() / 1e-3;
    assert!((velocity / expected - 1.0).abs() < 0.05, "{velocity} {expected}");
    assert!(folder.0.join("out/pores.pvd").exists());
}
