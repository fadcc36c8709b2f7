//! Loads and pressures of a stage that change with time, and states that end it.

mod coupling_support;

use coupling_support::{COMPACT, advance, finish, plan, scene, start};
use dempfv::dem::WallControl;
use dempfv::scene::{StageKind, Until};
use dempfv::simulation::{Outcome, Simulation, StressPath};
use dempfv::{Axis, WallId};

/// The packing that the project ships, and one or more run stages.
fn settled(fluid: &str, stages: &str) -> String {
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");
    format!(
        "[particles]\npacking = \"{packing}\"\n[dem]\ndt = 1e-5\ndamping = 0.3\n{fluid}\n{stages}"
    )
}

const WATER: &str = "[fluid]\nviscosity = 1e-3\nbulk_modulus = 1e5\npressure = { y_max = 0.0 }\n";

fn last_path(simulation: &Simulation) -> &StressPath {
    match &simulation.outcomes().last().unwrap().outcome {
        Outcome::Run(path) => path,
        other => panic!("{other:?}"),
    }
}

/// A velocity that rises from 0 to v in 100 steps, and stays: the wall goes v T/2 and v T', to
/// round-off, in the second stage as in the first: functions count from their stage's start.
#[test]
fn a_velocity_follows_its_ramp() {
    let stage = |name: &str| {
        format!(
            "[[stage]]\nkind = \"run\"\nname = \"{name}\"\nsteps = 150\n\
             walls = {{ y_max = {{ velocity = {{ ramp = [[0.0, 0.0], [1e-3, -2e-3]] }} }} }}\n"
        )
    };
    let mut simulation = start(&settled("", &(stage("first") + &stage("second"))));
    for k in 1..=2 {
        advance(&mut simulation, 150);
        let moved = simulation.coupled().dem().walls()[WallId::YMax].displacement;
        let expected = -f64::from(k) * 2e-3 * (0.5 * 1e-3 + 0.5e-3);
        assert!((moved / expected - 1.0).abs() < 1e-9, "{moved} {expected}");
    }
}

/// A stress that swings about 1 kPa: the servo has its goal at the end of each step.
#[test]
fn a_stress_follows_its_sine() {
    let text = settled(
        "",
        "[[stage]]\nkind = \"run\"\nsteps = 40\n\
         walls = { y_max = { stress = { mean = 1e3, amplitude = 200.0, frequency = 50.0 } } }",
    );
    let mut simulation = start(&text);
    advance(&mut simulation, 37);
    let WallControl::Servo { stress, max_velocity: None } =
        simulation.coupled().dem().walls()[WallId::YMax].control
    else {
        panic!("no servo")
    };
    let expected = 1e3 + 200.0 * (std::f64::consts::TAU * 50.0 * 37e-5).sin();
    assert!((stress / expected - 1.0).abs() < 1e-12, "{stress} {expected}");
}

/// Each stage drains through its own walls: the second has another wall and a pressure that rises with
/// the time from its start; a third without its own has those of the fluid.
#[test]
fn a_stage_has_its_own_pressures() {
    let text = settled(
        WATER,
        "[[stage]]\nkind = \"run\"\nname = \"a\"\nsteps = 5\n\
         [[stage]]\nkind = \"run\"\nname = \"b\"\nsteps = 5\n\
         pressure = { x_min = { ramp = [[0.0, 10.0], [1e-4, 30.0]] } }\n\
         [[stage]]\nkind = \"run\"\nname = \"c\"\nsteps = 5\n",
    );
    let mut simulation = start(&text);
    let on = |simulation: &Simulation, wall: WallId| {
        let flow = simulation.coupled().storage_flow().unwrap();
        let conditions = flow.operators().conditions();
        let pore = (0..flow.network().pores()).find(|&i| conditions.wall_of(i) == Some(wall));
        pore.map(|i| flow.pressure()[i])
    };
    advance(&mut simulation, 5);
    assert_eq!((on(&simulation, WallId::YMax), on(&simulation, WallId::XMin)), (Some(0.0), None));
    advance(&mut simulation, 3);
    assert_eq!(on(&simulation, WallId::YMax), None);
    // 3 steps of 1e-5 s into the stage.
    let p = on(&simulation, WallId::XMin).unwrap();
    assert!((p / (10.0 + 20.0 * 0.3) - 1.0).abs() < 1e-9, "{p}");
    advance(&mut simulation, 7);
    assert_eq!((on(&simulation, WallId::YMax), on(&simulation, WallId::XMin)), (Some(0.0), None));
}

