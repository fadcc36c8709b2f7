//! Contacts and flow together in a periodic cell: sheared, driven by a gradient, undrained.

mod cell_support;
mod coupling_support;

use cell_support::{FLUID, settled};
use coupling_support::{finish, start};
use dempfv::coupling::{
    Acceleration, Coupled, CoupledState, FluidEffects, RemeshMode, RemeshRule, Saturation, Update,
};
use dempfv::dem::{CellControl, CellControls, Dem};
use dempfv::io::checkpoint;
use dempfv::pfv::ImposedPressure;
use dempfv::simulation::{Simulation, SimulationState};
use dempfv::solver::SolverKind;
use dempfv::{Tensor, Vec3};

const REMESH: RemeshRule = RemeshRule { interval: Some(20), strain: None };

fn wet(dem: Dem, effects: FluidEffects) -> Coupled {
    let mut coupled = Coupled::new(dem);
    let solver = SolverKind::default();
    coupled.saturate(Saturation { fluid: FLUID, solver, remesh: REMESH });
    coupled.set_fluid_effects(effects);
    coupled
}

fn rates(gradient: Tensor) -> CellControls {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| CellControl::Rate(gradient[(a, b)])))
}

const GRADIENT: Vec3 = Vec3::new(2e3, -1e3, 5e2);
const SHEAR: Tensor = Tensor::new(0.2, 1.0, 0.0, 0.0, -0.3, 0.4, 0.0, 0.0, 0.1);

fn sheared() -> Coupled {
    let effects = FluidEffects { pressure_gradient: Some(GRADIENT), ..FluidEffects::default() };
    let mut coupled = wet(settled(1), effects);
    coupled.controls().track_energy(true);
    coupled.controls().set_cell_controls(rates(SHEAR)).unwrap();
    coupled
}

fn step(coupled: &mut Coupled, steps: u64) {
    for _ in 0..steps {
        coupled.step(5e-6).unwrap();
    }
}

/// A cell that is sheared while fluid is driven through: the fluid's forces leave the spheres' centre
/// of mass where it is, no fluid is lost, and the energy of the spheres is what cell and fluid did,
/// within 1e-6 of all that was moved.
#[test]
fn a_sheared_cell_with_flow_is_balanced() {
    let mut coupled = sheared();
    // Local damping takes momentum, and growth has left some.
    coupled.controls().set_damping(0.0).unwrap();
    coupled.controls().storage_velocities_mut().0.fill(Vec3::zeros());
    coupled.controls().track_energy(true);
    let mut size = 0.0f64;
    for _ in 0..10 {
        step(&mut coupled, 30);
        let force = coupled.fluid_force();
        size = size.max(force.iter().map(|f| f.norm()).sum());
        assert!(force.iter().sum::<Vec3>().norm() < 1e-12 * size);
    }
    assert!(coupled.largest_imbalance() < 1e-9, "{:e}", coupled.largest_imbalance());
    assert_eq!(coupled.remeshes(), 15);
    let p = coupled.dem().storage();
    let moved: f64 = p.mass.iter().zip(&p.velocity).map(|(m, v)| m * v.norm()).sum();
    assert!(coupled.dem().momentum().norm() < 1e-9 * moved, "{}", coupled.dem().momentum());
    // Against the gradient.
    let velocity = coupled.observe_cell().unwrap().fluid_velocity;
    assert!(velocity.dot(&GRADIENT) < 0.0, "{velocity}");
    let b = coupled.dem().energy_balance().unwrap();
    println!("{b:?}");
    assert!(b.cell_work.abs() > 1e-9 && b.fluid_work.abs() > 1e-12, "{b:?}");
    assert!(b.residual.abs() < 1e-5 * b.moved(), "{:e}", b.residual / b.moved());
}

/// Without another force than that of the fluid, spheres in a uniform translation feel nothing, and a
/// viscous force is the same in any frame: a run with all velocities raised by one has the same
/// pressures.
#[test]
fn pressures_are_those_of_any_frame() {
    let run = |velocity: Vec3| {
        let mut coupled = wet(settled(2), FluidEffects::default());
        coupled.controls().set_cell_controls(rates(SHEAR)).unwrap();
        let mut controls = coupled.controls();
        let (c, _) = controls.storage_velocities_mut();
        c.iter_mut().for_each(|c| *c += velocity);
        coupled.step(5e-6).unwrap();
        coupled.storage_flow().unwrap().pressure().to_vec()
    };
    let (still, moving) = (run(Vec3::zeros()), run(Vec3::new(0.3, 0.2, -0.1)));
    let largest = still.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    assert!(largest > 0.0);
    for (a, b) in still.iter().zip(&moving) {
        assert!((a - b).abs() < 1e-9 * largest, "{a} {b} {largest}");
    }
}

