//! Scenes with a periodic cell: how they are read and checked, and that they run.

use std::path::Path;

use dempfv::dem::CellControl;
use dempfv::io::checkpoint;
use dempfv::io::packing::{self, Packing};
use dempfv::scene::{CellShape, Plan, StageKind};
use dempfv::simulation::{Outcome, Simulation, SimulationState};
use dempfv::{Cell, Vec3};

const SCENE: &str = r#"
title = "cell"
[cell]
edges = [[0.1, 0, 0], [0.02, 0.1, 0], [0, 0, 0.1]]
[particles]
cloud = { count = 200, spread = 0.2, porosity = 0.75 }
[dem]
[[stage]]
kind = "compact"
stress = 1e4
[[stage]]
kind = "run"
name = "shear"
steps = 400
velocity_gradient = { xy = 2.0, zx = -0.5 }
cell_stress = { yy = 1e4, zz = 2e4 }
"#;

fn plan() -> Plan {
    Plan::from_toml(SCENE, None).unwrap()
}

#[test]
fn a_cell_is_read_and_written() {
    let plan = plan();
    let Some(CellShape::Edges(cell)) = plan.cell else { panic!("{:?}", plan.cell) };
    assert_eq!(cell.edges()[1], Vec3::new(0.02, 0.1, 0.0));
    assert_eq!(plan.bounds, None);
    let StageKind::Run(run) = &plan.stages[1].kind else { panic!("no run") };
    assert_eq!(run.cell[0][1], CellControl::Rate(2.0));
    assert_eq!(run.cell[2][0], CellControl::Rate(-0.5));
    assert_eq!(run.cell[1][1], CellControl::Stress(1e4));
    assert_eq!(run.cell[0][0], CellControl::Rate(0.0));
    assert_eq!(Plan::from_toml(&plan.to_toml(), None).unwrap(), plan);
    assert_eq!(plan.validate(), Ok(()));
    let on = plan.effects_on();
    assert!(on.contains(&"periodic cell") && on.contains(&"servo cell"), "{on:?}");
    // 200 spheres of a mean volume that leaves a porosity of 0.75 in 1e-3 m³.
    let dempfv::scene::ParticleSource::Cloud(cloud) = &plan.particles.source else { panic!() };
    assert!((200.0 * cloud.sizes.mean_volume() / 1e-3 - 0.25).abs() < 1e-12);
}

/// What goes against a cell is told with its line and what would be right.
#[test]
fn what_a_cell_has_no_room_for_is_refused() {
    let cell = "edges = [[0.1, 0, 0], [0.02, 0.1, 0], [0, 0, 0.1]]";
    for (old, new, line, words) in [
        ("[cell]", "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[cell]", 3, "a cell has no walls"),
        ("[dem]", "[walls]\nyoung = 1.0\n[dem]", 7, "a cell has no walls"),
        // As the walls would be that a scene does not name.
        ("[dem]", "[walls]\nyoung = 1e6\n[dem]", 7, "a cell has no walls"),
        ("[dem]", "[walls]\n[dem]", 7, "a cell has no walls"),
        ("zz = 2e4 }", "zz = -1.0 }", 11, "the tension `cell_stress` zz = -1e0 Pa"),
        ("zz = 2e4 }", "zz = -1E+0_0 }", 11, "give 0 or more"),
        ("zz = 2e4 }", "zz = 1e300 }", 11, "below `young` in [particles]"),
        ("cell_stress = { yy = 1e4, zz = 2e4 }", "cell_stress = {}", 16, "names no component"),
        ("cell_stress = { yy = 1e4, zz = 2e4 }", "cell_stress = -1.0", 16, "give a table with"),
        ("velocity_gradient = { xy = 2.0, zx = -0.5 }", "velocity_gradient = {}", 15, "names no"),
        ("[dem]", "[dem]\ngravity = [0, 0, -9.81]", 7, "nothing holds the spheres up"),
        ("steps = 400", "steps = 400\nwalls = { y_max = { stress = 1 } }", 11, "move the cell"),
        ("zz = 2e4", "xy = 2e4", 16, "keep one of the two"),
        ("zz = 2e4", "xz = 2e4, zx = 1e4", 16, "velocity gradient"),
        ("zz = 2e4", "xw = 2e4", 16, "unknown component `xw`"),
        (cell, "edges = [[1, 0, 0], [0, 0, 1], [0, 1, 0]]", 4, "let two change places"),
        (cell, "edges = [[1, 0, 0], [0, 1, 0]]", 4, "has 2 edges"),
        (cell, "size = [1, 0, 1]", 4, "lengths above 0"),
        (cell, "size = [1, 1, 1]\nedges = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", 5, "keep `size` or"),
        (cell, "", 6, "needs a box to fill"),
        ("count = 200, spread = 0.2, porosity = 0.75", "count = 2, radius = 0.03", 3, "meet twice"),
        ("steps = 400", "until = { strain = 0.1, axis = \"x\" }", 11, "do not move"),
        (
            "kind = \"compact\"\nstress = 1e4",
            "kind = \"cycle\"\nwall = \"y_max\"\nfrom = 1\nto = 2",
            8,
            "needs walls",
        ),
    ] {
        assert!(SCENE.contains(old), "{old}");
        let error = Plan::from_toml(&SCENE.replacen(old, new, 1), None).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(words), "{new}: {text}");
        assert_eq!(error.line, Some(line), "{new}: {text}");
    }
    let walls =
        SCENE.replace("[cell]", "[box]").replace(cell, "min = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]");
    let error = Plan::from_toml(&walls, None).unwrap_err().to_string();
    assert!(error.contains("moves a periodic cell, but there is none"), "{error}");
}

