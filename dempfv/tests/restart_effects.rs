//! A restart changes no bit, whatever is on: scenes that have between them every effect there is.

use std::collections::BTreeSet;

use dempfv::io::checkpoint;
use dempfv::scene::Plan;
use dempfv::simulation::{Simulation, SimulationState};

/// A shipped packing, or a cloud, and a fluid with all that this test adds.
const PACKING: &str =
    concat!("packing = \"", env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt\"");
const CLOUD: &str = "cloud = { count = 150, porosity = 0.8, spread = 0.3 }\nyoung = 1e6";

/// Elastic contacts with all that Hertz-Mindlin goes with, and a fluid with all that it goes with.
fn hertz_in_a_compressible_fluid() -> String {
    format!(
        r#"
        [particles]
        {PACKING}
        friction_angle = 30
        [[material]]
        name = "soft"
        min = [0, 0, 0]
        max = [1, 0.011, 1]
        young = 5e5
        [walls]
        friction_angle = 10
        [contacts]
        law = "hertz-mindlin"
        restitution = 0.5
        rolling_friction = 0.1
        twisting_friction = 0.1
        adhesion = "dmt"
        work_of_adhesion = 0.1
        [dem]
        dt = 2e-6
        damping = 0.2
        gravity = [0, -9.81, 0]
        [fluid]
        viscosity = 0.1
        density = 1000
        bulk_modulus = 1e6
        pressure = {{ y_max = {{ along = "x", points = [[0.0, 10.0], [0.022, 0.0]], plus = {{ mean = 0.0, amplitude = 5.0, frequency = 100.0 }} }} }}
        imposed = [{{ center = [0.011, 0.011, 0.011], radius = 0.002, pressure = 10.0 }}]
        sources = [{{ points = [[0.005, 0.005, 0.005]], rate = 1e-9 }}]
        blocked = [{{ center = [0.018, 0.006, 0.018], radius = 0.002 }}]
        conductance_factor = 1.5
        clamp = "relative"
        viscous_shear = true
        normal_lubrication = true
        shear_lubrication = true
        pump_torque = true
        twist_torque = true
        eps = 1e-3
        remesh_interval = 20
        remesh = "background"
        parallel_tasks = true
        [[stage]]
        kind = "run"
        steps = 60
        walls = {{ y_max = {{ stress = 2e3 }}, x_min = {{ velocity = 0.05 }} }}
        "#
    )
}

/// Bonds that break, and a Darcy medium that follows each step and is pushed by no motion.
fn bonds_in_a_darcy_medium() -> String {
    format!(
        r#"
        [particles]
        {PACKING}
        friction_angle = 30
        [contacts]
        restitution = 0.7
        rolling_friction = 0.1
        [bonds]
        tension = 100
        cohesion = 100
        interaction_range = 1.02
        [dem]
        dt = 1e-4
        [fluid]
        viscosity = 1.0
        pressure = {{ y_max = 0.0 }}
        darcy_permeability = 1e-6
        coupling = "one-way"
        update = "every step"
        slip_walls = true
        remesh_interval = 20
        [[stage]]
        kind = "run"
        steps = 60
        walls = {{ y_max = {{ velocity = -0.05 }} }}
        "#
    )
}

/// Dumb-bells that grow, stick by a constant force, and stand on others that are moved.
fn clumps_on_a_moving_floor() -> String {
    format!(
        r#"
        seed = 3
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        {CLOUD}
        clump = [[0.5, 0, 0, 0.5], [-0.45, 0, 0, 0.55]]
        [contacts]
        adhesion = "constant"
        pull_off_force = 0.1
        [[motion]]
        min = [0, 0, 0]
        max = [1, 0.15, 1]
        from = "second"
        velocity = [0, {{ ramp = [[0, 0], [1, 0.1]] }}, 0]
        spin = [0, 1.0, 0]
        about = [0.5, 0, 0.5]
        [dem]
        [fluid]
        viscosity = 1.0
        pressure = {{ y_max = 0.0 }}
        remesh_interval = 25
        [[stage]]
        kind = "compact"
        stress = 1.0e4
        [[stage]]
        kind = "run"
        name = "second"
        steps = 100
        dt = 1e-4
        walls = {{ y_max = {{ velocity = -0.02 }} }}
        "#
    )
}

