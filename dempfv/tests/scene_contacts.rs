//! Scenes that name effects of the contacts: what they mean, which are refused, and restarts.

use dempfv::dem::law::{Adhesion, Hertz, Resistance, Restitution};
use dempfv::scene::Plan;
use dempfv::simulation::{Estimate, Simulation, SimulationState, Specimen};

/// A scene with these tables, and two stages of 60 steps.
fn scene(tables: &str) -> String {
    format!(
        "seed = 3\n[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\
         [particles]\ncloud = {{ count = 300, porosity = 0.7 }}\nyoung = 1e7\n{tables}\n\
         [[stage]]\nkind = \"run\"\nname = \"first\"\nsteps = 60\n\
         walls = {{ y_max = {{ velocity = -0.3 }} }}\n\
         [[stage]]\nkind = \"run\"\nname = \"second\"\nsteps = 60\n\
         walls = {{ y_max = {{ velocity = -0.3 }} }}\n"
    )
}

const DEM: &str = "[dem]\ngravity = [0, -100, 0]\ndamping = 0\n";

fn plan(tables: &str) -> Plan {
    Plan::from_toml(&scene(&format!("{tables}\n{DEM}")), None).unwrap_or_else(|e| panic!("{e}"))
}

/// Without [contacts] and [bonds] the law is the linear one; every key becomes what it says.
#[test]
fn a_scene_calls_for_effects() {
    assert!(plan("").granular_law().unwrap().is_none());
    assert!(plan("[contacts]").granular_law().unwrap().is_none());
    let rolling = Resistance { friction: 0.1, stiffness_ratio: 0.5, damping_ratio: 0.3 };
    let law = plan(
        "[contacts]\nlaw = \"hertz-mindlin\"\npoisson_ratio = 0.3\nrestitution = 0.8\n\
         rolling_friction = 0.1\nadhesion = \"jkr\"\nwork_of_adhesion = 0.2",
    );
    let effects = *law.granular_law().unwrap().unwrap().effects();
    assert_eq!(effects.hertz, Some(Hertz { poisson_ratio: 0.3, wall_poisson_ratio: 0.3 }));
    assert_eq!(effects.restitution, Some(Restitution { spheres: 0.8, walls: 0.8 }));
    assert_eq!((effects.rolling, effects.twisting), (Some(rolling), None));
    assert_eq!(effects.adhesion, Some(Adhesion::Jkr(0.2)));
    let on = law.effects_on();
    for name in
        ["Hertz-Mindlin contacts", "viscous contact damping", "rolling resistance", "JKR adhesion"]
    {
        assert!(on.contains(&name), "{name} {on:?}");
    }
    assert!(law.effects_off().contains(&"brittle bonds"));
    assert!(plan("[bonds]\ntension = 1\ncohesion = 1").effects_on().contains(&"brittle bonds"));
}

/// What makes no sense is refused with where and why.
#[test]
fn contradictions_are_refused() {
    for (tables, what) in [
        ("[contacts]\npoisson_ratio = 0.3", "stands without `law = \"hertz-mindlin\"`"),
        ("[contacts]\nwall_restitution = 0.3", "stands without `restitution`"),
        ("[contacts]\nrestitution = 0", "`restitution` in [contacts] is 0"),
        ("[contacts]\nrolling_damping_ratio = 0.1", "stands without `rolling_friction`"),
        ("[contacts]\nadhesion = \"jkr\"\nwork_of_adhesion = 1", "is a theory of Hertz's contact"),
        ("[contacts]\nadhesion = \"constant\"", "has no `pull_off_force`"),
        ("[contacts]\nlaw = \"hertz-mindlin\"\nadhesion = \"dmt\"", "has no `work_of_adhesion`"),
        ("[contacts]\npull_off_force = 1", "stands without `adhesion = \"constant\"`"),
        ("[contacts]\nwork_of_adhesion = 1", "stands without `adhesion = \"dmt\" or \"jkr\"`"),
        ("[bonds]\ntension = 1", "has no `cohesion`"),
        ("[bonds]\ntension = 2e6\ncohesion = 1", "would stretch by a third of a radius"),
        ("[bonds]\ntension = 1\ncohesion = 1\nfrom = \"third\"", "which is no stage"),
        (
            "[contacts]\nlaw = \"hertz-mindlin\"\n[bonds]\ntension = 1\ncohesion = 1",
            "a bond has a linear spring",
        ),
        (
            "[contacts]\nadhesion = \"constant\"\npull_off_force = 1\n[bonds]\ntension = 1\ncohesion = 1",
            "there is no adhesion beside bonds",
        ),
    ] {
        let error = Plan::from_toml(&scene(&format!("{tables}\n{DEM}")), None).unwrap_err();
        assert!(error.what.contains(what), "{tables}: {error}");
        assert!(error.line.is_some() && !error.remedy.is_empty(), "{error}");
    }
    for (tables, what) in [
        ("[contacts]\nrestitution = 0.5", "[contacts] stands without [dem]"),
        ("[bonds]\ntension = 1\ncohesion = 1", "[bonds] stands without [dem]"),
        (
            "[dem]\nrotation = false\n[contacts]\nrolling_friction = 0.1",
            "beside `rotation = false`",
        ),
    ] {
        let text = scene(tables);
        // Without [dem] no stage may move spheres.
        let stages = text.find("[[stage]]").unwrap();
        let still = "[fluid]\nviscosity = 1\n[[stage]]\nkind = \"permeability\"\naxis = \"x\"\n";
        let text = if tables.contains("[dem]") { text } else { text[..stages].to_owned() + still };
        let error = Plan::from_toml(&text, None).unwrap_err();
        assert!(error.what.contains(what), "{tables}: {error}");
    }
}