/// What a fluid in a cell has no place for, or could not follow.
#[test]
fn what_a_fluid_in_a_cell_cannot_be_is_refused() {
    let wet = SCENE.replace("[dem]", "[fluid]\nviscosity = 1e-3\nbulk_modulus = 2e9\n[dem]");
    Plan::from_toml(&wet, None).unwrap();
    for (old, new, line, words) in [
        ("bulk_modulus = 2e9", "pressure = { y_max = 0.0 }", 7, "drives the flow in a cell"),
        (
            "bulk_modulus = 2e9",
            "imposed = [{ center = [0, 0, 0], radius = 0.1, pressure = 1 }]",
            7,
            "drives the flow in a cell",
        ),
        (
            "bulk_modulus = 2e9",
            "sources = [{ center = [0, 0, 0], radius = 0.1, rate = 1 }]",
            7,
            "whose fluid cannot leave",
        ),
        ("bulk_modulus = 2e9", "slip_walls = false", 7, "a cell has no walls"),
        ("bulk_modulus = 2e9", "sealed_pores = \"drained\"", 7, "all pores of a cell are"),
        ("bulk_modulus = 2e9", "update = \"every step\"", 7, "a smaller `remesh_interval`"),
        ("2e9", "2e9\ndensity = 1e3", 7, "nothing has weight"),
        ("bulk_modulus = 2e9\n", "", 13, "asks for `cell_stress` yy, for which the cell changes"),
        ("2e9", "2e9\npressure_gradient = [1, 0]", 10, "three numbers"),
    ] {
        assert!(wet.contains(old), "{old}");
        let error = Plan::from_toml(&wet.replacen(old, new, 1), None).unwrap_err();
        assert!(error.to_string().contains(words), "{new}: {error}");
        assert_eq!(error.line, Some(line), "{new}: {error}");
    }
    let rates = wet
        .replace("bulk_modulus = 2e9\n", "")
        .replace("cell_stress = { yy = 1e4, zz = 2e4 }", "")
        .replace("{ xy = 2.0, ", "{ xx = 0.3, yy = -0.1, zz = -0.2, xy = 2.0, ");
    Plan::from_toml(&rates, None).unwrap();
    let error = Plan::from_toml(&rates.replace("zz = -0.2", "zz = -0.21"), None).unwrap_err();
    assert!(error.to_string().contains("rates whose sum is 0"), "{error}");
    let walls = r#"
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = { count = 10, radius = 0.01 }
        [fluid]
        viscosity = 1.0
        pressure_gradient = [1, 0, 0]
        [[stage]]
        kind = "permeability"
        axis = "x""#;
    let error = Plan::from_toml(walls, None).unwrap_err().to_string();
    assert!(error.contains("but there are walls"), "{error}");
}

