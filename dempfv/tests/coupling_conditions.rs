//! What is imposed on the fluid of a coupled run beside constant pressures of walls.

mod common;
mod moving;

use common::settled;
use dempfv::coupling::{Acceleration, Coupled, FluidEffects, RemeshMode, Saturation, Update};
use dempfv::pfv::terms::PoreSource;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, ImposedPressure, PoreSelection};
use dempfv::scene::Plan;
use dempfv::solver::SolverKind;
use dempfv::{PerWall, TimeFunction, Vec3, WallId};
use moving::{bits, dem_of, every};

const DT: f64 = 1e-5;

fn between(low: f64, high: f64) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(low);
    boundary.pressure[WallId::YMax] = Some(high);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

/// The settled packing in a fluid with these effects, a new network every 7 steps.
fn coupled(effects: FluidEffects, acceleration: Acceleration) -> Coupled {
    let mut coupled = Coupled::new(dem_of(settled()));
    let (fluid, solver) = (between(1.0, 0.0), SolverKind::default());
    coupled.saturate(Saturation { fluid, solver, remesh: every(7) });
    coupled.set_fluid_effects(effects);
    coupled.accelerate(acceleration);
    coupled
}

fn sine() -> TimeFunction {
    TimeFunction::Sine { mean: 1.0, amplitude: 0.5, frequency: 0.1 / DT }
}