/// JKR adhesion, and Hertz-Mindlin contacts without fluid.
fn sticky_spheres() -> String {
    format!(
        r#"
        [particles]
        {PACKING}
        friction_angle = 30
        [contacts]
        law = "hertz-mindlin"
        adhesion = "jkr"
        work_of_adhesion = 1.0
        [dem]
        dt = "auto"
        [[stage]]
        kind = "run"
        steps = 60
        walls = {{ y_max = {{ velocity = 0.05 }} }}
        "#
    )
}

/// A periodic cell that is sheared under a stress while a fluid flows through it.
fn a_sheared_cell_with_a_gradient() -> String {
    format!(
        r#"
        seed = 2
        [cell]
        size = [1, 1, 1]
        [particles]
        {CLOUD}
        [dem]
        [fluid]
        viscosity = 1.0
        bulk_modulus = 1e5
        pressure_gradient = [0, 0, 100.0]
        remesh_interval = 25
        [[stage]]
        kind = "compact"
        stress = 1.0e4
        [[stage]]
        kind = "run"
        steps = 100
        dt = 1e-4
        velocity_gradient = {{ xy = 0.1 }}
        cell_stress = {{ yy = 1.0e4 }}
        "#
    )
}

/// A saturated packing under a new load, whose steps and networks follow an error.
fn an_error_that_is_kept_to() -> String {
    format!(
        r#"
        [particles]
        {PACKING}
        friction_angle = 30
        [dem]
        damping = 0.2
        [fluid]
        viscosity = 0.1
        pressure = {{ y_max = 0.0 }}
        remesh = "ahead"
        [accuracy]
        target = 0.05
        [[stage]]
        kind = "run"
        steps = 70
        walls = {{ y_max = {{ velocity = -0.5 }} }}
        "#
    )
}

fn plan(text: &str) -> Plan {
    Plan::from_toml(text, None).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The end of a run, down to the energy by cause.
fn end(simulation: &mut Simulation) -> (String, String) {
    while simulation.advance().unwrap() {}
    (simulation.state_hash(), format!("{:?}", simulation.coupled().dem().energy_balance()))
}

/// N steps, a checkpoint as bytes, and M more are N + M steps, bit for bit: at the start of each stage,
/// where a network comes into use, and between.
fn restarts_alike(name: &str, text: &str) {
    let mut whole = Simulation::new(plan(text)).unwrap();
    let mut states = vec![];
    while whole.stage().is_some() {
        if [0, 1, 20, 37, 51].contains(&whole.stage_steps()) {
            states.push(whole.state());
        }
        whole.advance().unwrap();
    }
    let expected = end(&mut whole);
    let file = std::env::temp_dir().join(format!("dempfv-effects-{}-{name}", std::process::id()));
    assert!(states.len() >= 5, "{name}: {}", states.len());
    for state in states {
        checkpoint::save(&file, &state).unwrap();
        let read: SimulationState = checkpoint::load(&file).unwrap();
        assert!(read == state, "{name}");
        let mut again = Simulation::restart(plan(text), read).unwrap();
        assert_eq!(end(&mut again), expected, "{name}, from step {}", state.step());
    }
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn hertz_films_and_a_compressible_fluid() {
    restarts_alike("hertz", &hertz_in_a_compressible_fluid());
}

#[test]
fn bonds_and_a_darcy_medium() {
    restarts_alike("bonds", &bonds_in_a_darcy_medium());
}

#[test]
fn clumps_motions_and_growth() {
    restarts_alike("clumps", &clumps_on_a_moving_floor());
}

#[test]
fn jkr_adhesion() {
    restarts_alike("jkr", &sticky_spheres());
}

#[test]
fn a_cell_with_shear_stress_and_flow() {
    restarts_alike("cell", &a_sheared_cell_with_a_gradient());
}

#[test]
fn an_error_kept_to() {
    restarts_alike("error", &an_error_that_is_kept_to());
}

/// The scenes above have every effect that a scene can name: who adds one, adds it here.
#[test]
fn every_effect_is_among_them() {
    let scenes = [
        hertz_in_a_compressible_fluid(),
        bonds_in_a_darcy_medium(),
        clumps_on_a_moving_floor(),
        sticky_spheres(),
        a_sheared_cell_with_a_gradient(),
        an_error_that_is_kept_to(),
    ];
    let plans: Vec<Plan> = scenes.iter().map(|text| plan(text)).collect();
    let on: BTreeSet<&str> = plans.iter().flat_map(Plan::effects_on).collect();
    let all = plans[0].effects();
    let missing: Vec<&str> =
        all.iter().map(|(effect, _)| effect.name).filter(|name| !on.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
