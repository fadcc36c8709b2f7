//! `[accuracy]`: the error that a run estimates is that which it makes, and near the target.

use dempfv::coupling::{RemeshMode, RemeshRule};
use dempfv::scene::{Plan, TimeStep};
use dempfv::simulation::Simulation;

const PACKING: &str =
    concat!("packing = \"", env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt\"");

/// A run: pressures at the spheres (Pa) in the middle of motions, and the steps (s).
struct Course {
    times: Vec<f64>,
    steps: Vec<f64>,
    pressures: Vec<Vec<f64>>,
    estimate: Option<f64>,
    networks: u64,
}

/// The last stage of a plan, step by step.
fn course(plan: &Plan) -> Course {
    let mut simulation = Simulation::new(plan.clone()).unwrap();
    let last = plan.stages.last().unwrap().name.clone();
    while simulation.stage().is_some_and(|stage| stage.name != last) {
        simulation.advance().unwrap();
    }
    let (mut times, mut steps, mut pressures) = (vec![], vec![], vec![]);
    loop {
        let before = simulation.time();
        let more = simulation.advance().unwrap();
        let dt = simulation.time() - before;
        // Velocities are those half a step before the positions that a step begins with.
        times.push(simulation.time() - 1.5 * dt);
        steps.push(dt);
        let mut pressure = simulation.coupled().pressure_at_spheres();
        if plan.cell.is_some() {
            // An incompressible fluid leaves a constant open.
            let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
            pressure.iter_mut().for_each(|p| *p -= mean);
        }
        pressures.push(pressure);
        if !more {
            break;
        }
    }
    Course {
        times,
        steps,
        pressures,
        estimate: simulation.error_estimate().map(|e| e.total),
        networks: simulation.remeshes(),
    }
}

/// Root of the mean square, over spheres and time, of the difference to a finer run, over that of its
/// pressures.
fn error(run: &Course, exact: &Course) -> f64 {
    let (mut off, mut size) = (0.0, 0.0);
    for ((&time, &weight), pressures) in run.times.iter().zip(&run.steps).zip(&run.pressures) {
        let after = exact.times.partition_point(|&t| t < time);
        let (Some(before), true) = (after.checked_sub(1), after < exact.times.len()) else {
            continue;
        };
        let share = (time - exact.times[before]) / (exact.times[after] - exact.times[before]);
        for ((p, a), b) in
            pressures.iter().zip(&exact.pressures[before]).zip(&exact.pressures[after])
        {
            let there = a + share * (b - a);
            off += weight * (p - there).powi(2);
            size += weight * there * there;
        }
    }
    (off / size).sqrt()
}

/// The same with a network in each fourth step, solved to round-off, and steps of this length (s).
fn reference(plan: &Plan, dt: f64) -> Course {
    let mut plan = plan.clone();
    plan.accuracy = None;
    let fluid = plan.fluid.as_mut().unwrap();
    fluid.remesh = RemeshRule { interval: Some(4), strain: None };
    fluid.acceleration.remesh = RemeshMode::AtOnce;
    fluid.tolerance = 1e-12;
    plan.stages.last_mut().unwrap().dt = Some(TimeStep::Fixed(dt));
    course(&plan)
}

