//! Forces between neighbours in scenes: with friction, remeshes and servo walls; restarts, threads,
//! and what makes no sense.

mod coupling_support;

use coupling_support::{advance, finish, plan, start};
use dempfv::io::checkpoint;
use dempfv::scene::Plan;
use dempfv::simulation::{Simulation, SimulationState};

const ALL: &str = "viscous_shear = true\nnormal_lubrication = true\nshear_lubrication = true\n\
                   pump_torque = true\ntwist_torque = true\neps = 1e-3";

/// A packing with friction that is squeezed and sheared.
fn scene(spheres: u32, fluid: &str, steps: u32) -> String {
    let packings = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer");
    format!(
        r#"
        [particles]
        packing = "{packings}-{spheres}.txt"
        friction_angle = 30
        [dem]
        dt = 2e-6
        damping = 0.2
        [fluid]
        viscosity = 0.1
        pressure = {{ y_max = 0.0 }}
        {fluid}
        [[stage]]
        kind = "run"
        steps = {steps}
        walls = {{ y_max = {{ stress = 2e3 }}, x_min = {{ velocity = 0.05 }} }}
        "#
    )
}

/// All effects on, in each way to renew networks, with and without slip at walls: N steps, a checkpoint
/// as bytes, and M more are N + M steps, bit for bit; what is observed after the restart is what was
/// before; and so is the energy by cause.
#[test]
fn a_restart_changes_no_bit() {
    for how in [
        "remesh_interval = 20",
        "remesh_interval = 20\nslip_walls = false\nparallel_tasks = true",
        "remesh_interval = 20\nremesh = \"background\"",
        "remesh_interval = 20\nupdate = \"every step\"\nremesh = \"ahead\"",
    ] {
        let text = scene(1000, &format!("{ALL}\n{how}"), 70);
        let mut whole = start(&text);
        let mut states = vec![];
        while whole.stage().is_some() {
            if [0, 1, 20, 37, 40].contains(&whole.step()) {
                states.push((whole.state(), whole.observe(), whole.coupled().fluid_force()));
            }
            whole.advance().unwrap();
        }
        assert!(whole.remeshes() >= 3);
        for (state, observed, force) in states {
            let step = state.step();
            let file = std::env::temp_dir()
                .join(format!("dempfv-lubrication-{}-{step}", std::process::id()));
            checkpoint::save(&file, &state).unwrap();
            let read: SimulationState = checkpoint::load(&file).unwrap();
            std::fs::remove_file(&file).unwrap();
            let mut again = Simulation::restart(plan(&text), read).unwrap();
            assert_eq!(again.observe(), observed, "{how}, {step}");
            assert_eq!(again.coupled().fluid_force(), force, "{how}, {step}");
            finish(&mut again);
            assert_eq!(again.state_hash(), whole.state_hash(), "{how}, from {step}");
            let energy = |s: &Simulation| s.coupled().dem().energy_balance();
            assert_eq!(energy(&again), energy(&whole), "{how}, from {step}");
        }
    }
}

/// 5,000 spheres and 36,000 edges share their work out: 18 tasks.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads: usize, tasks: bool| {
        let text =
            scene(5000, &format!("{ALL}\nremesh_interval = 8\nparallel_tasks = {tasks}"), 20);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = start(&text);
            finish(&mut simulation);
            let energy = simulation.coupled().dem().energy_balance().unwrap();
            (simulation.state_hash(), format!("{energy:?}"))
        })
    };
    let one = run(1, false);
    assert_eq!(one, run(2, false));
    assert_eq!(one, run(3, true));
}

/// With friction and remeshes the balance of energy closes as well as without films: what time
/// integration makes or loses is less than a thousandth of what was moved.
#[test]
fn energy_is_balanced_with_friction_and_remeshes() {
    let mut simulation = start(&scene(1000, &format!("{ALL}\nremesh_interval = 50"), 2_000));
    finish(&mut simulation);
    let b = simulation.coupled().dem().energy_balance().unwrap();
    println!("{b:?}");
    assert!(b.friction > 0.0 && b.normal_lubrication > 0.0 && b.viscous_shear > 0.0, "{b:?}");
    assert!(b.residual.abs() < 1e-3 * b.moved(), "{b:?}");
}

/// Effects may come and go where a run is taken up: films begin without force.
#[test]
fn effects_may_change_at_a_restart() {
    let on = scene(1000, &format!("{ALL}\nslip_walls = false"), 40);
    for other in ["", "viscous_shear = true", "normal_lubrication = true\neps = 0"] {
        let text = scene(1000, &format!("{other}\nslip_walls = false"), 40);
        for (from, to) in [(&on, &text), (&text, &on)] {
            let mut first = start(from);
            advance(&mut first, 20);
            let mut second = Simulation::restart(plan(to), first.state()).unwrap();
            finish(&mut second);
            assert!(second.observe().kinetic_energy.is_finite());
        }
    }
}

/// Each scene that makes no sense is refused with the reason.
#[test]
fn senseless_scenes_are_refused() {
    let error = |fluid: &str, dem: &str, stage: &str| {
        let text = format!(
            "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\ncloud = {{ count = 9, radius = 0.05 }}\n\
             {dem}\n[fluid]\nviscosity = 1\npressure = {{ y_max = 0 }}\n{fluid}\n[[stage]]\n{stage}"
        );
        match Plan::from_toml(&text, None) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    };
    let run = "kind = \"run\"\nsteps = 1";
    for (fluid, dem, stage, told) in [
        ("eps = 1e-3", "[dem]", run, "nothing is lubricated"),
        ("viscous_shear = true\neps = 1e-3", "[dem]", run, "nothing is lubricated"),
        ("lubrication_stiffness = 1e6", "[dem]", run, "no film is squeezed"),
        ("shear_lubrication = true\neps = 0", "[dem]", run, "give a roughness above 0"),
        ("pump_torque = true\neps = 0", "[dem]", run, "give a roughness above 0"),
        ("normal_lubrication = true\neps = -1", "[dem]", run, "eps"),
        ("normal_lubrication = 1", "[dem]", run, "true or false"),
        ("pump_torque = true", "[dem]\nrotation = false", run, "no sphere turns"),
        ("twist_torque = true", "[dem]\nrotation = false", run, "no sphere turns"),
        ("viscous_shear = true", "", "kind = \"permeability\"\naxis = \"x\"", "no stage couples"),
        (
            "normal_lubrication = true",
            "[dem]",
            "kind = \"run\"\nsteps = 1\nfluid = false",
            "no stage couples",
        ),
        ("normal_lubricaton = true", "[dem]", run, "normal_lubrication"),
    ] {
        let found = error(fluid, dem, stage);
        assert!(found.contains(told), "{fluid}: {found}");
    }
    let fine =
        "normal_lubrication = true\neps = 0\nlubrication_stiffness = 1e7\nviscous_shear = true";
    assert_eq!(error(fine, "[dem]\nrotation = false", run), "");
}
