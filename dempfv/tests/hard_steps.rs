//! Hard cases of motion: servo walls around a viscous fluid, time steps above their limit, and
//! contacts that nothing damps.

use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::{Error, WallId};

const PACKING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");

fn simulation(text: &str) -> Simulation {
    let text = text.replace("PACKING", PACKING);
    Simulation::new(Plan::from_toml(&text, None).unwrap()).unwrap()
}

fn finish(simulation: &mut Simulation) {
    while simulation.advance().unwrap() {}
}

/// Four servo walls at 1 kPa squeeze a fluid of 1 Pa·s that leaves at a fifth: at the end each
/// carries its load within 2 %, and there is nothing to warn of.
#[test]
fn servo_walls_around_a_viscous_fluid_hold_their_stress() {
    for viscosity in [1e-3, 1.0, 100.0] {
        let mut simulation = simulation(&format!(
            r#"
            [particles]
            packing = "PACKING"
            young = 1.0e6
            friction_angle = 30.0
            [dem]
            [fluid]
            viscosity = {viscosity}
            remesh_interval = 100
            pressure = {{ y_max = 0.0 }}
            [[stage]]
            kind = "run"
            steps = 400
            [stage.walls]
            x_min = {{ stress = 1.0e3 }}
            x_max = {{ stress = 1.0e3 }}
            z_min = {{ stress = 1.0e3 }}
            z_max = {{ stress = 1.0e3 }}
            "#
        ));
        finish(&mut simulation);
        for wall in [WallId::XMin, WallId::XMax, WallId::ZMin, WallId::ZMax] {
            let stress = simulation.coupled().wall_stress(wall);
            assert!((stress / 1e3 - 1.0).abs() < 0.02, "μ = {viscosity}, {wall}: {stress}");
        }
        assert_eq!(simulation.warnings(), Vec::<String>::new(), "μ = {viscosity}");
    }
}

fn fixed_step(dt: f64, steps: u64) -> Simulation {
    simulation(&format!(
        r#"
        [particles]
        packing = "PACKING"
        young = 1.0e6
        [dem]
        dt = {dt:e}
        damping = 0.0
        [[stage]]
        kind = "run"
        name = "press"
        steps = {steps}
        walls = {{ y_max = {{ velocity = -0.1 }} }}
        "#
    ))
}

/// A step of three times the limit is warned of in its first step and fails with that as its cause;
/// one of half the limit is not.
#[test]
fn a_step_above_the_limit_is_named_as_the_cause() {
    let mut looked = fixed_step(1e-9, 1);
    finish(&mut looked);
    let limit = Plan::from_toml(
        &format!(
            "[particles]\npacking = \"{PACKING}\"\nyoung = 1.0e6\n[dem]\ndamping = 0.2\nsafety = 1.0\n[[stage]]\nkind = \"run\"\nsteps = 1\n"
        ),
        None,
    );
    let mut automatic = Simulation::new(limit.unwrap()).unwrap();
    finish(&mut automatic);
    let limit = automatic.dt();

    let mut stable = fixed_step(0.5 * limit, 50);
    finish(&mut stable);
    assert_eq!(stable.warnings(), Vec::<String>::new());

    let mut unstable = fixed_step(3.0 * limit, 100_000);
    unstable.advance().unwrap();
    let [warning] = &unstable.warnings()[..] else { panic!("one warning") };
    assert!(warning.contains("\"press\"") && warning.contains("above the limit"), "{warning}");
    let error = loop {
        if let Err(error) = unstable.advance() {
            break error;
        }
    };
    let Error::AtStep { source, .. } = &error else { panic!("{error}") };
    assert!(matches!(**source, Error::Unstable { .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("the likely cause: the time step of"), "{message}");
    // The sphere that has left is told, and no second cause.
    assert!(message.contains("has gone through the wall"), "{message}");
    assert_eq!(message.matches("likely cause").count(), 1, "{message}");
}

/// One sphere dropped on the floor without damping keeps its energy within 0.5 % over ten bounces:
/// 16 steps for each collision of two spheres, 23 with a wall.
#[test]
fn a_bouncing_sphere_keeps_its_energy() {
    let text = r#"
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = { count = 1, radius = 0.1 }
        density = 2600.0
        young = 1.0e6
        [dem]
        gravity = [0, 0, -9.81]
        damping = 0.0
        [[stage]]
        kind = "run"
        time = 5.0
    "#;
    let mut simulation = simulation(text);
    let energy = |simulation: &Simulation| {
        let dem = simulation.coupled().dem();
        let particles = dem.storage();
        // Velocities are half a step behind: the mean of both neighbours is that of the moment.
        let height = particles.position[0].z - 0.1;
        let weight = particles.mass[0] * 9.81;
        let speed = particles.velocity[0].z - 0.5 * 9.81 * simulation.dt();
        0.5 * particles.mass[0] * speed * speed + weight * height + dem.elastic_energy()
    };
    simulation.advance().unwrap();
    let (start, mut bounces, mut up) = (energy(&simulation), 0, false);
    while simulation.advance().unwrap() {
        let rising = simulation.coupled().dem().storage().velocity[0].z > 0.0;
        bounces += u32::from(rising && !up);
        up = rising;
        if simulation.coupled().dem().wall_contact_count() == 0 {
            let off = (energy(&simulation) / start - 1.0).abs();
            assert!(off < 5e-3, "{off} after {bounces} bounces");
        }
    }
    assert!(bounces >= 5, "{bounces}");
}