fn scenes() -> Vec<(&'static str, String)> {
    let cloud = |count: u32| {
        format!(
            "[box]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n[particles]\ncloud = {{ count = {count}, porosity = 0.75, \
             spread = 0.3 }}\nyoung = 1e6\nfriction_angle = 30\n[dem]\n[[stage]]\nkind = \"compact\"\nstress = 1e4\n"
        )
    };
    vec![
        (
            "load",
            format!(
                "{}[[stage]]\nkind = \"run\"\ntime = 2e-2\nwalls = {{ y_max = {{ stress = 2e4 }} }}\n\
                 [fluid]\nviscosity = 0.01\npressure = {{ y_max = 0 }}\n",
                cloud(300)
            ),
        ),
        (
            "piston",
            format!(
                "{}[[stage]]\nkind = \"run\"\ntime = 2e-2\nwalls = {{ y_max = {{ velocity = -0.2 }} }}\n\
                 [fluid]\nviscosity = 0.01\npressure = {{ y_max = 0 }}\n",
                cloud(300)
            ),
        ),
        (
            "shear",
            format!(
                "{}[[stage]]\nkind = \"run\"\ntime = 2e-2\nwalls = {{ x_max = {{ velocity = -0.2 }}, y_max = {{ stress = \
                 1e4 }} }}\n[fluid]\nviscosity = 0.1\npressure = {{ y_max = 0 }}\n",
                cloud(300)
            ),
        ),
        (
            "water",
            format!(
                "[particles]\n{PACKING}\nfriction_angle = 30\n[dem]\n[fluid]\nviscosity = 1e-3\npressure = {{ y_max = 0 \
                 }}\n[[stage]]\nkind = \"run\"\ntime = 2e-3\nwalls = {{ y_max = {{ stress = 2e3 }} }}\n"
            ),
        ),
        (
            "sink",
            "[box]\nmin = [0, 0, 0]\nmax = [0.04, 0.06, 0.04]\n[particles]\ncloud = { count = 200, porosity = 0.85, \
             spread = 0.3 }\nyoung = 1e5\n[dem]\ndamping = 0\ngravity = [0, -9.81, 0]\n[fluid]\nviscosity = 0.4\ndensity = \
             1260\npressure = { y_max = 0 }\n[[stage]]\nkind = \"run\"\ntime = 0.05\n"
                .to_owned(),
        ),
        (
            "cell",
            "[cell]\nsize = [0.1, 0.1, 0.1]\n[particles]\ncloud = { count = 200, porosity = 0.8, spread = 0.3 \
             }\nyoung = 1e6\n[dem]\n[[stage]]\nkind = \"compact\"\nstress = 1e4\n[[stage]]\nkind = \"run\"\ntime = \
             2e-2\nvelocity_gradient = { xy = 5.0 }\n[fluid]\nviscosity = 0.1\npressure_gradient = [0, 0, 100.0]\n"
                .to_owned(),
        ),
        (
            "pump",
            format!(
                "{}[[stage]]\nkind = \"run\"\ntime = 2e-2\npressure = {{ y_min = {{ ramp = [[0, 0], [0.01, 2e3]] }}, y_max = 0 \
                 }}\nwalls = {{ y_max = {{ stress = 1e4 }} }}\n[fluid]\nviscosity = 0.01\npressure = {{ y_max = 0 }}\n",
                cloud(300)
            ),
        ),
    ]
}

/// A scene that keeps to an error.
fn plan(scene: &str, target: f64) -> Plan {
    Plan::from_toml(&format!("{scene}[accuracy]\ntarget = {target}\n"), None).unwrap()
}

/// The promise: the estimate is within a factor of 3 of the true error in nine of ten runs, never below a
/// third of it; and a true error is not above twice the target.
#[test]
fn estimates_are_near_the_truth() {
    let cases = [0.1, 0.04].into_iter().flat_map(|t| scenes().into_iter().map(move |s| (t, s)));
    let (mut runs, mut near) = (0, 0);
    for (target, (name, scene)) in cases {
        let plan = plan(&scene, target);
        let run = course(&plan);
        let least = run.steps.iter().copied().fold(f64::INFINITY, f64::min);
        let truth = error(&run, &reference(&plan, 0.5 * least));
        let estimate = run.estimate.unwrap();
        println!(
            "{name}, {target}: {estimate:.1e} estimated, {truth:.1e} true, {} networks",
            run.networks
        );
        assert!(estimate > truth / 3.0, "{name}, {target}: {estimate} beside {truth}");
        assert!(truth < 2.0 * target, "{name}: {truth} beside {target}");
        runs += 1;
        near += u32::from(estimate < 3.0 * truth);
    }
    assert!(10 * near >= 9 * runs, "{near} of {runs}");
}

/// A smaller target takes more networks or shorter steps, and makes a smaller error.
#[test]
fn a_smaller_target_costs_more() {
    let (_, piston) = scenes().swap_remove(1);
    let [coarse, fine] = [0.1, 0.01].map(|target| course(&plan(&piston, target)));
    assert!(fine.networks >= 3 * coarse.networks, "{} {}", fine.networks, coarse.networks);
    let exact = reference(&plan(&piston, 0.01), 0.5 * fine.steps[0]);
    let [large, small] = [&coarse, &fine].map(|run| error(run, &exact));
    assert!(small < 0.4 * large, "{small} {large}");
}

/// What is chosen does not depend on the number of threads.
#[test]
fn choices_are_the_same_for_any_threads() {
    let (_, load) = scenes().swap_remove(0);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| course(&plan(&load, 0.1)))
    };
    let (one, two) = (run(1), run(2));
    assert_eq!((&one.pressures, one.estimate), (&two.pressures, two.estimate));
}

/// What a scene gives as the longest step and the largest strain is not passed.
#[test]
fn a_scene_says_the_most() {
    let (_, piston) = scenes().swap_remove(1);
    let free = plan(&piston, 0.1);
    let mut bounded = free.clone();
    let dt = 0.3 * course(&free).steps[0];
    bounded.stages.last_mut().unwrap().dt = Some(TimeStep::Fixed(dt));
    bounded.fluid.as_mut().unwrap().remesh.strain = Some(1e-3);
    let [free, bounded] = [free, bounded].map(|plan| course(&plan));
    assert!(bounded.steps.iter().all(|step| *step <= dt));
    assert!(bounded.networks > 2 * free.networks, "{} {}", bounded.networks, free.networks);
}
