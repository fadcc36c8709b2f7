//! The automatic time step, and stages that end at a time.

use dempfv::coupling::Coupled;
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::{Aabb, Vec3};

/// Two spheres press on each other, a much lighter one touches nothing: the
/// bound must hold for the contact that it may make before the next look,
/// √(2m/k) with k = E r between two of its like.
#[test]
fn a_sphere_without_contacts_bounds_the_time_step() {
    let young = 1e6;
    let material = Material { young, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let (x, r) = (
        vec![Vec3::new(0.5, 0.5, 0.26), Vec3::new(0.5, 0.5, 0.75), Vec3::new(0.05, 0.05, 0.5)],
        vec![0.25, 0.25, 0.01],
    );
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    let walls = WallMaterial { young, friction_angle: 0.0 };
    let spheres = Particles::new(x, r, material.density);
    let lightest = spheres.mass[2];
    let mut dem = Dem::new(spheres, bounds, material, walls, DemOptions::default()).unwrap();
    dem.compute_contacts().unwrap();
    let bound = Coupled::new(dem).time_step_bounds().contact;
    let first_contact = (2.0 * lightest / (young * 0.01)).sqrt();
    assert!(bound <= first_contact * (1.0 + 1e-12), "{bound} > {first_contact}");
}

/// A stage of 1e-5 s at steps of 1e-6 s has ten steps, also after a stage
/// whose automatic time step was forty times as long.
#[test]
fn a_timed_stage_does_its_steps_whatever_came_before() {
    let text = r#"
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = { count = 60, spread = 0.2, porosity = 0.9 }
        [dem]
        dt = 1e-6
        [[stage]]
        kind = "compact"
        stress = 1e4
        unbalanced = 0.05
        tolerance = 0.05
        dt = "auto"
        [[stage]]
        kind = "run"
        time = 1e-5
    "#;
    let mut simulation = Simulation::new(Plan::from_toml(text, None).unwrap()).unwrap();
    while simulation.advance().unwrap() {}
    assert_eq!(simulation.outcomes()[1].steps, 10);
}

/// The automatic time step is looked at every 51 steps. Restarted right before
/// such a look, while contacts come and go in a packing that rattles, a run
/// still takes the same step, to the bit.
#[test]
fn an_automatic_step_survives_a_restart() {
    let text = r#"
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = { count = 60, spread = 0.3, porosity = 0.9 }
        [dem]
        damping = 0.001
        [[stage]]
        kind = "compact"
        stress = 1e4
        unbalanced = 0.5
        tolerance = 0.5
        [[stage]]
        kind = "run"
        steps = 10200
        walls = { x_min = { velocity = -0.005 } }
    "#;
    let plan = || Plan::from_toml(text, None).unwrap();
    let mut simulation = Simulation::new(plan()).unwrap();
    let mut steps = vec![];
    while simulation.stage().is_some() {
        let look = simulation.outcomes().len() == 1 && simulation.stage_steps().is_multiple_of(51);
        let before = look.then(|| simulation.state());
        simulation.advance().unwrap();
        if let Some(state) = before {
            let mut again = Simulation::restart(plan(), state).unwrap();
            again.advance().unwrap();
            assert_eq!(again.dt(), simulation.dt(), "at step {}", simulation.step());
            assert_eq!(again.state_hash(), simulation.state_hash());
            steps.push(simulation.dt());
        }
    }
    steps.dedup();
    assert!(steps.len() > 50, "{} time steps", steps.len());
}