/// Undrained: a cell that loses volume presses on the fluid by K_f ΔV over the volume of the pores.
#[test]
fn a_closing_cell_raises_the_pressure_by_the_bulk_modulus() {
    let modulus = 1e6;
    let effects = FluidEffects { bulk_modulus: Some(modulus), ..FluidEffects::default() };
    let mut coupled = wet(settled(3), effects);
    let before = coupled.dem().volume();
    coupled.controls().set_cell_controls(rates(-0.5 * Tensor::identity())).unwrap();
    step(&mut coupled, 1);
    let network = coupled.storage_flow().unwrap().network().clone();
    let dem = coupled.dem();
    let solid = before * dem.porosity();
    step(&mut coupled, 99);
    let change = before - coupled.dem().volume();
    // Pores that overlaps make smaller than their spheres' shares store nothing: void volumes count.
    let pressure = coupled.mean_pressure();
    let expected = modulus * change / solid;
    println!("{pressure} {expected} {}", network.pores());
    assert!((pressure / expected - 1.0).abs() < 0.02, "{pressure} {expected}");
}

/// The same bits from a state, and with any number of threads.
#[test]
fn states_and_threads_do_not_count() {
    for remesh in RemeshMode::ALL {
        let run = |threads: usize, stop: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut coupled = sheared();
                coupled.accelerate(Acceleration { remesh, ..Acceleration::default() });
                step(&mut coupled, 47);
                if stop {
                    let stored = postcard::to_stdvec(&coupled.state()).unwrap();
                    let state: CoupledState = postcard::from_bytes(&stored).unwrap();
                    coupled = Coupled::from_state(state).unwrap();
                }
                step(&mut coupled, 53);
                postcard::to_stdvec(&coupled.state()).unwrap()
            })
        };
        let straight = run(1, false);
        assert!(run(3, false) == straight, "{remesh:?}: threads");
        assert!(run(1, true) == straight, "{remesh:?}: a state");
    }
}

/// What has no place in a cell is refused with the reason; so is a volume that an incompressible fluid
/// cannot have.
#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |effects: FluidEffects, words: &str| {
        let error = wet(settled(1), effects).step(5e-6).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let pores = dempfv::pfv::PoreSelection::Pores(vec![0]);
    let imposed = vec![ImposedPressure { pores, pressure: 1.0 }];
    refused(FluidEffects { imposed, ..FluidEffects::default() }, "in a periodic cell");
    refused(FluidEffects { density: Some(1e3), ..FluidEffects::default() }, "a fluid with weight");
    let gradient = Some(Vec3::new(f64::NAN, 0.0, 0.0));
    let effects = FluidEffects { pressure_gradient: gradient, ..FluidEffects::default() };
    refused(effects, "is not finite");
    let mut coupled = wet(settled(1), FluidEffects::default());
    coupled.accelerate(Acceleration { update: Update::EveryStep, ..Acceleration::default() });
    let error = coupled.step(5e-6).unwrap_err().to_string();
    assert!(error.contains("renew it more often"), "{error}");
    let mut coupled = wet(settled(1), FluidEffects::default());
    coupled.controls().set_cell_controls(rates(-Tensor::identity())).unwrap();
    coupled.step(5e-6).unwrap();
    let error = coupled.step(5e-6).unwrap_err().to_string();
    assert!(error.contains("deform it at constant volume"), "{error}");
}

const SCENE: &str = r#"
[cell]
edges = [[0.1, 0, 0], [0.02, 0.1, 0], [0, 0, 0.1]]
[particles]
cloud = { count = 200, spread = 0.2, porosity = 0.75 }
[dem]
[fluid]
viscosity = 1e-3
pressure_gradient = [100.0, 0.0, 0.0]
remesh_interval = 50
[[stage]]
kind = "compact"
stress = 1e4
friction_angle = 5.0
[[stage]]
kind = "permeability"
axis = "x"
[[stage]]
kind = "run"
name = "shear"
steps = 150
velocity_gradient = { xy = 2.0, xx = 0.25, yy = -0.25 }
"#;

/// A scene with flow in a cell: its permeability is that of the library, and a restart has the same
/// bits.
#[test]
fn a_scene_runs_and_restarts() {
    let mut straight = start(SCENE);
    let folder = std::env::temp_dir().join(format!("dempfv-coupling-cell-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("state");
    let mut state: Option<SimulationState> = None;
    while straight.advance().unwrap() {
        if straight.stage().is_some_and(|s| s.name == "shear") && straight.stage_steps() == 70 {
            checkpoint::save(&path, &straight.state()).unwrap();
            state = Some(checkpoint::load(&path).unwrap());
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    let plan = straight.plan().clone();
    let mut again = Simulation::restart(plan, state.unwrap()).unwrap();
    finish(&mut again);
    assert_eq!(again.state_hash(), straight.state_hash());
    let dempfv::simulation::Outcome::Permeability(test) = &straight.outcomes()[1].outcome else {
        panic!("no permeability")
    };
    let tensor = test.tensor_m2.unwrap();
    assert_eq!(tensor[0][0], test.permeability_m2);
    assert!((tensor[0][1] - tensor[1][0]).abs() < 1e-9 * tensor[0][0]);
    assert!(tensor[0][1].abs() < 0.3 * tensor[0][0]);
    let ratio = test.permeability_m2 / test.kozeny_carman_m2;
    assert!((0.3..3.0).contains(&ratio), "{ratio}");
}
