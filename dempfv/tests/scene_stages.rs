//! Time step and damping of each stage: those of `[dem]`, unless the stage says others.

mod coupling_support;

use coupling_support::{advance, advance_to, plan, scene, start};
use dempfv::Error;
use dempfv::dem::DemError;
use dempfv::simulation::Simulation;

/// Every kind of stage that moves spheres, each with further keys of its own.
fn stages(compact: &str, cycle: &str, consolidate: &str, run: &str) -> String {
    let text = format!(
        r#"
        [[stage]]
        kind = "compact"
        stress = 1.0e4
        friction_angle = 3.0
        unbalanced = 0.05
        tolerance = 0.05
        {compact}
        [[stage]]
        kind = "cycle"
        wall = "y_max"
        from = 1.0e4
        to = 1.1e4
        cycles = 1
        unbalanced = 0.05
        tolerance = 0.05
        {cycle}
        [[stage]]
        kind = "permeability"
        axis = "y"
        [[stage]]
        kind = "consolidate"
        wall = "y_max"
        stress = 1.1e4
        until_tv = 1.0
        max_velocity = 0.1
        {consolidate}
        [[stage]]
        kind = "run"
        steps = 80
        walls = {{ x_min = {{ velocity = 0.05 }} }}
        {run}
        "#
    );
    scene(60, "remesh_interval = 40", &text)
}

/// The time steps of a few steps of each stage, and the damping at each.
fn mechanics(text: &str) -> Vec<(&'static str, f64, f64)> {
    let mut simulation = start(text);
    let mut seen = vec![];
    for stage in ["compact", "cycle", "consolidate", "run"] {
        advance_to(&mut simulation, stage);
        advance(&mut simulation, 3);
        seen.push((stage, simulation.dt(), simulation.coupled().dem().options().damping));
    }
    seen
}

/// The scene of these tests has dt = 3e-4 and damping = 0.2.
#[test]
fn a_fixed_time_step_holds_for_every_stage_that_says_no_other() {
    for (stage, dt, damping) in mechanics(&stages("", "", "", "")) {
        assert_eq!((dt, damping), (3e-4, 0.2), "{stage}");
    }
    let own = stages(
        "dt = 1e-4",
        "dt = 2e-4\ndamping = 0.7",
        "damping = 0.0",
        "dt = \"auto\"\ndamping = 0.4",
    );
    let seen = mechanics(&own);
    assert_eq!(seen[0], ("compact", 1e-4, 0.2));
    assert_eq!(seen[1], ("cycle", 2e-4, 0.7));
    assert_eq!(seen[2], ("consolidate", 3e-4, 0.0));
    let ("run", dt, damping) = seen[3] else { panic!("{seen:?}") };
    assert!(dt > 4e-4 && damping == 0.4, "{seen:?}");
}

/// Growing spheres soften no contact, but what is stable changes: the refusal names both.
#[test]
fn growth_refuses_a_time_step_that_is_not_stable() {
    let mut simulation = start(&stages("dt = 0.05", "", "", ""));
    let error = loop {
        match simulation.advance() {
            Ok(_) => assert!(simulation.step() < 10_000, "it was not refused"),
            Err(error) => break error,
        }
    };
    let Error::AtStep { source, .. } = &error else { panic!("{error}") };
    let Error::Dem(DemError::TimeStepTooLarge { dt, limit }) = **source else { panic!("{error}") };
    assert_eq!(dt, 0.05);
    assert!(limit > 1e-4 && limit < dt, "{limit}");
    let message = error.to_string();
    assert!(message.contains("5e-2 s is not stable") && message.contains("auto"), "{message}");
}

/// What a stage says otherwise is restored, in the midst of it and between two stages.
#[test]
fn a_restart_restores_time_step_and_damping() {
    let text = stages(
        "dt = 1e-4\ndamping = 0.3",
        "dt = \"auto\"\ndamping = 0.6",
        "dt = \"auto\"\ndamping = 0.05",
        "dt = 2e-4\ndamping = 0.45",
    );
    let mut whole = start(&text);
    let mut states = vec![];
    while whole.stage().is_some() {
        if [0, 1, 13].contains(&whole.stage_steps()) {
            states.push(whole.state());
        }
        whole.advance().unwrap();
    }
    assert!(states.len() >= 13, "{}", states.len());
    for state in states {
        let from = state.step();
        let mut again = Simulation::restart(plan(&text), state).unwrap();
        while again.advance().unwrap() {}
        assert_eq!(again.step(), whole.step(), "from step {from}");
        assert_eq!(again.state_hash(), whole.state_hash(), "from step {from}");
        assert_eq!(again.time().to_bits(), whole.time().to_bits(), "from step {from}");
    }
}
