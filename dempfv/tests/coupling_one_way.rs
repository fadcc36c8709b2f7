//! A flow that pushes spheres whose motion squeezes no fluid, and one through spheres at rest.

mod common;
mod moving;

use common::settled;
use dempfv::coupling::{Acceleration, Coupled, FluidEffects, RemeshMode, Saturation, Update};
use dempfv::dem::WallControl;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{PerWall, TimeFunction, WallId};
use moving::{bits, dem_of, every};

const DT: f64 = 1e-5;

fn upwards() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(100.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

/// The settled packing under this flow, squeezed by a wall beside it.
fn squeezed(effects: FluidEffects, acceleration: Acceleration) -> Coupled {
    let mut coupled = Coupled::new(dem_of(settled()));
    let (fluid, solver) = (upwards(), SolverKind::Cholmod);
    coupled.saturate(Saturation { fluid, solver, remesh: every(10) });
    coupled.set_fluid_effects(effects);
    coupled.accelerate(acceleration);
    coupled.controls().set_control(WallId::XMax, WallControl::Velocity(-0.05)).unwrap();
    coupled
}

fn one_way() -> FluidEffects {
    FluidEffects { one_way: true, ..FluidEffects::default() }
}

/// The pressures of each network are those of a static flow through the same spheres, and stay while
/// these move: none is above the 100 Pa of a wall, as they are where the other wall's 5 cm/s squeeze
/// the water, with the two-way coupling.
#[test]
fn motion_squeezes_no_fluid() {
    let mut coupled = squeezed(one_way(), Acceleration::default());
    let mut solved = vec![];
    for step in 0..30 {
        let positions = coupled.dem().storage().clone();
        let bounds = coupled.dem().box_();
        coupled.step(DT).unwrap();
        let flow = coupled.storage_flow().unwrap();
        assert!(flow.volume_rate().iter().all(|v| *v == 0.0));
        if step % 10 == 0 {
            let (x, r) = (&positions.position, &positions.radius);
            let mut fresh = Flow::new(x, r, bounds, &upwards(), SolverKind::Cholmod).unwrap();
            fresh.solve_static().unwrap();
            let pairs = flow.pressure().iter().zip(fresh.pressure());
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9 * 100.0, "step {step}: {off:e}");
            solved = flow.pressure().to_vec();
        }
        assert_eq!(flow.pressure(), solved, "step {step}");
        assert!(flow.imbalance() < 1e-11);
    }
    assert_eq!(coupled.remeshes(), 3);
    let mut both = squeezed(FluidEffects::default(), Acceleration::default());
    (0..3).for_each(|_| both.step(DT).unwrap());
    let highest = both.storage_flow().unwrap().pressure().iter().fold(0.0f64, |m, p| m.max(*p));
    assert!(highest > 101.0, "{highest}");
}

/// The spheres feel the flow: forces are those of the pressures, and move them otherwise than without.
/// Since no motion makes a force, viscosity sets no bound to the time step, however large it is.
#[test]
fn the_flow_pushes_and_sets_no_bound() {
    let mut coupled = squeezed(one_way(), Acceleration::default());
    coupled.step(DT).unwrap();
    let lift: f64 = coupled.fluid_force().iter().map(|f| f.y).sum();
    let area = coupled.dem().box_().wall_area(WallId::YMin);
    assert!(lift > 0.5 * 100.0 * area, "{lift} of {}", 100.0 * area);
    let syrup = Fluid { viscosity: 1e6, ..upwards() };
    let solver = SolverKind::Cholmod;
    coupled.saturate(Saturation { fluid: syrup, solver, remesh: every(10) });
    assert!(!coupled.update_viscous_mode(true).unwrap());
    let bounds = coupled.time_step_bounds();
    assert_eq!((bounds.viscous, bounds.viscous_estimate), (None, None));
    assert_eq!(coupled.step_auto(0.8).unwrap(), bounds.automatic(0.8));
}

/// A run that is stored and taken up goes on with the same bits, with each way to renew networks, a
/// compressible fluid and a pressure that swings.
#[test]
fn a_restart_has_the_same_bits() {
    let swing = TimeFunction::Sine { mean: 100.0, amplitude: 50.0, frequency: 0.05 / DT };
    let mut wall_pressure = PerWall::from_fn(|_| None);
    wall_pressure[WallId::YMin] = Some(swing);
    let plain = one_way();
    let swinging = FluidEffects { wall_pressure, bulk_modulus: Some(1e6), ..one_way() };
    for effects in [plain, swinging] {
        for acceleration in [
            Acceleration::default(),
            Acceleration { update: Update::EveryStep, ..Acceleration::default() },
            Acceleration { remesh: RemeshMode::Ahead, ..Acceleration::default() },
            Acceleration { parallel_tasks: true, ..Acceleration::default() },
        ] {
            let mut whole = squeezed(effects.clone(), acceleration);
            let mut course = vec![];
            for _ in 0..25 {
                whole.step(DT).unwrap();
                course.push(bits(&whole));
            }
            for stop in [1, 7, 10, 16] {
                let mut first = squeezed(effects.clone(), acceleration);
                (0..stop).for_each(|_| first.step(DT).unwrap());
                let mut again = Coupled::from_state(first.state()).unwrap();
                assert_eq!(again.observe(), first.observe(), "{acceleration:?} {stop}");
                for (step, expected) in course.iter().enumerate().skip(stop) {
                    again.step(DT).unwrap();
                    assert_eq!(bits(&again), *expected, "{acceleration:?} {stop} {step}");
                }
            }
        }
    }
}

/// The fluid alone: spheres stay where they are, a compressible fluid comes to the pressures of the
/// steady flow, and what enters is stored or leaves in each step, to 1e-11.
#[test]
fn a_compressible_fluid_comes_to_its_steady_flow() {
    let s = settled();
    let start = |effects: FluidEffects| {
        let mut coupled = Coupled::new(dem_of(settled()));
        let (fluid, solver) = (upwards(), SolverKind::Cholmod);
        coupled.saturate(Saturation { fluid, solver, remesh: every(1000) });
        coupled.set_fluid_effects(effects);
        coupled
    };
    let mut coupled = start(FluidEffects { bulk_modulus: Some(1e6), ..Default::default() });
    // c = k K_f / (n mu), with k of this packing (docs/yade.md): 1.57e-5 of the height squared.
    let diffusion = 1e-3 * 0.417 / (1.574e-5 * 1e6);
    let mut entering = vec![];
    for _ in 0..40 {
        coupled.step_fluid(0.05 * diffusion).unwrap();
        let flow = coupled.storage_flow().unwrap();
        assert!(flow.imbalance() < 1e-11, "{:e}", flow.imbalance());
        entering.push(flow.flux()[WallId::YMin.index()]);
    }
    let mut steady = start(FluidEffects::default());
    steady.step_fluid(0.0).unwrap();
    assert_eq!(steady.model_time(), 0.0);
    assert!(coupled.step_fluid(0.0).is_err());
    let expected = steady.storage_flow().unwrap();
    let flow = coupled.storage_flow().unwrap();
    let pairs = flow.pressure().iter().zip(expected.pressure());
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // exp(-pi^2 c t / H^2) at twice the time of diffusion, and the half step of the first.
    assert!(off < 1e-6 * 100.0, "{off:e}");
    assert!(entering[0] > 1.5 * entering[39], "{entering:?}");
    for (number, x) in s.x.iter().enumerate() {
        assert_eq!(coupled.dem().position(number), *x);
    }
    assert_eq!((coupled.steps(), coupled.remeshes()), (40, 1));
}
