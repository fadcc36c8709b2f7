//! The viscous bound of the time step: real steps on either side of it.

mod common;
mod coupling_support;

use common::{Random, Spheres, settled, unit_box};
use coupling_support::{plan, start};
use dempfv::coupling::{Coupled, RemeshRule, Saturation, TimeStepRule};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::io::checkpoint;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::simulation::{Simulation, SimulationState, Stability};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

/// So viscous that contacts do not matter: the viscous bound of the settled
/// packing is 1e-8 s, that of its contacts 5e-5 s.
const SYRUP: f64 = 1e3;

/// A fluid that drains through y_max.
fn fluid(viscosity: f64) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary }
}

fn saturated(s: &Spheres, viscosity: f64, damping: f64) -> Coupled {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let options = DemOptions { damping, ..DemOptions::default() };
    let spheres = Particles::new(s.x.clone(), s.r.clone(), material.density);
    let mut dem = Dem::new(spheres, s.bounds, material, walls, options).unwrap();
    dem.compute_contacts().unwrap();
    let mut coupled = Coupled::new(dem);
    let remesh = RemeshRule { interval: None, strain: None };
    let solver = SolverKind::default();
    coupled.saturate(Saturation { fluid: fluid(viscosity), solver, remesh });
    coupled
}

/// The viscous bound (s).
fn bound(coupled: &mut Coupled) -> f64 {
    coupled.update_viscous_mode(true).unwrap();
    coupled.time_step_bounds().viscous.unwrap()
}

/// How spheres are set in motion.
#[derive(Clone, Copy)]
enum Kick {
    /// Each in its own direction, at up to so many m/s.
    Random(f64),
    /// In the fastest mode, with the energy of 1 mm/s.
    Mode,
}

/// The kinetic energy `steps` steps after a kick, over that of the kick.
fn growth(mut coupled: Coupled, kick: Kick, dt: f64, steps: usize) -> f64 {
    let mode = coupled.viscous_mode().map(|m| m.shape.clone()).unwrap_or_default();
    let mass = coupled.dem().storage().mass.clone();
    let total: f64 = mass.iter().sum();
    let mut random = Random(5);
    for (i, v) in coupled.controls().storage_velocities_mut().0.iter_mut().enumerate() {
        *v = match kick {
            Kick::Random(speed) => speed * random.vector(),
            Kick::Mode => 1e-3 * (total / mass[i]).sqrt() * mode[i],
        };
    }
    let before = coupled.dem().kinetic_energy();
    for _ in 0..steps {
        if coupled.step(dt).is_err() {
            return f64::INFINITY;
        }
    }
    coupled.dem().kinetic_energy() / before
}

/// The promise: 5 % above the bound the fastest mode grows, by 1.03 a step at
/// least, so 1e6 in amplitude after 500; 5 % below it everything decays.
#[test]
fn a_step_above_the_viscous_bound_diverges_and_one_below_does_not() {
    let packing = settled();
    let fresh = || saturated(&packing, SYRUP, 0.0);
    let bound = bound(&mut fresh());
    let grown = |share: f64| growth(fresh(), Kick::Random(1e-3), share * bound, 500);
    let (above, below) = (grown(1.05), grown(0.95));
    assert!(above > 1e12, "energy times {above:.1e} at 1.05 of the bound");
    assert!(below < 0.5, "energy times {below:.1e} at 0.95 of the bound");
}

/// Local damping brakes the fastest mode harder, so that this overshoots at
/// shorter steps; the bound counts it.
#[test]
fn local_damping_lowers_the_bound() {
    let packing = settled();
    let fresh = |damping: f64| {
        let mut coupled = saturated(&packing, SYRUP, damping);
        let bound = bound(&mut coupled);
        (coupled, bound)
    };
    let (undamped, plain) = fresh(0.0);
    let (damped, bound) = fresh(0.4);
    assert!((plain / bound - 1.4).abs() < 1e-9);
    assert!(growth(undamped, Kick::Mode, 1.05 * bound, 500) < 0.5);
    assert!(growth(damped, Kick::Mode, 1.05 * bound, 500) > 1e6);
    assert!(growth(fresh(0.4).0, Kick::Mode, 0.95 * bound, 500) < 0.5);
    assert!(growth(fresh(0.4).0, Kick::Random(1e-3), 0.95 * bound, 500) < 0.5);
}