const TABLES: [&str; 5] = [
    "[contacts]\nlaw = \"hertz-mindlin\"\nrestitution = 0.7",
    "[contacts]\nrolling_friction = 0.1\ntwisting_friction = 0.1",
    "[contacts]\nlaw = \"hertz-mindlin\"\nadhesion = \"jkr\"\nwork_of_adhesion = 20",
    "[contacts]\nadhesion = \"constant\"\npull_off_force = 0.5",
    "[bonds]\ntension = 1e4\ncohesion = 1e4\ninteraction_range = 1.1\nfrom = \"second\"",
];

fn advance(simulation: &mut Simulation, steps: usize) {
    for _ in 0..steps {
        simulation.advance().unwrap();
    }
}

/// A restart from a checkpoint in the middle of a stage, by its bytes, changes no bit.
#[test]
fn restarts_change_no_bit() {
    for tables in TABLES {
        let mut whole = Simulation::new(plan(tables)).unwrap();
        advance(&mut whole, 120);
        let contacts = whole.observe().contacts;
        assert!(contacts > 20, "{tables}: {contacts}: no test");
        let mut first = Simulation::new(plan(tables)).unwrap();
        advance(&mut first, 90);
        let bytes = postcard::to_stdvec(&first.state()).unwrap();
        let state: SimulationState = postcard::from_bytes(&bytes).unwrap();
        let mut second = Simulation::restart(plan(tables), state).unwrap();
        assert_eq!(second.observe(), first.observe(), "{tables}");
        advance(&mut second, 30);
        assert_eq!(second.state_hash(), whole.state_hash(), "{tables}");
        let bytes = |s: &Simulation| postcard::to_stdvec(&s.coupled().state()).unwrap();
        assert!(bytes(&second) == bytes(&whole), "{tables}");
    }
}

/// A restart may change the constants of an effect, with a warning, and not the effects.
#[test]
fn restarts_with_other_contacts() {
    let state = |tables: &str| {
        let mut simulation = Simulation::new(plan(tables)).unwrap();
        advance(&mut simulation, 90);
        simulation.state()
    };
    let [damped, rolling, ..] = TABLES;
    let other = damped.replace("0.7", "0.5");
    let simulation = Simulation::restart(plan(&other), state(damped)).unwrap();
    assert!(simulation.warnings().iter().any(|w| w.contains("restitution")));
    for tables in ["", rolling, "[contacts]\nrestitution = 0.7"] {
        let error = Simulation::restart(plan(tables), state(damped)).err().unwrap().to_string();
        assert!(error.contains("contacts"), "{tables}: {error}");
    }
}

/// Bonds are made where the stage begins that is named, and counted from there on.
#[test]
fn bonds_are_made_at_their_stage() {
    let mut simulation = Simulation::new(plan(TABLES[4])).unwrap();
    let count = |s: &Simulation| {
        let dem = s.coupled().dem();
        (dem.intact_bonds(), dem.broken_bonds())
    };
    advance(&mut simulation, 60);
    assert_eq!(count(&simulation), (0, 0));
    advance(&mut simulation, 1);
    let (made, broken) = count(&simulation);
    assert!(made > 50 && broken == 0, "{made} {broken}");
    // A bond is made without force, which takes the load off contacts that had one.
    let warnings = simulation.warnings();
    let told =
        |w: &String| w.contains(&format!("of {made} bonds were made on contacts that carried"));
    assert!(warnings.iter().any(told), "{warnings:?}");
    advance(&mut simulation, 59);
    let (intact, broken) = count(&simulation);
    println!("{made} made, {broken} broken");
    assert_eq!(intact + broken, made);
    assert!(broken > 0 && intact > 0, "{intact} {broken}");
}

/// Local damping, which scenes have unless they say otherwise, takes from the rebound that a
/// restitution asks for, and `check` says so.
#[test]
fn damping_beside_a_restitution_is_told() {
    let warnings = |tables: &str| {
        let plan = Plan::from_toml(&scene(tables), None).unwrap();
        Estimate::of(&plan, &Specimen::default()).unwrap().warnings()
    };
    let told = warnings("[contacts]\nrestitution = 0.5\n[dem]\n");
    assert!(told.len() == 2 && told[0].starts_with("stage \"first\": local damping acts beside"));
    assert!(warnings("[contacts]\nrestitution = 0.5\n[dem]\ndamping = 0.0\n").is_empty());
    assert!(warnings("[dem]\n").is_empty());
}

/// A shear stiffness that the law would not use is refused; a number of 300 digits is not written
/// out.
#[test]
fn what_a_law_does_not_use_is_refused() {
    let stiff = "[contacts]\nlaw = \"hertz-mindlin\"\n[dem]\n";
    let text = scene(stiff).replace("[particles]", "[particles]\nstiffness_ratio = 0.3");
    let error = Plan::from_toml(&text, None).unwrap_err();
    assert!(
        error.what.starts_with("`stiffness_ratio` in [particles] stands beside `law"),
        "{error}"
    );
    let text = scene("[bonds]\ntension = 1e300\ncohesion = 1.0\n[dem]\n");
    let error = Plan::from_toml(&text, None).unwrap_err();
    assert!(error.what.contains("a tension of 1e300 Pa"), "{error}");
}
