//! Consolidation: the course of settlement, and where the fluid goes.

mod coupling_support;

use coupling_support::{COMPACT, MEASURE, advance_to, finish, scene, start};
use dempfv::simulation::{Consolidation, Outcome, Simulation};
use dempfv::{Vec3, WallId};

fn oedometer(spheres: usize, until: f64) -> String {
    let stage = format!(
        r#"
        [[stage]]
        kind = "consolidate"
        wall = "y_max"
        stress = 1.1e4
        until_tv = {until}
        max_velocity = 0.1
        "#
    );
    // Cycles as in the shipped scene: the first loading settles for good, and is softer than those after
    // it; near rest, since the modulus is no better than the balance of forces.
    let slow = "cycles = 2\n max_velocity = 0.05\n unbalanced = 1e-4";
    let measure = MEASURE.replace("cycles = 1", slow);
    scene(spheres, "remesh_interval = 200", &format!("{COMPACT}{measure}{stage}"))
}

fn consolidation(simulation: &Simulation) -> &Consolidation {
    match &simulation.outcomes().last().unwrap().outcome {
        Outcome::Consolidate(c) => c,
        other => panic!("{other:?}"),
    }
}

/// Degree of consolidation at a time factor.
fn degree(c: &Consolidation, at: f64) -> f64 {
    let after = c.samples.iter().position(|s| s.time_factor >= at).unwrap();
    let (a, b) = (&c.samples[after - 1], &c.samples[after]);
    a.degree + (b.degree - a.degree) * (at - a.time_factor) / (b.time_factor - a.time_factor)
}

/// Terzaghi's theory with c_v from the modulus and the permeability that the
/// same run measured, and the layers at the walls counted: nothing is fitted.
/// The shipped scene of 1,000 spheres is held to 0.02 up to T_v = 1.5; here
/// three packings of 400 are, up to 0.5. Each is within 0.034, their mean within 0.012. Hence 0.05
/// for each, and 0.025 for the mean.
#[test]
fn settlement_follows_terzaghi() {
    let times = [0.1, 0.15, 0.2, 0.3, 0.4, 0.49];
    let mut sum = [0.0; 6];
    for seed in [1, 3, 4] {
        let text = oedometer(400, 0.5).replace("seed = 3", &format!("seed = {seed}"));
        let mut simulation = start(&text);
        finish(&mut simulation);
        let c = consolidation(&simulation);
        for (sum, &at) in sum.iter_mut().zip(&times) {
            let error = degree(c, at) - c.wall_layers().degree(at);
            assert!(error.abs() < 0.05, "seed {seed}, T_v = {at}: off by {error}");
            *sum += error;
        }
        // At first the fluid carries the load wherever it cannot yet leave.
        let first = c.samples.iter().find(|s| s.time_factor > 0.02).unwrap();
        assert!((first.base_pressure - 1.0).abs() < 0.1, "{first:?}");
    }
    for (sum, at) in sum.iter().zip(times) {
        assert!((sum / 3.0).abs() < 0.025, "T_v = {at}: off by {} on average", sum / 3.0);
    }
}

/// Drained at both ends, the way out is half the height, and T_v goes with its square: a quarter of
/// the time. The core of the packing, whose fluid cannot leave at once, then bounces between two
/// drained layers and compacts them for good (the mean of three is off by 0.059 at T_v = 0.1). With
/// eight times the viscosity and a local damping of 0.9 it does not; each is within 0.048
/// and their mean within 0.014, the pressure at mid-height within 0.031 from T_v = 0.15 on: the bounds are
/// 0.06, 0.03 and 0.05.
#[test]
fn two_drained_ends_halve_the_way() {
    let times = [0.1, 0.15, 0.2, 0.3, 0.4, 0.49];
    let mut sum = [0.0; 6];
    for seed in [1, 3, 4] {
        let text = oedometer(400, 0.5)
            .replace("seed = 3", &format!("seed = {seed}"))
            .replace("viscosity = 10.0", "viscosity = 80.0")
            .replace("pressure = { y_max = 0.0 }", "pressure = { y_max = 0.0, y_min = 0.0 }")
            .replace(
                "until_tv = 0.5",
                "dt = \"auto\"\n damping = 0.9\n until_tv = 0.5\n profiles = [0.2]",
            );
        let mut simulation = start(&text);
        finish(&mut simulation);
        let c = consolidation(&simulation);
        assert_eq!(c.drained_walls, [WallId::YMax, WallId::YMin]);
        assert_eq!(c.drainage_path_m, 0.5 * c.height_m);
        for (sum, &at) in sum.iter_mut().zip(&times) {
            let error = degree(c, at) - c.wall_layers().degree(at);
            assert!(error.abs() < 0.06, "seed {seed}, T_v = {at}: off by {error}");
            *sum += error;
        }
        let layers = c.wall_layers();
        for s in c.samples.iter().filter(|s| s.time_factor > 0.15) {
            let theory = layers.excess_pressure(1.0, s.time_factor);
            let error = s.base_pressure - theory;
            assert!(error.abs() < 0.05, "seed {seed}, mid-height: off by {error}: {s:?}");
        }
        // A profile falls from the middle to both ends.
        let p = &c.profiles[0].pressure;
        let up = p[..5].is_sorted_by(|a, b| a < b);
        assert!(up && p[5..].is_sorted_by(|a, b| a > b), "seed {seed}: {p:?}");
    }
    for (sum, at) in sum.iter().zip(times) {
        assert!((sum / 3.0).abs() < 0.03, "T_v = {at}: off by {} on average", sum / 3.0);
    }
}