/// A servo that holds a wall yields to the fluid, and the spheres feel that: a
/// step that is stable between fixed walls is not when y_min is held.
#[test]
fn a_wall_held_by_a_servo_lowers_the_bound() {
    let packing = settled();
    let held = || {
        let mut coupled = saturated(&packing, SYRUP, 0.0);
        let control = WallControl::Servo {
            stress: coupled.dem().wall_stress(WallId::YMin),
            max_velocity: Some(1e6),
        };
        coupled.controls().set_control(WallId::YMin, control).unwrap();
        coupled
    };
    let fixed = || saturated(&packing, SYRUP, 0.0);
    let kick = Kick::Random(1e-3);
    let (bound_held, bound_fixed) = (bound(&mut held()), bound(&mut fixed()));
    assert!(bound_held < 0.92 * bound_fixed, "{bound_held} against {bound_fixed}");
    assert!(growth(held(), kick, 1.05 * bound_held, 500) > 1e6);
    assert!(growth(fixed(), kick, 1.05 * bound_held, 500) < 0.5);
    assert!(growth(held(), kick, 0.95 * bound_held, 500) < 0.5);
}

/// One sphere wedged between six walls, as viscous as it is stiff: the smaller
/// bound times 0.8 diverges, the combined bound does not.
///
/// Its contacts are bounded by √2 √(m/k) = a (the true limit is √2 a). With
/// both bounds a, Δt² 2/a² + 4 Δt/a ≤ 4 holds up to 0.732 a; combined, the
/// bounds allow 0.618 a.
#[test]
fn stiffness_and_viscosity_add_up() {
    let wedged = Spheres { x: vec![Vec3::repeat(0.5)], r: vec![0.51], bounds: unit_box(1.0) };
    let of_unit = saturated(&wedged, 1.0, 0.0).time_step_bounds().contact;
    let viscosity = bound(&mut saturated(&wedged, 1.0, 0.0)) / of_unit;
    let fresh = || saturated(&wedged, viscosity, 0.0);
    let mut coupled = fresh();
    let viscous = bound(&mut coupled);
    let bounds = coupled.time_step_bounds();
    assert!((viscous / bounds.contact - 1.0).abs() < 1e-9, "{bounds:?}");
    assert_eq!(bounds.rule(), TimeStepRule::Both);
    assert!((bounds.limit() / viscous - 0.618).abs() < 1e-3, "{bounds:?}");
    // So slow a kick that the sphere stays wedged.
    let kick = Kick::Random(1e-9 / viscous);
    assert!(growth(fresh(), kick, 0.8 * viscous, 100) > 1e6);
    assert!(growth(fresh(), kick, bounds.limit(), 100) < 1.0);
}

/// λ_max by a plain power iteration with whole steps of the flow, and with
/// eigenvalues of the matrices by LAPACK (ARPACK of SciPy 1.10 on E, F and G
/// of this packing, μ = 1 mPa·s: 199.7046).
#[test]
fn the_fastest_mode_is_that_of_the_operators() {
    let packing = settled();
    let solver = SolverKind::default();
    let mut flow = Flow::new(&packing.x, &packing.r, packing.bounds, &fluid(1e-3), solver).unwrap();
    let mass = Particles::new(packing.x.clone(), packing.r.clone(), 2600.0).mass;
    let found = flow.viscous_mode(&mass, [false; 6], None, 0.0).unwrap().unwrap();
    assert!(found.rate < 199.71 && found.upper_rate() > 199.70, "{}", found.rate);
    assert!(found.upper_rate() < 1.03 * 199.7046, "{}", found.upper_rate());

    let mut random = Random(1);
    let mut velocity: Vec<Vec3> = mass.iter().map(|_| random.vector()).collect();
    let mut rate = 0.0;
    for _ in 0..60 {
        flow.solve(&velocity, &[0.0; 6]).unwrap();
        let energy: f64 = velocity.iter().zip(&mass).map(|(v, m)| m * v.norm_squared()).sum();
        let power: f64 = velocity.iter().zip(flow.force()).map(|(v, f)| -v.dot(f)).sum();
        rate = power / energy;
        for ((v, f), m) in velocity.iter_mut().zip(flow.force()).zip(&mass) {
            *v = -f / (*m * rate);
        }
    }
    assert!((rate / 199.7046 - 1.0).abs() < 0.02, "{rate}");
}