/// A cell that a step would flatten is stopped at the first step, with the bound; a servo that cannot
/// reach its stress is told.
#[test]
fn what_a_cell_cannot_do_is_told() {
    let fast = SCENE.replace("xy = 2.0", "xy = 1e9");
    let mut simulation = Simulation::new(Plan::from_toml(&fast, None).unwrap()).unwrap();
    let error = loop {
        match simulation.advance() {
            Ok(true) => {}
            Ok(false) => panic!("no error"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(simulation.step() > 0 && simulation.stage_steps() == 0);
    assert!(error.contains("L_xy = 1e9 /s") && error.contains("at most 0.1"), "{error}");

    // Twenty steps are too few for ten times the stress.
    let missed = SCENE.replace("zz = 2e4", "zz = 1e5").replace("steps = 400", "steps = 20");
    let mut simulation = Simulation::new(Plan::from_toml(&missed, None).unwrap()).unwrap();
    while simulation.advance().unwrap() {}
    let warnings: Vec<String> = simulation.warnings();
    let told = |words: &str| warnings.iter().any(|w| w.contains(words));
    assert!(told("the cell was asked for a stress zz of 1.0000e5 Pa and got"), "{warnings:?}");
    let slow = SCENE
        .replace("xy = 2.0, zx = -0.5", "xy = 0.02, zx = -0.005")
        .replace("steps = 400", "steps = 2000");
    let mut simulation = Simulation::new(Plan::from_toml(&slow, None).unwrap()).unwrap();
    while simulation.advance().unwrap() {}
    assert_eq!(simulation.warnings(), Vec::<String>::new());
}

/// The same with a state from the middle of each stage: the same bits, and the outcome tells what
/// the cell has come to.
#[test]
fn a_scene_runs_and_restarts() {
    let mut straight = Simulation::new(plan()).unwrap();
    let folder = std::env::temp_dir().join(format!("dempfv-scene-cell-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("state");
    let mut states = vec![];
    while straight.advance().unwrap() {
        let in_shear = straight.stage().is_some_and(|s| s.name == "shear");
        if straight.step() == 100 || (in_shear && straight.stage_steps() == 150) {
            checkpoint::save(&path, &straight.state()).unwrap();
            states.push(checkpoint::load::<SimulationState>(&path).unwrap());
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(states.len(), 2);
    for state in states {
        let mut again = Simulation::restart(plan(), state.clone()).unwrap();
        while again.advance().unwrap() {}
        assert_eq!(again.state_hash(), straight.state_hash());
        assert_eq!(again.outcomes(), straight.outcomes());
        let other = Plan::from_toml(&SCENE.replace("0.02, 0.1", "0.01, 0.1"), None).unwrap();
        let error = Simulation::restart(other, state).err().unwrap().to_string();
        assert!(error.contains("`edges` in [cell]"), "{error}");
    }
    let Outcome::Run(path) = &straight.outcomes()[1].outcome else { panic!("no run") };
    let end = path.cell.as_ref().unwrap();
    let seconds = straight.outcomes()[1].model_time_s;
    assert!((end.strain[0][1] / (2.0 * seconds) - 1.0).abs() < 1e-12);
    assert!((end.strain[2][0] / (-0.5 * seconds) - 1.0).abs() < 1e-12);
    assert_eq!(path.strain[1], -end.strain[1][1]);
    assert!(end.stress_pa[0][1] < 0.0, "{end:?}");
    let seen = straight.observe();
    let cell = seen.cell.unwrap();
    assert_eq!(cell.stress[(1, 1)], end.stress_pa[1][1]);
    assert_eq!(seen.contact_stress, [0.0; 6]);
    assert_eq!(seen.porosity, end.porosity);
}

/// A packing of a cell is written with its edges and read back to the same bits; a scene takes it
/// up in a cell only.
#[test]
fn a_packing_keeps_its_cell() {
    let folder = std::env::temp_dir().join(format!("dempfv-cell-packing-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let cell = Cell::new([
        Vec3::new(0.1, 0.003, 0.0),
        Vec3::new(0.02, 0.1, 1.0 / 3.0 * 1e-2),
        Vec3::new(0.0, 0.0, 0.1),
    ])
    .unwrap();
    let (x, r) = ([Vec3::new(0.01, 0.02, 0.03), Vec3::new(0.1, 0.11, 0.12)], [0.01, 0.012]);
    packing::write_in_cell(&folder.join("p.txt"), &x, &r, &cell, "of a test").unwrap();
    let packing = Packing::read(&folder.join("p.txt")).unwrap();
    assert_eq!((packing.cell, packing.bounds), (Some(cell), None));
    assert_eq!(packing.position, x);

    let scene = |table: &str| {
        let text = format!(
            "{table}\n[particles]\npacking = \"p.txt\"\n[dem]\n[[stage]]\nkind = \"run\"\nsteps = 1\n"
        );
        Plan::from_toml(&text, Some(Path::new(&folder.join("s.toml")))).unwrap()
    };
    let simulation = Simulation::new(scene("[cell]")).unwrap();
    assert_eq!(*simulation.coupled().dem().cell().unwrap().cell(), cell);
    let error = Simulation::new(scene("")).err().unwrap().to_string();
    assert!(error.contains("the packing is of a periodic cell"), "{error}");
    // A comment that begins with the word is one; edges that are too few are no comment.
    assert_eq!(Packing::parse("# cell of a test\n0 0 0 1\n").unwrap().cell, None);
    let error = Packing::parse("# cell 1 0 0 0 1 0\n0 0 0 1\n").unwrap_err();
    assert!(error.to_string().contains("6 columns where 9 are due"), "{error}");
    std::fs::write(folder.join("p.txt"), "0 0 0 0.01\n").unwrap();
    let error = Simulation::new(scene("[cell]")).err().unwrap().to_string();
    assert!(error.contains("no line `# cell`"), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}