/// A wall whose pressure is a sine has in each step the value at its end: in its pores and in the flow
/// through them, with each way to renew networks; and a restart has the same bits.
#[test]
fn a_wall_follows_its_pressure() {
    let mut wall_pressure = PerWall::from_fn(|_| None);
    wall_pressure[WallId::YMin] = Some(sine());
    for bulk_modulus in [None, Some(1e6)] {
        let effects = FluidEffects {
            wall_pressure: wall_pressure.clone(),
            bulk_modulus,
            ..Default::default()
        };
        for acceleration in [
            Acceleration::default(),
            Acceleration { update: Update::EveryStep, ..Acceleration::default() },
            Acceleration { remesh: RemeshMode::Ahead, ..Acceleration::default() },
        ] {
            let mut whole = coupled(effects.clone(), acceleration);
            let mut course = vec![];
            for step in 1..=20 {
                whole.step(DT).unwrap();
                course.push(bits(&whole));
                let flow = whole.storage_flow().unwrap();
                let conditions = flow.operators().conditions();
                let expected = sine().value(whole.model_time());
                assert_eq!(conditions.pressures()[WallId::YMin.index()], Some(expected));
                let of_wall = |i: &usize| conditions.set_of(*i) == Some(WallId::YMin.index());
                let pores = (0..flow.network().pores()).filter(of_wall);
                assert!(pores.into_iter().all(|i| flow.pressure()[i] == expected), "{step}");
                assert!(flow.imbalance() < 1e-6, "{step}: {}", flow.imbalance());
            }
            for stop in [3, 7, 12] {
                let mut first = coupled(effects.clone(), acceleration);
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

/// Pressures of points and what enters regions follow their functions too, constant, ramp and sine, with
/// each way to renew networks; what enters leaves or is stored; and a restart has the same bits.
#[test]
fn points_and_regions_follow_their_functions() {
    let b = settled().bounds;
    let at = |y: f64| b.min + Vec3::new(0.5, y, 0.5).component_mul(&b.size());
    let ball = |y: f64| PoreSelection::Around { center: at(y), radius: 0.1 * b.size().y };
    let points = PoreSelection::At(vec![at(0.2), at(0.25)]);
    let ramp = TimeFunction::Ramp(vec![[0.0, 0.0], [5.0 * DT, 2e-9], [9.0 * DT, -1e-9]]);
    let effects = FluidEffects {
        imposed: vec![
            ImposedPressure { pores: ball(0.8), pressure: 0.25 },
            ImposedPressure { pores: points, pressure: sine().value(0.0) },
        ],
        imposed_in_time: vec![None, Some(sine())],
        sources: vec![
            PoreSource { pores: ball(0.5), rate: 0.0 },
            PoreSource { pores: PoreSelection::At(vec![at(0.6)]), rate: 1e-9 },
        ],
        sources_in_time: vec![Some(ramp.clone())],
        ..Default::default()
    };
    for acceleration in [
        Acceleration::default(),
        Acceleration { update: Update::EveryStep, ..Acceleration::default() },
        Acceleration { remesh: RemeshMode::Ahead, parallel_tasks: true, ..Acceleration::default() },
    ] {
        let mut whole = coupled(effects.clone(), acceleration);
        let mut course = vec![];
        for step in 1..=20 {
            whole.step(DT).unwrap();
            course.push(bits(&whole));
            let (flow, time) = (whole.storage_flow().unwrap(), whole.model_time());
            let conditions = flow.operators().conditions();
            assert_eq!(conditions.pressures()[6..8], [Some(0.25), Some(sine().value(time))]);
            let swallowed: f64 = flow.volume_rate().iter().sum();
            let through: f64 = flow.flux().iter().chain(&flow.imposed_flux()).sum();
            let rate = ramp.value(time) + 1e-9;
            let size: f64 = flow.flux().iter().map(|q| q.abs()).sum();
            let lost = rate + through - swallowed;
            assert!(lost.abs() < 1e-6 * size, "step {step}: {lost:e} of {size:e}");
        }
        for stop in [3, 7, 12] {
            let mut first = coupled(effects.clone(), acceleration);
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

/// Static flow is linear: with the pressure of a wall the flux through a packing goes in proportion,
/// to 1e-9, from one factor.
#[test]
fn flux_goes_with_the_pressure_of_a_wall() {
    let s = settled();
    let solver = SolverKind::Cholmod;
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &between(1.0, 0.0), solver).unwrap();
    flow.solve_static().unwrap();
    let unit = flow.permeability(WallId::YMin).unwrap();
    for pressure in [3.0, -0.25, 1e5] {
        flow.set_wall_pressure(WallId::YMin, pressure).unwrap();
        flow.solve_static().unwrap();
        let now = flow.permeability(WallId::YMin).unwrap();
        assert!((now.flux / unit.flux / pressure - 1.0).abs() < 1e-9, "{pressure}");
        assert!((now.value / unit.value - 1.0).abs() < 1e-9, "{pressure}");
    }
}

/// Water that is pumped into the middle of a packing at rest between two drained walls leaves through
/// both: flux in is flux out, to 1e-12 of it beside what the spheres displace.
#[test]
fn what_is_pumped_in_leaves_through_the_walls() {
    let s = settled();
    let rate = 1e-9;
    let ball = PoreSelection::Around { center: s.bounds.center(), radius: 0.1 * s.bounds.size().y };
    let sources = vec![PoreSource { pores: ball, rate }];
    let mut coupled =
        coupled(FluidEffects { sources, ..Default::default() }, Acceleration::default());
    coupled.set_tolerance(1e-13).unwrap();
    for step in 0..20 {
        coupled.step(DT).unwrap();
        let flow = coupled.storage_flow().unwrap();
        let swallowed: f64 = flow.volume_rate().iter().sum();
        let flux = flow.flux();
        let out: f64 = -flux.iter().sum::<f64>();
        let size: f64 = flux.iter().map(|q| q.abs()).sum();
        let lost = rate - out - swallowed;
        assert!(lost.abs() < 1e-12 * size, "step {step}: {lost:e} of {size:e}");
    }
}

/// Pores whose centroids lie in a box keep the pressure that is imposed there, in each network.
#[test]
fn regions_keep_their_pressure() {
    let s = settled();
    let (middle, size) = (s.bounds.center(), s.bounds.size());
    let (min, max) = (middle - 0.1 * size, middle + 0.1 * size);
    let imposed =
        vec![ImposedPressure { pores: PoreSelection::Within { min, max }, pressure: 7.0 }];
    let mut coupled =
        coupled(FluidEffects { imposed, ..Default::default() }, Acceleration::default());
    for _ in 0..15 {
        coupled.step(DT).unwrap();
        let flow = coupled.storage_flow().unwrap();
        let set = |i: &usize| flow.operators().conditions().set_of(*i) == Some(6);
        let pores: Vec<usize> = (0..flow.network().pores()).filter(set).collect();
        assert!(pores.len() > 10 && pores.iter().all(|&i| flow.pressure()[i] == 7.0));
        assert!(flow.imposed_flux()[0] > 0.0);
    }
}

/// The keys of these conditions, and what is wrong with some: with its line, and what would be right.
#[test]
fn conditions_of_a_scene_are_read_and_written() {
    let scene = |fluid: &str| {
        format!(
            "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\n\
             cloud = {{ count = 9, radius = 0.01 }}\n[dem]\n[fluid]\nviscosity = 1\n{fluid}\n\
             [[stage]]\nkind = \"run\"\nsteps = 1\n"
        )
    };
    let ramp = "pressure = { y_min = { ramp = [[0.0, 1.0], [2.0, 5.0]] }, y_max = 0.0 }";
    let swing = "pressure = { y_min = { mean = 1.0, amplitude = 2.0, frequency = 0.5 } }";
    let profile = "pressure = { y_min = { along = \"x\", points = [[0.0, 2.0], [1.0, 3.0]], plus = { ramp = \
                   [[0.0, 1.0], [2.0, 5.0]] } }, y_max = 0.0 }\nsources = [{ points = [[0.5, 0.5, 0.5]], rate = \
                   { mean = 0.0, amplitude = 1.0, frequency = 2.0 } }]\nblocked = [{ center = [0.1, 0.1, 0.1], \
                   radius = 0.05 }]\nconductance_regions = [{ min = [0.7, 0.7, 0.7], max = [0.9, 0.9, 0.9], \
                   factor = 2.0 }]\nconductance_factor = 0.5\ndarcy_permeability = 1e-9\ncoupling = \"one-way\"";
    for fluid in [ramp, swing, profile] {
        let plan = Plan::from_toml(&scene(fluid), None).unwrap();
        assert_eq!(Plan::from_toml(&plan.to_toml(), None).unwrap(), plan);
        assert!(plan.effects_on().contains(&"conditions in time"));
        assert_eq!(plan.fluid.unwrap().fluid.boundary.pressure[WallId::YMin], Some(1.0));
    }
    let closed = "imposed = [{ center = [0.5, 0.5, 0.5], radius = 0.1, pressure = 1.0 }]";
    Plan::from_toml(&scene(closed), None).unwrap();
    for (wrong, says) in [
        ("pressure = { y_min = { ramp = [[1.0, 1.0], [0.0, 5.0]] } }", "each later"),
        ("pressure = { y_min = { ramp = [] } }", "one or more points"),
        (
            "pressure = { y_min = { mean = 1.0, amplitude = 2.0, frequency = 0.0 } }",
            "above 0 in Hz",
        ),
        ("pressure = { y_min = { mean = 1.0 } }", "amplitude"),
        ("pressure = { y_min = { ramp = [[0.0, 1.0]], mean = 1.0 } }", "a ramp or a sine"),
        ("sources = [{ center = [0.5, 0.5, 0.5], rate = 1.0 }]", "radius"),
        ("sources = [{ rate = 1.0 }]", "`center` and `radius`, or `min` and `max`"),
        ("sources = [{ min = [1, 0, 0], max = [1, 1, 1], rate = 1.0 }]", "above `min`"),
        ("sources = [{ points = [], rate = 1.0 }]", "one or more finite points"),
        ("blocked = [{ points = [[0.5, 0.5, 0.5]], center = [0.5, 0.5, 0.5] }]", "not one ball"),
        ("blocked = [{ points = [[0.5, 0.5, 0.5]], pressure = 1.0 }]", "pressure"),
        ("conductance_regions = [{ points = [[0.5, 0.5, 0.5]], factor = 0.0 }]", "above 0"),
        ("conductance_factor = 0.0", "above 0"),
        ("darcy_permeability = -1.0", "above 0 in m²"),
        ("coupling = \"both\"", "one-way"),
        ("pressure = { y_min = { along = \"y\", points = [[0.0, 1.0]] } }", "normal to"),
        ("pressure = { y_min = { along = \"x\", points = [] } }", "no function of the coordinate"),
        ("pressure = { y_min = { along = \"x\", points = [[0.0]] } }", "[coordinate, pressure]"),
        ("pressure = { y_min = { along = \"x\" } }", "points"),
    ] {
        let error =
            Plan::from_toml(&scene(&format!("bulk_modulus = 1e6\n{wrong}")), None).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(says) && error.line == Some(10), "{wrong}: {text}");
    }
}

/// A caller who says before each step what a function of time says gets its bits, through remeshes of
/// each kind: of walls and of regions.
#[test]
fn pressures_that_are_given_are_those_of_functions() {
    let bounds = settled().bounds;
    let region = PoreSelection::Around { center: bounds.center(), radius: 0.1 * bounds.size().y };
    let imposed = vec![ImposedPressure { pores: region, pressure: 1.0 }];
    let constant = FluidEffects { imposed, ..FluidEffects::default() };
    let mut in_time = constant.clone();
    in_time.wall_pressure[WallId::YMin] = Some(sine());
    in_time.imposed_in_time = vec![Some(sine())];
    for acceleration in [
        Acceleration::default(),
        Acceleration { update: Update::EveryStep, ..Acceleration::default() },
        Acceleration { remesh: RemeshMode::Ahead, ..Acceleration::default() },
    ] {
        let mut expected = coupled(in_time.clone(), acceleration);
        let mut given = coupled(constant.clone(), acceleration);
        let mut untold = coupled(constant.clone(), acceleration);
        for step in 1..=20 {
            let pressure = sine().value(given.model_time() + DT);
            given.controls().set_wall_pressure(WallId::YMin, pressure).unwrap();
            given.controls().set_imposed_pressure(0, pressure).unwrap();
            for coupled in [&mut expected, &mut given, &mut untold] {
                coupled.step(DT).unwrap();
            }
            assert_eq!(bits(&given), bits(&expected), "{acceleration:?} {step}");
        }
        assert_ne!(bits(&given), bits(&untold));
    }
}