/// The rate goes with μ / (ρ d²), so the ratio of eq. A.11 to the true bound
/// is the packing's own: 0.5908 for the shipped one (eigenvalue as above).
#[test]
fn equation_a11_is_on_the_safe_side_for_the_papers_packing() {
    let packing = settled();
    for viscosity in [1e-3, SYRUP] {
        let mut coupled = saturated(&packing, viscosity, 0.0);
        let ratio = {
            let bound = bound(&mut coupled);
            coupled.time_step_bounds().viscous_estimate.unwrap() / bound
        };
        assert!((ratio / 0.5908 - 1.0).abs() < 0.03, "{ratio}");
    }
}

/// A settled packing of 300 spheres, saturated: `sizes` is the rest of the
/// cloud's table.
fn packed(sizes: &str, stress: f64) -> String {
    format!(
        r#"
        [box]
        min = [0, 0, 0]
        max = [1, 1, 1]
        [particles]
        cloud = {{ count = 300, porosity = 0.95, {sizes} }}
        [dem]
        dt = "auto"
        damping = 0.2
        [fluid]
        viscosity = 3e4
        pressure = {{ y_max = 0.0 }}
        remesh_interval = 20
        [[stage]]
        kind = "compact"
        stress = {stress}
        friction_angle = 3.0
        [[stage]]
        kind = "run"
        steps = 200
        [stage.walls]
        y_min = {{ stress = {stress} }}
        x_max = {{ velocity = -0.01 }}
        "#
    )
}

/// The bounds that the first coupled step goes by.
fn first_bounds(text: &str) -> dempfv::coupling::TimeStepBounds {
    let mut simulation = start(text);
    while simulation.stage_steps() == 0 || simulation.outcomes().is_empty() {
        simulation.advance().unwrap();
    }
    simulation.time_step_bounds().unwrap()
}

/// Where radii are equal, eq. A.11 allows more than is stable, the more the
/// denser the packing; where they spread over 5:1 it wastes steps. So the true
/// bound must rule.
#[test]
fn equation_a11_may_lie_on_either_side() {
    let ratio = |text: &str| {
        let bounds = first_bounds(text);
        bounds.viscous_estimate.unwrap() / bounds.viscous.unwrap()
    };
    let (loose, dense) = (ratio(&packed("spread = 0.0", 1e3)), ratio(&packed("spread = 0.0", 2e4)));
    assert!(loose > 1.0 && dense > 1.5 * loose, "equal radii: {loose}, {dense}");
    let wide = ratio(&packed("spread = 0.6667", 1e3));
    assert!(wide < 0.5, "radii of 5:1: {wide}");
}

/// With dt = "auto" a viscous packing is stepped by its network's bound, new
/// at each remesh, also after a restart: the same bits.
#[test]
fn the_automatic_step_follows_the_network_and_survives_a_restart() {
    let text = packed("spread = 0.0", 1e4);
    let mut simulation = start(&text);
    let mut saved: Vec<SimulationState> = vec![];
    let mut steps = vec![];
    while simulation.stage().is_some() {
        let wet = simulation.outcomes().len() == 1;
        if wet && [0, 20, 33, 50, 51].contains(&simulation.stage_steps()) {
            saved.push(simulation.state());
        }
        simulation.advance().unwrap();
        if wet {
            let bounds = simulation.time_step_bounds().unwrap();
            assert!((simulation.dt() / (0.8 * bounds.limit()) - 1.0).abs() < 1e-12);
            assert_eq!(bounds.rule(), TimeStepRule::Viscosity);
            steps.push(simulation.dt());
        }
    }
    assert!(simulation.coupled().dem().kinetic_energy() < 1.0, "it blew up");
    steps.dedup();
    assert_eq!(steps.len(), 10, "one step for each network");
    let end = simulation.state_hash();
    let file = std::env::temp_dir().join(format!("dempfv-stability-{}", std::process::id()));
    for state in saved {
        checkpoint::save(&file, &state).unwrap();
        let read: SimulationState = checkpoint::load(&file).unwrap();
        let at = read.step();
        let mut again = Simulation::restart(plan(&text), read).unwrap();
        while again.advance().unwrap() {}
        assert_eq!(again.state_hash(), end, "from step {at}");
    }
    std::fs::remove_file(&file).unwrap();
}

/// [`packed`] equal spheres, with other keys for when to remesh.
fn remeshed(keys: &str) -> String {
    packed("spread = 0.0", 1e4).replace("remesh_interval = 20", keys)
}

