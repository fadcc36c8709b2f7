//! What the commands leave for programs to read.

mod program;

use program::{Folder, STAGES, error, packing, scene};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// Without `[fluid]` nothing is triangulated and nothing solved: no pores, no
/// unknowns, and not a nanosecond in any phase of the fluid.
#[test]
fn a_dry_run_touches_no_fluid() {
    let folder = Folder::new("dry");
    let text = scene("[[stage]]\nkind = \"run\"\nsteps = 100\n", "");
    let (start, end) = (text.find("[fluid]").unwrap(), text.find("[[stage]]").unwrap());
    folder.write("scene.toml", &format!("{}{}", &text[..start], &text[end..]));
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let summary = folder.json("out/summary.json");
    for key in ["pores", "unknowns", "remeshes"] {
        assert_eq!(summary[key], 0, "{key}");
    }
    assert_eq!(summary["solver"], Value::Null);
    let phases = summary["phases_ms"].as_object().unwrap();
    for phase in ["network", "analyze", "factor", "volume_rates", "solve", "fluid_forces"] {
        assert_eq!(number(&phases[phase]), 0.0, "{phase}");
    }
    for phase in ["contacts", "integration"] {
        assert!(number(&phases[phase]) > 0.0, "{phase}");
    }
    let effects = summary["effects"].as_array().unwrap();
    assert!(effects.iter().all(|e| !e.as_str().unwrap().contains("fluid")), "{effects:?}");
    let header = folder.read("out/history.csv");
    let rows: Vec<&str> = header.lines().collect();
    let at = rows[0].split(',').position(|c| c == "largest_pressure_pa").unwrap();
    assert!(rows[1..].iter().all(|r| r.split(',').nth(at) == Some("0.0")), "{}", rows[1]);
    assert!(!header.contains(",-0.0"), "{}", rows[1]);
}

/// Energy by cause: what was done is what was dissipated and is there, but for a residual that is
/// a small share of what was moved.
fn energy_is_balanced(energy: &Value) {
    let of = |key: &str| number(&energy[key]);
    let works = ["fluid_work", "wall_work", "external_work"].map(of);
    let losses = ["friction", "contact_damping", "rolling", "breakage", "local_damping"].map(of);
    let moved: f64 = works.iter().chain(&losses).map(|e| e.abs()).sum();
    assert!(moved > 0.0 && of("elastic") > 0.0, "{energy}");
    assert!(of("residual").abs() < 1e-4 * moved, "{energy}");
}

