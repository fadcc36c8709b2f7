//! The balance of energy closes in every shipped scene, with fewer spheres and steps.

use std::path::Path;

use dempfv::dem::EnergyBalance;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;

/// What is shortened of a scene: text and what takes its place, and how many steps its last stage makes.
struct Short {
    scene: &'static str,
    replaced: &'static [(&'static str, &'static str)],
    steps: u64,
}

const SHORT: [Short; 11] = [
    Short {
        scene: "caulk2020",
        replaced: &[("oedometer-5000.txt", "oedometer-1000.txt")],
        steps: 100,
    },
    Short { scene: "cemented-column", replaced: &[("steps = 4000", "steps = 500")], steps: 500 },
    Short { scene: "dry-triaxial", replaced: &[("count = 2000", "count = 200")], steps: 1000 },
    Short { scene: "first", replaced: &[], steps: 500 },
    Short { scene: "impact", replaced: &[], steps: 500 },
    Short { scene: "oedometer", replaced: &[("count = 1000", "count = 100")], steps: 500 },
    Short { scene: "piping", replaced: &[("time = 0.1", "time = 0.02")], steps: 200 },
    Short { scene: "sedimentation", replaced: &[("count = 200", "count = 60")], steps: 2000 },
    Short { scene: "shear-cell", replaced: &[("count = 1000", "count = 200")], steps: 1000 },
    Short { scene: "triaxial-drained", replaced: &[("count = 600", "count = 100")], steps: 500 },
    Short { scene: "triaxial-undrained", replaced: &[("count = 600", "count = 100")], steps: 500 },
];

/// A shortened scene at the end of its last stage.
fn end(short: &Short) -> EnergyBalance {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let path = path.join(short.scene).with_extension("toml");
    let mut text = std::fs::read_to_string(&path).unwrap();
    for (from, to) in short.replaced {
        assert!(text.contains(from), "{}: {from}", short.scene);
        text = text.replacen(from, to, 1);
    }
    let mut plan = Plan::from_toml(&text, Some(&path)).unwrap();
    plan.output.energy_turning = true;
    let stages = plan.stages.len();
    let mut simulation = Simulation::new(plan).unwrap();
    let (mut stage, mut steps) = (0, 0);
    let mut name = simulation.stage().unwrap().name.clone();
    loop {
        let step = simulation.step();
        if !simulation.advance().unwrap() {
            break;
        }
        if let Some(now) = simulation.stage().filter(|now| now.name != name) {
            (name, stage, steps) = (now.name.clone(), stage + 1, 0);
        }
        steps += simulation.step() - step;
        if stage + 1 == stages && steps >= short.steps {
            break;
        }
    }
    simulation.coupled().dem().energy_balance().unwrap()
}

/// The residual is what time integration has made or lost beside touches, turns and changes of the step,
/// which have terms of their own. The promise is 1e-6 of what was moved; nothing moves in the scene
/// `permeability`.
#[test]
fn the_balance_closes_in_every_shipped_scene() {
    for short in &SHORT {
        let b = end(short);
        let of = |x: f64| x / b.moved();
        let named = [b.touch_change, b.turning, b.step_change].map(of);
        println!("{}: {:e} beside {named:?} of {:e} J", short.scene, of(b.residual), b.moved());
        assert!(b.moved() > 0.0 && of(b.residual).abs() < 1e-6, "{}: {b:?}", short.scene);
    }
}
