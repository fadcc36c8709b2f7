//! Scenes that several tests of the coupling start from.
#![allow(dead_code, reason = "every test file uses some of these")]

use dempfv::scene::Plan;
use dempfv::simulation::Simulation;

/// A cloud in a box of 1 m, stiff enough to settle in some thousand steps:
/// the shipped oedometer with fewer spheres. `fluid` are further lines of its
/// table, `stages` the stages.
pub fn scene(spheres: usize, fluid: &str, stages: &str) -> String {
    format!(
        r#"
        seed = 3
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = {{ count = {spheres}, spread = 0.3333, porosity = 0.95 }}
        young = 1.0e6
        [walls]
        friction_angle = 0.0
        [dem]
        dt = 3.0e-4
        damping = 0.2
        [fluid]
        viscosity = 10.0
        pressure = {{ y_max = 0.0 }}
        {fluid}
        {stages}
        "#
    )
}

/// Growth to 10 kPa.
pub const COMPACT: &str = r#"
    [[stage]]
    kind = "compact"
    stress = 1.0e4
    friction_angle = 3.0
    dt = "auto"
"#;

/// What a consolidation needs to know.
pub const MEASURE: &str = r#"
    [[stage]]
    kind = "cycle"
    wall = "y_max"
    from = 1.0e4
    to = 1.1e4
    cycles = 1
    dt = "auto"
    [[stage]]
    kind = "permeability"
    axis = "y"
"#;

pub fn plan(text: &str) -> Plan {
    Plan::from_toml(text, None).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

pub fn start(text: &str) -> Simulation {
    Simulation::new(plan(text)).unwrap()
}

/// Advances to the end of all stages.
pub fn finish(simulation: &mut Simulation) {
    while simulation.advance().unwrap() {}
}

/// Advances until a stage with this name is about to begin.
pub fn advance_to(simulation: &mut Simulation, stage: &str) {
    while simulation.stage().unwrap().name != stage {
        simulation.advance().unwrap();
    }
}

/// Advances by a number of steps.
pub fn advance(simulation: &mut Simulation, steps: u64) {
    let end = simulation.step() + steps;
    while simulation.step() < end {
        simulation.advance().unwrap();
    }
}
