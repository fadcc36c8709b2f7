//! Permeability stages: as many as a scene likes, with both kinds of walls, and away from them.

mod coupling_support;

use coupling_support::{finish, start};
use dempfv::simulation::{Outcome, PermeabilityTest, Simulation};

const STAGE: &str = "[[stage]]\nkind = \"permeability\"\naxis = \"y\"\n";

fn tests(simulation: &Simulation) -> Vec<PermeabilityTest> {
    let found = |o: &Outcome| match o {
        Outcome::Permeability(test) => Some(test.clone()),
        _ => None,
    };
    simulation.outcomes().iter().filter_map(|o| found(&o.outcome)).collect()
}

fn measured(fluid: &str, stages: &str) -> Vec<PermeabilityTest> {
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../packings/oedometer-5000.txt");
    let text = format!(
        "[particles]\npacking = \"{packing}\"\n[dem]\n[fluid]\nviscosity = 1e-3\n{fluid}\n{stages}"
    );
    let mut simulation = start(&text);
    finish(&mut simulation);
    tests(&simulation)
}

/// Of the shipped packing of 5,000, walls that let the fluid slip and walls that do not differ by more than
/// a tenth; what is measured a Sauter diameter away from them knows little of which they are, and
/// lies below both wholes: the loose layers at walls are not in it. Which of the two the stage
/// measured is told, and follows the scene.
#[test]
fn the_inside_does_not_know_the_walls() {
    let [slip] = &measured("", STAGE)[..] else { panic!("one test") };
    let [stick] = &measured("slip_walls = false", STAGE)[..] else { panic!("one test") };
    assert_eq!((slip.slip_walls, stick.slip_walls), (Some(true), Some(false)));
    assert_eq!(Some(slip.permeability_m2), slip.slip_permeability_m2);
    assert_eq!(Some(stick.permeability_m2), stick.no_slip_permeability_m2);
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    assert!(same(slip.no_slip_permeability_m2.unwrap(), stick.permeability_m2));
    assert!(same(stick.slip_permeability_m2.unwrap(), slip.permeability_m2));
    let whole = slip.permeability_m2 / stick.permeability_m2 - 1.0;
    let cores = [slip, stick].map(|test| test.core_permeability_m2.unwrap());
    let core = cores[0] / cores[1] - 1.0;
    assert!(whole > 0.1 && core.abs() < 0.2 * whole, "{whole} {core}");
    assert!(cores[0] < slip.permeability_m2, "{cores:?} {}", slip.permeability_m2);
    // n³ d² / (180 (1 − n)²).
    let (n, d) = (slip.porosity, slip.sauter_diameter_m);
    let kozeny = n.powi(3) * d * d / (slip.kozeny_carman_constant * (1.0 - n).powi(2));
    assert_eq!(slip.kozeny_carman_constant, 180.0);
    assert!(same(kozeny, slip.kozeny_carman_m2));
}

/// A packing that is pressed between two tests has less porosity at the second, and conducts less.
#[test]
fn a_scene_may_measure_before_and_after() {
    let press = "[[stage]]\nkind = \"run\"\nname = \"press\"\nfluid = false\nuntil = { porosity = 0.395 }\n\
                 walls = { y_max = { velocity = -0.05 } }\n";
    let stages = format!("{STAGE}{press}{STAGE}");
    let found = measured("", &stages);
    let [before, after] = &found[..] else { panic!("two tests") };
    assert!(after.porosity < before.porosity && after.porosity > 0.394);
    assert!(after.permeability_m2 < before.permeability_m2);
    // As Kozeny and Carman have it, to a tenth of the change.
    let (found, expected) = (
        after.permeability_m2 / before.permeability_m2 - 1.0,
        after.kozeny_carman_m2 / before.kozeny_carman_m2 - 1.0,
    );
    assert!((found / expected - 1.0).abs() < 0.3, "{found} {expected}");
}