/// Drained at the foot, the loaded wall first rests on fluid that cannot leave:
/// the servo must reckon with its resistance, or it jumps between its largest
/// speeds. The stress is held to 1 %, a tenth of the load, and the settlement is
/// that of one packing drained at the top (0.065, see above) once the shock of
/// the load has died away.
#[test]
fn a_load_may_rest_on_fluid() {
    let text = oedometer(400, 0.5).replace("pressure = { y_max", "pressure = { y_min");
    let mut simulation = start(&text);
    advance_to(&mut simulation, "consolidate");
    let first = simulation.step();
    while simulation.stage().is_some() {
        simulation.advance().unwrap();
        let stress = simulation.coupled().wall_stress(WallId::YMax);
        let settled = simulation.step() > first + 50;
        assert!(!settled || (stress / 1.1e4 - 1.0).abs() < 0.01, "{}: {stress}", simulation.step());
    }
    let c = consolidation(&simulation);
    for at in [0.2, 0.3, 0.4, 0.49] {
        let error = degree(c, at) - c.wall_layers().degree(at);
        assert!(error.abs() < 0.065, "T_v = {at}: off by {error}");
    }
}

/// What leaves through the drained wall is what the loaded wall displaces.
/// The fluid of a step moves with the velocities of the step before, so the
/// flux lags the settlement by one step (the first step's belongs to the stage
/// before); with that counted, nothing but round-off is left (1e-10; the
/// promise is 1e-6). At every step the fluid's
/// forces on spheres and walls add up to nothing but what spheres that reach
/// past a facet's edge cause: 1.5e-5 of the force on the top at the first step.
#[test]
fn the_settlement_is_the_volume_drained() {
    let mut simulation = start(&oedometer(150, 0.1));
    advance_to(&mut simulation, "consolidate");
    let area = simulation.coupled().dem().box_().wall_area(WallId::YMax);
    let start = simulation.observe().size[1];
    let (mut drained, mut settlement, mut steps) = (0.0, 0.0, 0);
    while simulation.stage().is_some() {
        let before = simulation.observe().size[1];
        simulation.advance().unwrap();
        let flow = simulation.coupled().storage_flow().unwrap();
        let flux = flow.flux();
        assert_eq!([0, 1, 2, 4, 5].map(|w| flux[w]), [0.0; 5], "only the top is open");
        steps += 1;
        if steps > 1 {
            drained -= flux[WallId::YMax.index()] * simulation.dt();
        }
        settlement = start - before;
        let sum: Vec3 = flow.force().iter().chain(flow.wall_force()).sum();
        let largest = flow.wall_force().iter().fold(0.0f64, |a, f| a.max(f.norm()));
        assert!(sum.norm() <= 1e-4 * largest, "step {steps}: {sum:?} of {largest}");
    }
    assert!(steps > 200 && settlement > 1e-4, "{steps} steps, {settlement} m");
    let error = drained / (settlement * area) - 1.0;
    assert!(error.abs() < 1e-10, "{error:e} after {steps} steps");
    assert!(simulation.coupled().largest_imbalance() < 1e-10);
}

