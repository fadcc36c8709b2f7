//! The advice of `check` holds: where it says "leave it out", a run with the effect differs from
//! one without by less than it says; where it says "you need it", by more than a per cent.

use dempfv::coupling::Observation;
use dempfv::io::packing::Packing;
use dempfv::scene::{Plan, load_packing};
use dempfv::simulation::{Advice, Estimate, Simulation, Specimen, Verdict};
use dempfv::{Aabb, WallId};

/// The shipped packing of 1,000 spheres, settled at 1 kPa.
fn packing() -> (Packing, Aabb) {
    load_packing(path().as_ref(), None).unwrap()
}

fn path() -> String {
    format!("{}/../packings/oedometer-1000.txt", env!("CARGO_MANIFEST_DIR"))
}

/// A run stage on that packing; `tables` are `[dem]` and `[fluid]`, `stage` what walls do.
fn scene(density: f64, tables: &str, stage: &str) -> Plan {
    let text = format!(
        "[particles]\npacking = \"{}\"\nyoung = 1e6\ndensity = {density}\nfriction_angle = 30\n\
         {tables}\n[[stage]]\nkind = \"run\"\n{stage}\n",
        path()
    );
    Plan::from_toml(&text, None).unwrap_or_else(|e| panic!("{e}"))
}

fn advice(plan: &Plan, effect: &str) -> Advice {
    let (packing, bounds) = packing();
    let specimen = Specimen::of_radii(&packing.radius).in_box(&packing.radius, &bounds, plan);
    let estimate = Estimate::of(plan, &specimen).unwrap();
    let all = Advice::of(plan, &specimen, &estimate, &bounds);
    let said: Vec<String> = all.iter().map(Advice::to_string).collect();
    all.into_iter().find(|a| a.effect == effect).unwrap_or_else(|| panic!("{said:?}"))
}

fn run(plan: &Plan) -> (Observation, Observation) {
    let mut simulation = Simulation::new(plan.clone()).unwrap();
    let mut first = None;
    while simulation.advance().unwrap() {
        first.get_or_insert_with(|| simulation.observe());
    }
    (first.unwrap(), simulation.observe())
}

/// Less than was said, and a margin for the path that a packing takes; or more than a per cent.
fn holds(said: &Advice, verdict: Verdict, change: f64) {
    println!("{said}; {change:e}");
    assert_eq!(said.verdict, verdict, "{said}");
    match verdict {
        Verdict::LeaveOut => {
            assert!(change < 0.01 && change < 1.2 * said.change, "{said}: {change}")
        }
        Verdict::Needed | Verdict::Beware => assert!(change > 0.01, "{said}: {change}"),
    }
}

#[test]
fn gravity() {
    for (density, verdict) in [(2600.0, Verdict::Needed), (20.0, Verdict::LeaveOut)] {
        let stage = "steps = 4000\nwalls = { y_max = { stress = 1000 } }";
        let with = scene(density, "[dem]\ndamping = 0.4\ngravity = [0, -9.81, 0]", stage);
        let without = scene(density, "[dem]\ndamping = 0.4", stage);
        let said = advice(&with, "gravity");
        let bottom = |plan| run(plan).1.contact_stress[WallId::YMin.index()];
        let change = (bottom(&with) / bottom(&without) - 1.0).abs();
        holds(&said, verdict, change);
    }
}

#[test]
fn pore_flow() {
    for (viscosity, dt, verdict) in [(3.0, 2e-6, Verdict::Needed), (1e-3, 2e-5, Verdict::LeaveOut)]
    {
        let stage = |fluid: bool| {
            format!("fluid = {fluid}\nsteps = 4000\nwalls = {{ y_max = {{ velocity = -0.0005 }} }}")
        };
        let fluid = format!(
            "[dem]\ndt = {dt:e}\ndamping = 0.2\n[fluid]\nviscosity = {viscosity}\npressure = {{ y_max = 0 }}"
        );
        let (wet, dry) =
            (scene(2600.0, &fluid, &stage(true)), scene(2600.0, &fluid, &stage(false)));
        let said = advice(&wet, "pore flow");
        let gain = |plan| {
            let (start, end) = run(plan);
            let of = |o: Observation| o.contact_stress[WallId::YMin.index()];
            of(end) - of(start)
        };
        let change = (gain(&wet) / gain(&dry) - 1.0).abs();
        holds(&said, verdict, change);
    }
}

/// More load on a sealed box: the water takes nearly all of it. Without compressibility a sealed
/// box has no answer; 1e12 Pa stand for that.
#[test]
fn fluid_compressibility() {
    for (modulus, verdict) in [(2e6, Verdict::Needed), (1e8, Verdict::LeaveOut)] {
        let tables = |modulus: f64| {
            format!("[dem]\ndamping = 0.4\n[fluid]\nviscosity = 1e-3\nbulk_modulus = {modulus:e}")
        };
        let stage = "time = 0.03\nwalls = { y_max = { stress = 2000 } }";
        let with = scene(2600.0, &tables(modulus), stage);
        let without = scene(2600.0, &tables(1e12), stage);
        let said = advice(&with, "fluid compressibility");
        let pressure = |plan| run(plan).1.mean_pressure;
        holds(&said, verdict, (pressure(&with) / pressure(&without) - 1.0).abs());
    }
}

/// Squeezed at two rates to the same strain: the stress on the lid.
#[test]
fn rate_of_loading() {
    for (velocity, verdict) in [(0.05, Verdict::Beware), (0.0003, Verdict::LeaveOut)] {
        let stage = |velocity: f64| {
            format!(
                "until = {{ strain = 0.003, axis = \"y\" }}\nwalls = {{ y_max = {{ velocity = -{velocity} }}, \
                 x_max = {{ stress = 1000 }} }}"
            )
        };
        let tables = "[dem]\ndamping = 0.2";
        let (fast, slow) = (
            scene(2600.0, tables, &stage(velocity)),
            scene(2600.0, tables, &stage(velocity / 4.0)),
        );
        let said = advice(&fast, "rate of loading");
        let lid = |plan| run(plan).1.contact_stress[WallId::YMax.index()];
        holds(&said, verdict, (lid(&fast) / lid(&slow) - 1.0).abs());
    }
}

/// Where the stiffness of the packing is not that of linear springs nothing is said that needs it.
#[test]
fn nothing_is_said_that_is_not_known() {
    let stage = "steps = 10\nwalls = { y_max = { stress = 1000 } }";
    let tables = "[dem]\n[fluid]\nviscosity = 1e-3\npressure = { y_max = 0 }";
    let effects = |tables: &str| {
        let plan = scene(2600.0, tables, stage);
        let (packing, bounds) = packing();
        let specimen = Specimen::of_radii(&packing.radius).in_box(&packing.radius, &bounds, &plan);
        let estimate = Estimate::of(&plan, &specimen).unwrap();
        let all = Advice::of(&plan, &specimen, &estimate, &bounds);
        all.into_iter().map(|advice| advice.effect).collect::<Vec<_>>()
    };
    assert_eq!(effects(tables), ["gravity", "pore flow", "fluid compressibility"]);
    let hertz = format!("[contacts]\nlaw = \"hertz-mindlin\"\n{tables}");
    assert_eq!(effects(&hertz), ["gravity"]);
}