/// A stage without any drain keeps its water: a wall that comes in by ε of the height puts up the pressure by
/// K_f ε / n, n the porosity, to what overlaps leave unclear in it.
#[test]
fn shut_taps_keep_the_water() {
    let text = settled(
        WATER,
        "[[stage]]\nkind = \"run\"\nsteps = 100\npressure = {}\nwalls = { y_max = { velocity = -2e-3 } }\n",
    );
    let mut simulation = start(&text);
    advance(&mut simulation, 100);
    let seen = simulation.observe();
    let strain = 2e-3 * 1e-3 / seen.size[1];
    let expected = 1e5 * strain / seen.porosity;
    assert!(
        (seen.mean_pressure / expected - 1.0).abs() < 0.02,
        "{} {expected}",
        seen.mean_pressure
    );
    assert!(seen.flux.iter().all(|flux| *flux == 0.0));
}

/// A servo that follows its ramp has not missed it, though its stress was never the last one before: no
/// warning.
#[test]
fn a_ramp_that_is_followed_is_no_miss() {
    let text = settled(
        "",
        "[[stage]]\nkind = \"run\"\nname = \"hold\"\ntime = 0.05\nwalls = { y_max = { stress = 1e3 } }\n\
         [[stage]]\nkind = \"run\"\ntime = 0.1\nwalls = { y_max = { stress = { ramp = [[0.0, 1e3], [0.1, 4e3]] } } }",
    );
    let mut simulation = start(&text);
    finish(&mut simulation);
    let stress = simulation.coupled().wall_stress(WallId::YMax);
    assert!((stress / 4e3 - 1.0).abs() < 0.05, "{stress}");
    assert!(simulation.warnings().is_empty(), "{:?}", simulation.warnings());
}

/// A restart in the midst of a stage with its own pressures and a ramp has the bits of a run that
/// did not stop.
#[test]
fn a_restart_goes_on_with_the_loads_of_the_stage() {
    let text = settled(
        WATER,
        "[[stage]]\nkind = \"run\"\nname = \"a\"\nsteps = 7\n\
         [[stage]]\nkind = \"run\"\nname = \"b\"\nsteps = 30\n\
         pressure = { x_min = { ramp = [[0.0, 10.0], [2e-4, 30.0]] } }\n\
         walls = { y_max = { stress = { ramp = [[0.0, 1e3], [3e-4, 2e3]] }, max_velocity = 0.1 } }\n",
    );
    let mut whole = start(&text);
    advance(&mut whole, 19);
    let state = whole.state();
    finish(&mut whole);
    let mut again = Simulation::restart(plan(&text), state).unwrap();
    finish(&mut again);
    assert_eq!(again.state_hash(), whole.state_hash());
    assert_eq!(again.outcomes(), whole.outcomes());
}