/// The state before the first coupled step.
fn compacted(text: &str) -> SimulationState {
    let mut simulation = start(text);
    while simulation.outcomes().is_empty() {
        simulation.advance().unwrap();
    }
    simulation.state()
}

/// With networks from the background the step is that of the network in use,
/// new at each swap: the same bits for any number of threads, whoever builds,
/// and after a restart wherever in the interval. Positions are taken 10, 30,
/// ... steps into the stage, and their networks come into use 10 steps later.
#[test]
fn the_automatic_step_follows_networks_from_the_background() {
    let all = "remesh_interval = 20\nremesh = \"background\"\nparallel_tasks = true";
    let ahead = "remesh_interval = 20\nremesh = \"ahead\"";
    let begin = compacted(&remeshed(all));
    let course = |keys: &str, from: SimulationState, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = Simulation::restart(plan(&remeshed(keys)), from).unwrap();
            let (mut steps, mut states) = (vec![], vec![]);
            while simulation.advance().unwrap() {
                steps.push(simulation.dt().to_bits());
                if [5, 10, 11, 19, 20, 21, 33, 50, 51].contains(&simulation.stage_steps()) {
                    states.push(simulation.state());
                }
                let mode = simulation.coupled().viscous_mode().unwrap();
                let bound = simulation.time_step_bounds().unwrap().viscous.unwrap();
                assert!((bound * 1.2 * mode.upper_rate() - 2.0).abs() < 1e-12);
            }
            (steps, states, simulation.state_hash(), simulation.remeshes())
        })
    };
    let (steps, states, end, networks) = course(all, begin.clone(), 1);
    assert_eq!(networks, 10);
    let mut different = steps.clone();
    different.dedup();
    assert_eq!(different.len(), 10, "one step for each network");
    for (keys, threads) in [(all, 2), (all, 3), (ahead, 2)] {
        let (found, _, hash, _) = course(keys, begin.clone(), threads);
        assert!(found == steps && hash == end, "{keys}, {threads} threads");
    }
    let done = begin.step();
    for state in states {
        let at = (state.step() - done) as usize;
        let (found, _, hash, remeshes) = course(all, state, 2);
        assert!(found == steps[at..] && hash == end, "restarted {at} steps into the stage");
        assert_eq!(remeshes, 10);
    }
}

/// Where the background decides when a network comes into use, a step still
/// goes by the bound of the network that it uses, and nothing waits forever.
#[test]
fn the_automatic_step_keeps_up_with_a_background_that_decides() {
    for keys in [
        "remesh_interval = 1\nremesh = \"background\"\nswap = \"when ready\"",
        "remesh_interval = \"auto\"\nremesh = \"background\"",
        "remesh_interval = \"auto\"\nremesh = \"background\"\nswap = \"when ready\"",
    ] {
        for tasks in [false, true] {
            let text = remeshed(&format!("{keys}\nparallel_tasks = {tasks}"));
            let mut simulation = Simulation::restart(plan(&text), compacted(&text)).unwrap();
            while simulation.advance().unwrap() {
                let mode = simulation.coupled().viscous_mode().expect("of the network in use");
                let bounds = simulation.time_step_bounds().unwrap();
                let bound = bounds.viscous.unwrap();
                assert!((bound * 1.2 * mode.upper_rate() - 2.0).abs() < 1e-12);
                assert!((simulation.dt() / (0.8 * bounds.limit()) - 1.0).abs() < 1e-12);
            }
        }
    }
}

/// What `dempfv check` tells: the spheres of the fastest mode by the user's
/// numbers, the places in the file. The six that ARPACK finds (as above) carry
/// 11 to 8 % of its energy each; the next has 5 %.
#[test]
fn the_spheres_of_the_fastest_mode_are_named() {
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-1000.txt");
    let text = format!(
        r#"
        [particles]
        packing = "{packing}"
        [dem]
        [fluid]
        viscosity = 1e-3
        pressure = {{ y_max = 0.0 }}
        [[stage]]
        kind = "run"
        steps = 1
        "#
    );
    let found = Stability::of(&plan(&text)).unwrap().unwrap();
    assert!(!found.carriers.is_empty());
    for (sphere, share) in &found.carriers {
        assert!([28, 937, 164, 493, 572, 779].contains(sphere), "{found:?}");
        assert!((0.06..0.14).contains(share), "{found:?}");
    }
    assert!((found.bounds.viscous.unwrap() * 1.2 * found.viscous_rate - 2.0).abs() < 1e-12);
    assert_eq!(found.pores, 5685);
}
