//! The same bits for any number of threads, in every repetition, and after a
//! restart from a checkpoint.

mod coupling_support;

use std::path::PathBuf;

use coupling_support::{COMPACT, MEASURE, advance, finish, plan, scene, start};
use dempfv::coupling::Observation;
use dempfv::io::checkpoint;
use dempfv::simulation::{Simulation, SimulationState};

/// Every kind of stage; the last shears the box with moving walls.
fn all_stages(remesh: &str) -> String {
    let rest = r#"
        [[stage]]
        kind = "consolidate"
        wall = "y_max"
        stress = 1.1e4
        until_tv = 0.03
        profiles = [0.001, 0.01, 0.02]
        max_velocity = 0.1
        [[stage]]
        kind = "run"
        steps = 150
        friction_angle = 20.0
        [stage.walls]
        x_min = { velocity = 0.05 }
        y_max = { stress = 1.2e4 }
        z_max = { stress = 1.1e4 }
    "#;
    scene(120, remesh, &format!("{COMPACT}{MEASURE}{rest}"))
}

/// A run's course: its hash every 25 steps, then the end.
fn course(simulation: &mut Simulation) -> Vec<(u64, String)> {
    let mut seen = vec![];
    loop {
        let more = simulation.advance().unwrap();
        if simulation.step().is_multiple_of(25) || !more {
            seen.push((simulation.step(), simulation.state_hash()));
        }
        if !more {
            seen.dedup();
            return seen;
        }
    }
}

/// States by stage name, with what could be observed; step and hash after each step; the finished simulation.
type Course = (Vec<(String, SimulationState, Observation)>, Vec<(u64, String)>, Simulation);

/// States at the start of each stage and 60 and 61 steps into it, and the course.
fn with_states(text: &str) -> Course {
    let mut simulation = start(text);
    let mut states = vec![];
    let mut seen = vec![];
    let mut stage = String::new();
    while let Some(now) = simulation.stage() {
        if now.name != stage {
            stage = now.name.clone();
            let at = format!("start of {stage}");
            states.push((at, simulation.state(), simulation.observe()));
        } else if [60, 61].contains(&simulation.stage_steps()) {
            let at = format!("{stage}, step {}", simulation.stage_steps());
            states.push((at, simulation.state(), simulation.observe()));
        }
        simulation.advance().unwrap();
        if simulation.step().is_multiple_of(25) || simulation.stage().is_none() {
            seen.push((simulation.step(), simulation.state_hash()));
        }
    }
    seen.dedup();
    (states, seen, simulation)
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("dempfv-coupling-{}-{name}", std::process::id()))
}

/// N steps, a checkpoint on disk, and M more are N + M steps, bit for bit, and
/// what can be observed right after the restart is what could be before: at
/// the start and in the middle of every kind of stage, with both remesh rules and with a network
/// on its way.
#[test]
fn a_restart_changes_no_bit() {
    for (name, remesh) in [
        ("interval", "remesh_interval = 40"),
        ("strain", "remesh_strain = 1e-3"),
        ("both", "remesh_interval = 50\nremesh_strain = 2e-3"),
        // Its positions are taken 60 steps into each stage.
        ("background", "remesh_interval = 40\nremesh = \"background\"\nparallel_tasks = true"),
        ("ahead", "remesh_interval = 50\nremesh_strain = 2e-3\nremesh = \"ahead\""),
        ("every step", "remesh_interval = 40\nupdate = \"every step\""),
        (
            "every step, ahead",
            "remesh_interval = 50\nremesh_strain = 2e-3\nremesh = \"ahead\"\n\
             update = \"every step\"\nparallel_tasks = true",
        ),
    ] {
        let text = all_stages(remesh);
        let (states, expected, end) = with_states(&text);
        assert!(states.len() >= 13, "{} states", states.len());
        let file = temporary(name);
        for (at, state, observed) in states {
            checkpoint::save(&file, &state).unwrap();
            let read: SimulationState = checkpoint::load(&file).unwrap();
            assert!(read == state, "{name}, {at}");
            let from = read.step();
            let mut simulation = Simulation::restart(plan(&text), read).unwrap();
            assert_eq!(simulation.observe(), observed, "{name}, {at}");
            let seen = course(&mut simulation);
            let due: Vec<_> = expected.iter().filter(|(step, _)| *step > from).cloned().collect();
            let seen: Vec<_> = seen.into_iter().filter(|(step, _)| *step > from).collect();
            let first = seen.iter().zip(&due).find(|(a, b)| a != b);
            assert!(first.is_none(), "{name}, {at} (step {from}): {first:?}");
            assert_eq!(seen.len(), due.len());
            assert!(simulation.outcomes() == end.outcomes(), "{name}, {at}: other outcomes");
            assert_eq!(simulation.remeshes(), end.remeshes(), "{name}, {at}");
            assert_eq!(simulation.time().to_bits(), end.time().to_bits());
        }
        std::fs::remove_file(&file).unwrap();
    }
}

/// 5,000 spheres with 29,319 pores share their work out in every phase: eight
/// blocks of spheres, two tasks of pores.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for update in ["remesh", "every step"] {
        threads_do_not_matter(update);
    }
}

fn threads_do_not_matter(update: &str) {
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-5000.txt");
    let text = format!(
        r#"
        [particles]
        packing = "{packing}"
        [dem]
        dt = 1e-6
        damping = 0.2
        [fluid]
        viscosity = 1e-3
        remesh_interval = 8
        update = {update:?}
        pressure = {{ y_max = 0.0 }}
        [[stage]]
        kind = "run"
        steps = 20
        walls = {{ y_max = {{ stress = 1e3 }}, x_min = {{ velocity = 0.01 }} }}
        "#
    );
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = start(&text);
            finish(&mut simulation);
            assert_eq!(simulation.remeshes(), 3);
            simulation.state_hash()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
    assert_eq!(one, run(1));
}

/// The seed draws the packing: the same one gives the same bits, another one
/// does not.
#[test]
fn the_seed_decides() {
    let run = |text: &str| {
        let mut simulation = start(text);
        advance(&mut simulation, 300);
        simulation.state_hash()
    };
    let text = all_stages("remesh_interval = 40");
    assert_eq!(run(&text), run(&text));
    assert_ne!(run(&text), run(&text.replace("seed = 3", "seed = 4")));
}