/// An isotropic load ends where all walls have their stress and the spheres are at rest; then one wall
/// comes in until the stress on its axis is there, and goes back until the porosity is what it was.
#[test]
fn stages_end_at_the_state_that_they_wait_for() {
    let text = scene(
        100,
        "",
        &format!(
            "{COMPACT}\n\
             [[stage]]\nkind = \"run\"\nname = \"load\"\nfluid = false\ndt = \"auto\"\n\
             until = {{ unbalanced = 0.002, tolerance = 0.02 }}\n\
             walls = {{ x_max = {{ stress = 1.2e4 }}, y_max = {{ stress = 1.2e4 }}, z_max = {{ stress = 1.2e4 }} }}\n\
             [[stage]]\nkind = \"run\"\nname = \"press\"\nfluid = false\n\
             until = {{ stress = 1.6e4, axis = \"y\" }}\nwalls = {{ y_max = {{ velocity = -0.02 }} }}\n\
             [[stage]]\nkind = \"run\"\nname = \"back\"\nfluid = false\n\
             until = {{ porosity = 0.POROSITY }}\nwalls = {{ y_max = {{ velocity = 0.02 }} }}\n"
        ),
    );
    let goal = 0.45;
    let text = text.replace("0.POROSITY", &goal.to_string());
    let mut simulation = start(&text);
    let mut seen = vec![];
    let mut before = 0.0;
    while simulation.stage().is_some() {
        before = simulation.coupled().dem().porosity();
        let done = simulation.outcomes().len();
        simulation.advance().unwrap();
        if simulation.outcomes().len() > done {
            seen.push(simulation.outcomes().last().unwrap().name.clone());
            let coupled = simulation.coupled();
            match seen.last().unwrap().as_str() {
                "load" => {
                    for wall in [WallId::XMax, WallId::YMax, WallId::ZMax] {
                        let stress = coupled.wall_stress(wall);
                        assert!((stress / 1.2e4 - 1.0).abs() <= 0.02, "{wall}: {stress}");
                    }
                    assert!(last_path(&simulation).unbalanced_force < 0.002);
                }
                // A step of 3e-4 s at 0.02 m/s strains by 6e-6: 3 Pa at a modulus of 0.5 MPa.
                "press" => {
                    let stress = coupled.axis_stress(Axis::Y);
                    assert!((1.6e4..1.6e4 + 50.0).contains(&stress), "{stress}");
                }
                _ => {}
            }
        }
    }
    assert_eq!(seen, ["compact", "load", "press", "back"]);
    let now = simulation.coupled().dem().porosity();
    assert!(before < goal && goal <= now, "{before} {now}");
}

/// Each key of an end survives a round trip; what cannot be is refused at its line, with what would be
/// right.
#[test]
fn ends_and_loads_that_cannot_be_are_refused() {
    let stage = |text: &str| settled(WATER, &format!("[[stage]]\nkind = \"run\"\n{text}\n"));
    let wrong = [
        ("until = { max_steps = 3 }", "does not say what ends the stage"),
        ("until = { strain = 0.1, porosity = 0.4, axis = \"y\" }", "stands beside `strain`"),
        ("until = { porosity = 0.4 }", "no wall moves"),
        ("until = { porosity = 0.4, axis = \"y\" }", "has no meaning beside `porosity`"),
        ("until = { stress = 1e3 }", "no `axis`"),
        ("until = { unbalanced = 1.5 }", "above 0 and below 1"),
        (
            "steps = 1\nwalls = { y_max = { stress = { ramp = [[0.0, 1.0], [1.0, -1.0]] } } }",
            "comes to -1 Pa",
        ),
        (
            "steps = 1\nwalls = { y_max = { stress = { ramp = [[1.0, 1.0], [1.0, 2.0]] } } }",
            "no function of time",
        ),
        ("steps = 1\nfluid = false\npressure = { y_max = 1.0 }", "no flow is simulated"),
    ];
    for (text, problem) in wrong {
        let error = dempfv::scene::Plan::from_toml(&stage(text), None).unwrap_err();
        let said = format!("{} {}", error.what, error.remedy);
        assert!(said.contains(problem), "{text}: {said}");
        assert!(error.line.is_some(), "{text}");
    }
    let undetermined = stage("steps = 1\npressure = {}").replace("bulk_modulus = 1e5\n", "");
    let error = dempfv::scene::Plan::from_toml(&undetermined, None).unwrap_err();
    assert!(error.what.contains("undetermined"), "{}", error.what);

    let right = [
        "until = { stress = 1e3, axis = \"x\", max_steps = 7 }",
        "until = { unbalanced = 1e-3, tolerance = 0.05 }",
        "until = { porosity = 0.4 }\nwalls = { y_max = { velocity = { ramp = [[0.0, 0.1], [1.0, 0.0]] } } }",
        "steps = 1\npressure = { x_min = 3.0, y_max = { mean = 1.0, amplitude = 0.5, frequency = 3.0 } }",
    ];
    for text in right {
        let read = plan(&stage(text));
        assert_eq!(plan(&read.to_toml()).stages, read.stages, "{text}");
    }
    let read = plan(&stage(right[1]));
    let StageKind::Run(run) = &read.stages[0].kind else { panic!("no run stage") };
    let expected = Until::Unbalanced { unbalanced: 1e-3, tolerance: 0.05, max_steps: 5_000_000 };
    assert_eq!(run.until, expected);
}