/// What the fluid holds up at the drained end is no load on the spheres: the same consolidation under
/// 5 kPa more, in the fluid and on the wall.
#[test]
fn a_pressure_outside_is_no_load() {
    let course = |outside: f64| {
        let text =
            oedometer(200, 0.3).replace("y_max = 0.0", &format!("y_max = {outside:?}")).replace(
                "stress = 1.1e4\n        until",
                &format!("stress = {:?}\n        until", 1.1e4 + outside),
            );
        let mut simulation = start(&text);
        finish(&mut simulation);
        consolidation(&simulation).clone()
    };
    let (without, with) = (course(0.0), course(5e3));
    assert!((with.load_pa / without.load_pa - 1.0).abs() < 1e-2, "{}", with.load_pa);
    let (a, b) = (degree(&without, 0.25), degree(&with, 0.25));
    assert!((a - b).abs() < 0.02, "{a} {b}");
}

/// A load that comes in a time which is not short beside that of the consolidation is told with
/// both times; one that is put on at once is not. At 1 mm/s it takes 0.60 s, and d²/c_v is 0.71 s;
/// at 100 mm/s less than a hundredth of that.
#[test]
fn a_load_that_arrives_late_is_told() {
    let warnings = |max_velocity: &str| {
        let text = oedometer(100, 1.0).replace("max_velocity = 0.1", max_velocity);
        let mut simulation = start(&text);
        finish(&mut simulation);
        let (c, warnings) = (consolidation(&simulation).clone(), simulation.warnings());
        let time = c.drainage_path_m.powi(2) / c.c_v_m2_s;
        (format!("d²/c_v is {time:.3e} s"), warnings)
    };
    let (_, at_once) = warnings("max_velocity = 0.1");
    assert!(!at_once.iter().any(|w| w.contains("nine tenths")), "{at_once:?}");
    let (time, late) = warnings("max_velocity = 1e-3");
    let told =
        late.iter().find(|w| w.contains("nine tenths")).unwrap_or_else(|| panic!("{late:?}"));
    assert!(told.contains("were there after") && told.contains(&time), "{told}");
}

/// A load that never arrives is told: the wall may hardly move.
#[test]
fn a_load_that_does_not_arrive_is_told() {
    let text = oedometer(100, 0.2).replace("max_velocity = 0.1", "max_velocity = 1e-9");
    let mut simulation = start(&text);
    finish(&mut simulation);
    let warnings = simulation.warnings();
    assert!(warnings.iter().any(|w| w.contains("the servo on y_max")), "{warnings:?}");
    assert!(warnings.iter().any(|w| w.contains("were there at no time")), "{warnings:?}");
}

/// The pores at a wall settle by more than their share of the height, since spheres at a smooth wall have
/// neighbours on one side only; those at a drained wall settle with the load. The mean of three packings is
/// within 0.003 of the theory; with shares of the height it would settle by 0.028 to 0.042 more. The
/// viscosity is eight times the scene's, so that inertia is over by T_v = 0.005.
#[test]
fn the_drained_layer_settles_by_its_share_of_the_settlement() {
    let times = [0.005, 0.01, 0.02, 0.05, 0.1];
    let mut sum = [0.0; 5];
    for seed in [1, 3, 4] {
        let text = oedometer(400, 0.11)
            .replace("seed = 3", &format!("seed = {seed}"))
            .replace("viscosity = 10.0", "viscosity = 80.0")
            .replace("until_tv", "dt = \"auto\"\n until_tv");
        let mut simulation = start(&text);
        finish(&mut simulation);
        let c = consolidation(&simulation);
        assert!(c.drained_settlement > 1.2 * c.drained_share, "seed {seed}: {c:?}");
        for (sum, &at) in sum.iter_mut().zip(&times) {
            *sum += degree(c, at) - c.wall_layers().degree(at);
        }
    }
    for (sum, at) in sum.iter().zip(times) {
        assert!((sum / 3.0).abs() < 0.015, "T_v = {at}: off by {} on average", sum / 3.0);
    }
}

/// Without a fluid there are no pores whose share could be measured; with one, both walls have a share.
#[test]
fn load_cycles_tell_what_the_pores_at_walls_settle_by() {
    let measured = |fluid: bool| {
        let text = oedometer(100, 0.1);
        let (dry, rest) = text.split_once("[fluid]").unwrap();
        let stages = &rest[rest.find("[[stage]]").unwrap()..];
        let text = if fluid { text.clone() } else { format!("{dry}{stages}") };
        let cycles = text.split("[[stage]]").take(3).collect::<Vec<_>>().join("[[stage]]");
        let mut simulation = start(&cycles);
        finish(&mut simulation);
        match &simulation.outcomes().last().unwrap().outcome {
            Outcome::Cycle(cycles) => cycles.wall_layer_settlement,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(measured(false), None);
    let [base, top] = measured(true).unwrap();
    assert!(base > 0.0 && top > 0.0 && base + top < 1.0, "{base}, {top}");
}