/// Every key that others rely on, with the kind of value that the contract
/// gives it, and what the numbers must add up to.
#[test]
fn a_summary_has_what_was_promised() {
    let folder = Folder::new("summary");
    folder.write("scene.toml", &scene(STAGES, ""));
    folder.done(&["run", "scene.toml", "--out", "out", "--threads", "2"]);
    let s = folder.json("out/summary.json");
    for key in ["particles", "pores", "unknowns", "contacts", "steps", "remeshes", "threads"] {
        assert!(s[key].as_u64().is_some_and(|n| n > 0), "{key}: {}", s[key]);
    }
    for key in ["model_time_s", "wall_s", "ms_per_step"] {
        assert!(number(&s[key]) > 0.0, "{key}");
    }
    assert_eq!((&s["particles"], &s["threads"]), (&120.into(), &2.into()));
    energy_is_balanced(&s["energy"]);
    assert_eq!((&s["solver"], &s["finished"]), (&"auto".into(), &true.into()));
    assert_eq!(s["solved_by"], "cholmod", "too small for the frontal solver");
    let stage = &s["stages"][0];
    assert_eq!((&stage["dt"], number(&stage["damping"])), (&"auto".into(), 0.2));
    assert!(s["unknowns"].as_u64() < s["pores"].as_u64());
    let versions = s["versions"].as_object().unwrap();
    for key in ["dempfv", "git", "suitesparse", "cholmod", "metis", "cgal", "blas"] {
        assert!(versions[key].as_str().is_some_and(|v| !v.is_empty()), "{key}");
    }
    let hash = s["state_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert!(s["effects"].as_array().unwrap().iter().all(Value::is_string));
    let phases: f64 = s["phases_ms"].as_object().unwrap().values().map(number).sum();
    assert!(phases > 0.0 && phases < 1e3 * number(&s["wall_s"]), "{phases} ms");
    let steps: u64 =
        s["stages"].as_array().unwrap().iter().map(|s| s["steps"].as_u64().unwrap()).sum();
    assert_eq!(Some(steps), s["steps"].as_u64());
    assert!(number(&s["largest_residual"]) < 1e-12);
    assert!(number(&s["largest_imbalance"]) < 1e-10);
    // A row every ten steps, and the last state.
    assert_eq!(folder.read("out/history.csv").lines().count() as u64, 1 + steps.div_ceil(10));
    // The same report where --json asks for it.
    let shown = folder.done(&["run", "scene.toml", "--out", "other", "--json", "-"]);
    let shown: Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(shown["state_hash"], s["state_hash"]);
}

/// The network as the contract describes it, of a packing with a sphere in the
/// lens of two others (number 1000): neighbours are mutual and share a facet,
/// conductances and pressures satisfy the balance, forces are internal.
#[test]
fn a_network_can_be_checked_by_its_reader() {
    let folder = Folder::new("network");
    let settled = std::fs::read_to_string(packing("oedometer-1000.txt")).unwrap();
    // Swallowed by the first sphere, whatever else is near.
    let first = settled.lines().find(|l| !l.starts_with('#')).unwrap();
    let sphere: Vec<f64> = first.split_whitespace().map(|w| w.parse().unwrap()).collect();
    let (x, r) = (sphere[0] + 0.3 * sphere[3], 0.1 * sphere[3]);
    folder.write("p.txt", &format!("{settled}\n{x} {} {} {r}\n", sphere[1], sphere[2]));
    let pressures = ["--pressure", "y_min=1", "y_max=0"];
    folder.done(&[&["network", "p.txt", "--json", "n.json"], &pressures[..]].concat());
    let n = folder.json("n.json");
    assert_eq!(n["hidden"], serde_json::json!([1000]));
    assert_eq!(n["force"].as_array().unwrap().len(), 1001);
    assert_eq!(numbers(&n["force"][1000]), [0.0; 3]);

    // A run knows it by the same number, though it keeps spheres in another order.
    let text = "[particles]\npacking = \"p.txt\"\n[dem]\ndt = 1e-9\n[fluid]\nviscosity = 1e-3\n\
                pressure = { y_max = 0 }\n[[stage]]\nkind = \"run\"\nsteps = 1\n";
    folder.write("scene.toml", text);
    folder.done(&["run", "scene.toml", "--out", "out"]);
    assert_eq!(folder.json("out/summary.json")["hidden"], n["hidden"]);

    let cells: Vec<Vec<String>> = n["cells"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c.as_array().unwrap().iter().map(|v| v.to_string().replace('"', "")).collect())
        .collect();
    let pores = cells.len();
    // 5,685 of the packing without the hidden sphere.
    assert_eq!(pores, 5685);
    let list = |key: &str| {
        let list = n[key].as_array().unwrap();
        assert_eq!(list.len(), pores, "{key}");
        list
    };
    let (volume, pressure) = (list("volume"), list("pressure"));
    let (center, imposed) = (list("center"), list("imposed"));
    let (neighbors, conductance) = (list("neighbors"), list("conductance"));
    assert!(center.iter().all(|c| numbers(c).len() == 3));
    let names = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];
    let mut net = 0.0;
    for i in 0..pores {
        assert_eq!(cells[i].len(), 4);
        for v in &cells[i] {
            assert!(names.contains(&v.as_str()) || v.parse::<u32>().is_ok_and(|s| s < 1000), "{v}");
        }
        for k in 0..4 {
            let g = number(&conductance[i][k]);
            let Some(j) = neighbors[i][k].as_u64().map(|j| j as usize) else {
                assert_eq!(g, 0.0, "pore {i}");
                continue;
            };
            let back = (0..4).find(|&b| neighbors[j][b].as_u64() == Some(i as u64)).unwrap();
            assert_eq!(number(&conductance[j][back]).to_bits(), g.to_bits());
            let facet = |cell: &[String], apex: usize| {
                let mut f: Vec<String> = cell.to_vec();
                f.remove(apex);
                f.sort();
                f
            };
            assert_eq!(facet(&cells[i], k), facet(&cells[j], back), "{i} {j}");
            if imposed[i] == true && imposed[j] == false {
                net += g * (number(&pressure[i]) - number(&pressure[j]));
            }
        }
        if imposed[i] == true {
            let p = number(&pressure[i]);
            assert!(p == 0.0 || p == 1.0);
        }
    }
    let flux = |wall: &str| number(&n["flux"][wall]);
    // What comes in goes out; nothing passes the closed walls.
    assert!((flux("y_min") + flux("y_max")).abs() < 1e-10 * flux("y_min"));
    assert!(net.abs() < 1e-10 * flux("y_min"), "{net}");
    assert!(["x_min", "x_max", "z_min", "z_max"].iter().all(|w| flux(w) == 0.0));
    let size: Vec<f64> = numbers(&n["bounds"]["max"])
        .iter()
        .zip(numbers(&n["bounds"]["min"]))
        .map(|(a, b)| a - b)
        .collect();
    let (area, height) = (size[0] * size[2], size[1]);
    let k = flux("y_min") * 1e-3 * height / area;
    assert!((number(&n["permeability_m2"]) / k - 1.0).abs() < 1e-12);
    let filled: f64 = volume.iter().map(number).sum();
    assert!((filled / (area * height) - 1.0).abs() < 1e-12);
    // Drag and pressure on spheres and walls are internal forces; spheres that
    // reach past a facet's edge leave 3e-8 of the force on the lower wall.
    let mut sum = [0.0; 3];
    let walls = names.iter().map(|w| &n["wall_force"][w]);
    for force in n["force"].as_array().unwrap().iter().chain(walls) {
        for (sum, f) in sum.iter_mut().zip(numbers(force)) {
            *sum += f;
        }
    }
    assert!(sum.iter().all(|f| f.abs() < 1e-6 * area), "{sum:?}");
    assert!((0.3..0.5).contains(&number(&n["porosity"])));
}

