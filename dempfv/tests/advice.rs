//! The advice of `check` holds: where it says "leave it out", a run with the effect differs from
//! one without by less than it says; where it says "you need it", by more than a per cent.

use dempfv::coupling::Observation;
use dempfv::io::packing::Packing;
use dempfv::scene::{Plan, load_packing};
use dempfv::simulation::{Advice, Estimate, Simulation, Specimen, Stability, Verdict};
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
    advice_for(plan, effect, Specimen::of_radii(&packing().0.radius))
}

fn advice_for(plan: &Plan, effect: &str, specimen: Specimen) -> Advice {
    let (packing, bounds) = packing();
    let specimen = specimen.in_box(&packing.radius, &bounds, plan);
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

/// Steps of the contacts' bound alone, in water and in syrup: where viscosity would change the step
/// by less than a per cent nothing happens, where it needs a shorter one the run ends.
#[test]
fn viscosity_in_the_time_step() {
    for (viscosity, verdict) in [(1e-4, Verdict::LeaveOut), (10.0, Verdict::Needed)] {
        let stage = "steps = 500\nwalls = { y_max = { velocity = -0.001 } }";
        let tables = |dt: &str| {
            format!(
                "[dem]\ndamping = 0.2\ndt = {dt}\n[fluid]\nviscosity = {viscosity:e}\n\
                 pressure = {{ y_max = 0 }}"
            )
        };
        let auto = scene(2600.0, &tables("\"auto\""), stage);
        let mut specimen = Specimen::of_radii(&packing().0.radius);
        specimen.bounds = Stability::of(&auto).unwrap().map(|found| found.bounds);
        let contact = specimen.bounds.unwrap().contact;
        let said = advice_for(&auto, "viscosity in the time step", specimen);
        let fixed = scene(2600.0, &tables(&format!("{:e}", 0.8 * contact)), stage);
        let energy = |plan: &Plan| {
            let mut simulation = Simulation::new(plan.clone()).unwrap();
            while simulation.advance().unwrap_or(false) {}
            simulation.observe().kinetic_energy
        };
        match verdict {
            // Both steps are stable, and the same but for the share that was said.
            Verdict::LeaveOut => {
                let dt = |plan: &Plan| {
                    let mut simulation = Simulation::new(plan.clone()).unwrap();
                    simulation.advance().unwrap();
                    simulation.dt()
                };
                holds(&said, verdict, (dt(&fixed) / dt(&auto) - 1.0).abs());
                assert!(energy(&fixed) < 2.0 * energy(&auto));
            }
            _ => holds(&said, verdict, energy(&fixed) / energy(&auto) - 1.0),
        }
    }
}

/// A packing that is squeezed under stress, with films of a thousandth of the radius and without: the
/// stress that holds it.
#[test]
fn lubrication() {
    for (viscosity, dt, verdict) in [(1.0, 4e-6, Verdict::Needed), (0.1, 1e-5, Verdict::LeaveOut)] {
        let plan = |films: bool| {
            let edges = if films { "normal_lubrication = true\neps = 1e-3" } else { "" };
            let tables = format!(
                "[dem]\ndt = {dt:e}\ndamping = 0.2\n[fluid]\nviscosity = {viscosity:e}\n\
                 pressure = {{ x_min = 0, x_max = 0, y_min = 0, y_max = 0, z_min = 0, z_max = 0 }}\n{edges}"
            );
            let walls = "{ y_max = { velocity = -0.001 }, x_max = { stress = 1000 } }";
            scene(2600.0, &tables, &format!("time = 0.012\nwalls = {walls}"))
        };
        let said = advice(&plan(true), "lubrication");
        assert_eq!(said.number, "J = μ ε̇ / σ");
        let lid = |plan: &Plan| {
            let o = run(plan).1;
            let w = WallId::YMax.index();
            o.contact_stress[w] + o.fluid_stress[w]
        };
        holds(&said, verdict, (lid(&plan(true)) / lid(&plan(false)) - 1.0).abs());
    }
}

/// A sphere that falls onto a wall along which the fluid slips, with a film and without: the speed at
/// which it leaves. Two spheres that meet lose twice as much.
#[test]
fn lubrication_of_impacts() {
    let folder = std::env::temp_dir().join(format!("dempfv-advice-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("one.txt");
    std::fs::write(&path, "# box 0 0 0 0.02 0.02 0.02\n0.01 0.012 0.01 0.001\n").unwrap();
    for (viscosity, verdict) in [(0.02, Verdict::Needed), (1e-4, Verdict::LeaveOut)] {
        let plan = |films: bool| {
            let edges = if films { "normal_lubrication = true\neps = 1e-3" } else { "" };
            let text = format!(
                "[particles]\npacking = {path:?}\nyoung = 1e6\ndensity = 2600\n[dem]\ndt = 2e-6\n\
                 damping = 0\ngravity = [0, -9.81, 0]\n[fluid]\nviscosity = {viscosity}\n\
                 pressure = {{ x_min = 0, x_max = 0, y_min = 0, y_max = 0, z_min = 0, z_max = 0 }}\n\
                 {edges}\n[[stage]]\nkind = \"run\"\ntime = 0.08\n"
            );
            Plan::from_toml(&text, None).unwrap_or_else(|e| panic!("{e}"))
        };
        let with = plan(true);
        let (packing, bounds) = with.packing().unwrap().unwrap();
        let specimen = Specimen::of_radii(&packing.radius).in_box(&packing.radius, &bounds, &with);
        let estimate = Estimate::of(&with, &specimen).unwrap();
        let all = Advice::of(&with, &specimen, &estimate, &bounds);
        let said = all.into_iter().find(|a| a.effect == "lubrication").unwrap();
        assert_eq!(said.number, "St = ρ_s d v / 18 μ");
        let rebound = |plan: &Plan| {
            let mut simulation = Simulation::new(plan.clone()).unwrap();
            let mut fastest = 0.0f64;
            while simulation.advance().unwrap() {
                fastest = fastest.max(simulation.coupled().dem().velocity(0).y);
            }
            fastest
        };
        let change = (rebound(&with) / rebound(&plan(false)) - 1.0).abs();
        holds(&said, verdict, change);
    }
    std::fs::remove_dir_all(&folder).unwrap();
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
    let known = ["gravity", "viscosity in the time step", "pore flow", "fluid compressibility"];
    assert_eq!(effects(tables), known);
    let hertz = format!("[contacts]\nlaw = \"hertz-mindlin\"\n{tables}");
    assert_eq!(effects(&hertz), ["gravity", "viscosity in the time step"]);
}