/// A network is shown, and written where it is asked for only; a large file is announced
/// with its size.
#[test]
fn a_network_is_written_where_it_is_asked_for() {
    let folder = Folder::new("network-files");
    let (small, large) = (packing("oedometer-1000.txt"), packing("oedometer-5000.txt"));
    let shown = folder.done(&["network", &small]);
    assert!(shown.contains("permeability") && !shown.contains("written"), "{shown}");
    assert!(folder.files().is_empty());

    folder.done(&["network", &small, "--out", "n"]);
    assert!(folder.json("n/network.json")["cells"].is_array());
    let again = folder.dempfv(&["network", &small, "--out", "n"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("--force"), "{}", error(&again));

    let quiet = folder.dempfv(&["network", &small, "--json", "small.json"]);
    assert_eq!(error(&quiet), "");
    let output = folder.dempfv(&["network", &large, "--json", "large.json"]);
    let told: f64 =
        error(&output).split_whitespace().find_map(|word| word.parse().ok()).expect("a number");
    assert!(error(&output).trim_end().ends_with("MB"), "{}", error(&output));
    let size = std::fs::metadata(folder.0.join("large.json")).unwrap().len() as f64;
    assert!((1e6 * told / size - 1.0).abs() < 0.1, "{told} MB, {size} bytes");
}

/// The options of `network` reach the flow: fluxes go with 1/viscosity, walls
/// that do not slip slow the fluid, YADE's clamp gives YADE's flux.
#[test]
fn network_options_reach_the_flow() {
    let folder = Folder::new("options");
    let file = packing("oedometer-1000.txt");
    let flux = |options: &[&str]| {
        let text = folder.done(&[&["network", &file, "--json", "-"], options].concat());
        number(&serde_json::from_str::<Value>(&text).unwrap()["flux"]["y_min"])
    };
    let plain = flux(&[]);
    assert_eq!(format!("{plain:.3e}"), "1.751e-7");
    assert!((flux(&["--viscosity", "2e-3"]) / plain - 0.5).abs() < 1e-9);
    assert!((flux(&["--pressure", "y_min=3", "y_max=1"]) / plain - 2.0).abs() < 1e-9);
    assert!(flux(&["--slip", "false"]) < plain);
    assert_eq!(format!("{:.3e}", flux(&["--clamp", "yade"])), "1.934e-7");
    for (options, what) in [
        (&["--viscosity", "0"][..], "positive"),
        (&["--clamp", "yode"], "none, relative, unlimited and yade"),
        (&["--pressure", "y_mid=1"], "y_mid"),
        (&["--pressure", "y_min=nan"], "finite"),
        (&["--solver", "mumps"], "cholmod"),
    ] {
        let output = folder.dempfv(&[&["network", &file, "--out", "out"], options].concat());
        assert_eq!(output.status.code(), Some(2), "{options:?}: {}", error(&output));
        assert!(error(&output).contains(what), "{options:?}: {}", error(&output));
        assert!(!folder.0.join("out").exists());
    }
}

/// Along each axis, with Kozeny-Carman beside it; a cubic lattice conducts
/// alike along all three.
#[test]
fn permeability_by_axis() {
    let folder = Folder::new("permeability");
    let file = packing("oedometer-1000.txt");
    let text = folder.done(&["permeability", &file, "--json", "-"]);
    let report: Value = serde_json::from_str(&text).unwrap();
    let kozeny = number(&report["kozeny_carman_m2"]);
    let axes = report["axes"].as_array().unwrap();
    assert_eq!(axes.iter().map(|a| a["axis"].as_str().unwrap()).collect::<String>(), "xyz");
    for axis in axes {
        let k = number(&axis["permeability_m2"]);
        assert!((0.5..2.0).contains(&(k / kozeny)), "{k:e} against {kozeny:e}");
        assert!(number(&axis["imbalance"]) < 1e-10);
    }
    let lattice: String =
        (0..64).map(|i| format!("{}.5 {}.5 {}.5 0.5\n", i % 4, i / 4 % 4, i / 16)).collect();
    folder.write("cubic.txt", &lattice);
    let text = folder.done(&["permeability", "cubic.txt", "--json", "-"]);
    let report: Value = serde_json::from_str(&text).unwrap();
    let k: Vec<f64> =
        report["axes"].as_array().unwrap().iter().map(|a| number(&a["permeability_m2"])).collect();
    assert!(k.iter().all(|v| (v / k[0] - 1.0).abs() < 0.01), "{k:?}");
}

/// What `pack` writes loads again, in its box, and is a settled packing: at
/// rest under fixed walls it stays at its stress.
#[test]
fn a_packing_loads_again() {
    let folder = Folder::new("pack");
    let options = ["--count", "150", "--edge", "0.1", "--stress", "2e4", "--seed", "5"];
    folder.done(&[&["pack", "--out", "a", "--json", "a.json"], &options[..]].concat());
    folder.done(&[&["pack", "--out", "b", "--threads", "1"], &options[..]].concat());
    assert_eq!(folder.read("a/packing.txt"), folder.read("b/packing.txt"));
    let report = folder.json("a.json");
    assert!((number(&report["stress_pa"]) / 2e4 - 1.0).abs() < 1e-3);
    folder.write(
        "scene.toml",
        r#"
[particles]
packing = "a/packing.txt"
[dem]
[[stage]]
kind = "run"
steps = 200
"#,
    );
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let summary = folder.json("out/summary.json");
    assert_eq!(summary["particles"], 150);
    let stress = numbers(&summary["stages"][0]["run"]["wall_stress_pa"]);
    // Friction, low while packing, is the scene's own now: the rest of the
    // unbalanced force may settle by a percent or so.
    let mean = stress.iter().sum::<f64>() / 6.0;
    assert!((mean / 2e4 - 1.0).abs() < 0.03, "{stress:?}");
    // A scene's compact stage is the other way to the same.
    folder.write("compact.toml", &scene(STAGES, ""));
    folder.done(&["pack", "compact.toml", "--out", "c"]);
    let packed = folder.read("c/packing.txt");
    assert_eq!(packed.lines().filter(|l| !l.starts_with('#')).count(), 120);
    let output = folder.dempfv(&["pack", "compact.toml", "--out", "c"]);
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
}

/// `check` counts the pores of a packing file as `run` then has them; of a
/// cloud it estimates them.
#[test]
fn check_counts_what_a_run_has() {
    let folder = Folder::new("check");
    let file = packing("oedometer-1000.txt");
    folder.write(
        "scene.toml",
        &format!(
            r#"
[particles]
packing = "{file}"
[dem]
dt = 1e-6
[fluid]
viscosity = 1e-3
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
steps = 1
"#
        ),
    );
    folder.done(&["check", "scene.toml", "--json", "plan.json"]);
    let estimate = &folder.json("plan.json")["estimate"];
    assert_eq!(estimate["counted"], true);
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let summary = folder.json("out/summary.json");
    assert_eq!(estimate["pores"], summary["pores"]);
    assert_eq!(estimate["unknowns"], summary["unknowns"]);
    // L has at least an entry for each of the matrix: the diagonal, and nearly
    // two throats an unknown.
    assert!(number(&estimate["factor_entries"]) > 2.5 * number(&estimate["unknowns"]));
    folder.write("cloud.toml", &scene(STAGES, ""));
    folder.done(&["check", "cloud.toml", "--json", "cloud.json"]);
    assert_eq!(folder.json("cloud.json")["estimate"]["counted"], false);
}

/// `check` tells all three bounds of the time step, which one rules and where
/// the fastest viscous mode is; the history has those that a run goes by. The
/// viscous bound of this packing is 2 / (199.70 /s) (by ARPACK, see the tests
/// of the library), over 1.2 for the damping.
#[test]
fn check_and_history_tell_what_bounds_the_time_step() {
    let folder = Folder::new("time-step");
    let file = packing("oedometer-1000.txt");
    folder.write(
        "scene.toml",
        &format!(
            r#"
[particles]
packing = "{file}"
[dem]
[fluid]
viscosity = 1e-3
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
steps = 10
"#
        ),
    );
    let shown = folder.done(&["check", "scene.toml"]);
    for text in
        ["the contacts' stiffness", "(Δt_MK)", "2/λ_max", "(Δt_MV)", "safe side", "spheres "]
    {
        assert!(shown.contains(text), "no {text} in\n{shown}");
    }
    folder.done(&["check", "scene.toml", "--json", "plan.json"]);
    let plan = folder.json("plan.json");
    let bounds = &plan["stability"]["bounds"];
    assert_eq!(bounds, &plan["estimate"]["bounds"]);
    let exact = 2.0 / (1.2 * 199.7046);
    let viscous = number(&bounds["viscous"]);
    assert!(viscous > 0.97 * exact && viscous < exact, "{viscous} against {exact}");
    // 2 π 2600 (2 · 0.850 mm)² / 8 for the smallest sphere.
    assert!((number(&bounds["viscous_estimate"]) / 5.917e-3 - 1.0).abs() < 1e-3);
    assert_eq!(plan["stability"]["rule"], "contacts");
    assert!(number(&plan["stability"]["carriers"][0][1]) > 0.05);

    folder.done(&["run", "scene.toml", "--out", "out"]);
    let history = folder.read("out/history.csv");
    let mut lines = history.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row: Vec<&str> = lines.next().unwrap().split(',').collect();
    let value = |name: &str| -> f64 {
        row[header.iter().position(|c| *c == name).unwrap()].parse().unwrap()
    };
    assert!((value("dt_contact_s") / number(&bounds["contact"]) - 1.0).abs() < 1e-9);
    // Too slow to matter beside the contacts, so it is left rough.
    assert!((0.5..1.01).contains(&(value("dt_viscous_s") / exact)));
    assert!(value("dt_s") < 0.8 * value("dt_contact_s"));
    assert!(value("dt_s") > 0.79 * value("dt_contact_s"));
}

/// Two walls that impose different pressures meet in the pores of an edge: a contradiction that
/// the summary names; a wall that imposes a pressure beside one that lets nothing through is none.
#[test]
fn walls_of_different_pressures_are_warned_of() {
    let folder = Folder::new("contested");
    let text = |pressure: &str| {
        format!(
            "[particles]\npacking = \"{}\"\n[dem]\n[fluid]\nviscosity = 1e-3\npressure = {{ {pressure} }}\n\
             [[stage]]\nkind = \"run\"\nsteps = 1\n[output]\npictures = false\n",
            packing("oedometer-1000.txt")
        )
    };
    for (pressure, warned) in [("x_min = 1.0, y_min = 2.0", true), ("x_min = 1.0", false)] {
        folder.write("scene.toml", &text(pressure));
        folder.done(&["run", "scene.toml", "--out", "out", "--force"]);
        let summary = folder.json("out/summary.json");
        let warnings = summary["warnings"].as_array().unwrap();
        let says =
            |w: &Value| w.as_str().unwrap().contains("pores touch walls of different pressures");
        assert_eq!(warnings.iter().any(says), warned, "{warnings:?}");
    }
}
