//! A restart with another scene: what of it holds from the next step on, what is odd, and what
//! no restart can change.

mod coupling_support;

use std::path::PathBuf;

use coupling_support::{COMPACT, MEASURE, advance, advance_to, finish, plan, scene, start};
use dempfv::io::checkpoint;
use dempfv::simulation::{Effect, Outcome, Simulation, SimulationState};
use dempfv::{Error, WallId};

/// A packing that settles, is squeezed for 100 steps and rests for 20.
fn squeezed() -> String {
    let rest = r#"
        [[stage]]
        kind = "run"
        name = "load"
        steps = 100
        walls = { y_max = { stress = 1.1e4 } }
        [[stage]]
        kind = "run"
        name = "rest"
        steps = 20
        [output]
        history_every = 10
    "#;
    scene(100, "remesh_interval = 40", &format!("{COMPACT}{rest}"))
}

/// A state so many steps into a stage.
fn state_in(text: &str, stage: &str, steps: u64) -> SimulationState {
    let mut simulation = start(text);
    advance_to(&mut simulation, stage);
    advance(&mut simulation, steps);
    simulation.state()
}

/// A restart with an edited scene.
fn restart(text: &str, state: &SimulationState, old: &str, new: &str) -> Result<Simulation, Error> {
    assert!(text.contains(old), "{old}");
    Simulation::restart(plan(&text.replacen(old, new, 1)), state.clone())
}

/// The one change of a restart: key, effect, and the whole sentence.
fn only_change(simulation: &Simulation) -> (String, Effect, String) {
    let changed = &simulation.restarted().unwrap().changed;
    assert_eq!(changed.len(), 1, "{changed:?}");
    (changed[0].key.clone(), changed[0].effect, changed[0].to_string())
}

/// A restart in the midst of a stage with another length goes on as a run that had that length
/// from the beginning, bit for bit: in steps and in model time; and a stage that has that length
/// already ends at once.
#[test]
fn another_length_of_the_stage_under_way_is_used() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    for length in ["steps = 140", "time = 0.03", "steps = 70"] {
        let mut whole = start(&text.replacen("steps = 100", length, 1));
        finish(&mut whole);
        let mut parts = restart(&text, &state, "steps = 100", length).unwrap();
        assert_eq!(parts.restarted().unwrap().step, state.step());
        finish(&mut parts);
        assert_eq!(parts.state_hash(), whole.state_hash(), "{length}");
        assert_eq!(parts.step(), whole.step(), "{length}");
    }
    let mut over = restart(&text, &state, "steps = 100", "steps = 30").unwrap();
    let (key, effect, said) = only_change(&over);
    assert_eq!((key.as_str(), effect), ("stage.load.steps", Effect::Used));
    assert!(said.contains("is 30, was 100") && said.contains("done 50 already"), "{said}");
    over.advance().unwrap();
    assert_eq!((over.step(), over.stage().unwrap().name.as_str()), (state.step(), "rest"));
}

/// The course of a stage that a restart made ten times as long has no gap where the new share of
/// the stage catches up: 50 moments of the first 100 steps, and one for each 5 of 1,000 steps
/// from there on.
#[test]
fn the_course_of_a_longer_stage_has_no_gap() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let mut long = restart(&text, &state, "steps = 100", "steps = 1000").unwrap();
    finish(&mut long);
    let Outcome::Run(path) = &long.outcomes()[1].outcome else { panic!("no run stage") };
    let times: Vec<f64> = path.samples.iter().map(|s| s.time_s / 3e-4).collect();
    let largest = times.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
    // And one where the shares of both lengths meet.
    assert!(largest < 6.5, "{largest} steps without a sample");
    assert!(path.samples.len() > 230, "{}", path.samples.len());
}

/// Another load, and a wall that moves where it stood still: the first step after the restart
/// knows them.
#[test]
fn another_load_and_motion_of_walls_are_used() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let mut loaded = restart(&text, &state, "stress = 1.1e4", "stress = 2.0e4").unwrap();
    assert_eq!(only_change(&loaded).0, "stage.load.walls.y_max.stress");
    finish(&mut loaded);
    let reached = |s: &Simulation| match &s.outcomes()[1].outcome {
        Outcome::Run(path) => path.wall_stress_pa[WallId::YMax.index()],
        other => panic!("{other:?}"),
    };
    // The servo holds 20 kPa after 50 steps within the 5 % by which it would be warned of.
    assert!((reached(&loaded) / 2e4 - 1.0).abs() < 0.05, "{}", reached(&loaded));

    let with = "walls = { x_min = { velocity = 0.05 }, y_max = { velocity = -0.02 } }";
    let old = "walls = { y_max = { stress = 1.1e4 } }";
    let mut moved = restart(&text, &state, old, with).unwrap();
    let before = moved.coupled().dem().walls().map(|w| w.position);
    moved.advance().unwrap();
    let walls = moved.coupled().dem().walls();
    let dt = moved.dt();
    for (wall, velocity) in [(WallId::XMin, 0.05), (WallId::YMax, -0.02)] {
        // One step at the velocity given, to the round-off of the position.
        let moved = walls[wall].position - before[wall];
        assert!((moved - velocity * dt).abs() < 1e-15, "{wall}: {moved}");
    }
    let mut still = restart(&text, &state, old, "").unwrap();
    let before = still.coupled().dem().box_();
    still.advance().unwrap();
    assert_eq!(still.coupled().dem().box_(), before);
}

/// What stages take over from `[walls]` is one change, wherever it came from: a value for none, and
/// another value. A stage's own value is told by itself.
#[test]
fn a_changed_default_is_told_once() {
    let squeezed = squeezed();
    let walls = "[walls]\n        friction_angle = 0.0";
    let with = |velocity: &str| format!("{walls}\n        max_velocity = {velocity}");
    let state = state_in(&squeezed, "load", 50);
    let changed = restart(&squeezed, &state, walls, &with("0.05")).unwrap();
    assert_eq!(only_change(&changed).0, "walls.max_velocity");

    let text = squeezed.replacen(walls, &with("0.05"), 1);
    let state = state_in(&text, "load", 50);
    let changed = restart(&text, &state, "max_velocity = 0.05", "max_velocity = 0.02").unwrap();
    let (key, effect, said) = only_change(&changed);
    assert_eq!((key.as_str(), effect), ("walls.max_velocity", Effect::Used));
    assert!(said.contains("is 0.02, was 0.05"), "{said}");

    let own = text.replacen("{ stress = 1.1e4 }", "{ stress = 1.1e4, max_velocity = 0.03 }", 1);
    let both = own.replacen("max_velocity = 0.05", "max_velocity = 0.02", 1);
    let both = Simulation::restart(plan(&both), state).unwrap();
    let keys: Vec<&str> =
        both.restarted().unwrap().changed.iter().map(|c| c.key.as_str()).collect();
    assert_eq!(keys, ["stage.load.walls.y_max.max_velocity", "walls.max_velocity"]);
}

/// Fluid of a stage under way, damping, friction, time step and drainage: each is there in the
/// first step.
#[test]
fn what_a_stage_and_its_fluid_say_otherwise_holds_in_the_first_step() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let first = |old: &str, new: &str| {
        let mut simulation = restart(&text, &state, old, new).unwrap();
        assert!(!simulation.restarted().unwrap().changed.is_empty());
        simulation.advance().unwrap();
        simulation
    };
    let dry = first("name = \"load\"", "name = \"load\"\nfluid = false");
    assert!(dry.coupled().storage_flow().is_none());
    let damped = first("name = \"load\"", "name = \"load\"\ndamping = 0.7");
    assert_eq!(damped.coupled().dem().options().damping, 0.7);
    let smooth = first("name = \"load\"", "name = \"load\"\nfriction_angle = 5.0");
    assert_eq!(smooth.coupled().dem().material().friction_angle, 5f64.to_radians());
    let slow = first("dt = 3.0e-4", "dt = 1.0e-4");
    assert_eq!(slow.dt(), 1e-4);
    let solver = first("remesh_interval = 40", "remesh_interval = 40\nsolver = \"frontal\"");
    assert_eq!(solver.coupled().storage_flow().unwrap().solved_by(), Some("frontal"));
    let loose = first("remesh_interval = 40", "remesh_interval = 40\ntolerance = 1e-6");
    assert_eq!(loose.coupled().storage_flow().unwrap().tolerance(), 1e-6);
    // Both ends drain from the first step on, with a network of that very step.
    let drained = first("{ y_max = 0.0 }", "{ y_max = 0.0, y_min = 50.0 }");
    let conditions = drained.coupled().storage_flow().unwrap().operators().conditions();
    assert_eq!(conditions.pressures()[WallId::YMin.index()], Some(50.0));
    assert_eq!(drained.coupled().network_age(), 1);
}

/// A stage that ran dry is filled with fluid in its midst.
#[test]
fn a_dry_stage_is_filled() {
    let text = squeezed().replacen("name = \"load\"", "name = \"load\"\nfluid = false", 1);
    let state = state_in(&text, "load", 10);
    let mut wet = restart(&text, &state, "fluid = false", "fluid = true").unwrap();
    wet.advance().unwrap();
    assert!(wet.coupled().storage_flow().is_some());
}

/// What makes another material or fluid of it in the midst of a run holds, and is warned of; the
/// warning survives another checkpoint.
#[test]
fn odd_changes_hold_and_are_warned_of() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    for (old, new, key) in [
        ("young = 1.0e6", "young = 2.0e6\nstiffness_ratio = 0.4", "`young` in [particles]"),
        ("young = 1.0e6", "young = 1.0e6\ndensity = 5200.0", "`density` in [particles]"),
        ("viscosity = 10.0", "viscosity = 20.0", "`viscosity` in [fluid]"),
        ("damping = 0.2", "damping = 0.2\ngravity = [0, 0, -9.81]", "`gravity` in [dem]"),
    ] {
        let mut odd = restart(&text, &state, old, new).unwrap();
        assert!(odd.warnings().iter().any(|w| w.contains(key) && w.contains("odd")), "{key}");
        odd.advance().unwrap();
        let again = Simulation::restart(plan(&text.replacen(old, new, 1)), odd.state()).unwrap();
        assert!(again.restarted().unwrap().changed.is_empty());
        assert!(again.warnings().iter().any(|w| w.contains(key)), "{key}");
    }
    // Twice the density is twice the mass.
    let mass = |s: &Simulation| s.coupled().dem().storage().mass.iter().sum::<f64>();
    let light = Simulation::restart(plan(&text), state.clone()).unwrap();
    let heavy = restart(&text, &state, "young = 1.0e6", "young = 1.0e6\ndensity = 5200.0").unwrap();
    assert!((mass(&heavy) / mass(&light) - 2.0).abs() < 1e-14);
    // A pressure of viscous flow is proportional to the viscosity: the same velocities and the same
    // network in the first step, twice the pressure, with a solve to 1e-11.
    let largest = |mut s: Simulation| {
        s.advance().unwrap();
        s.observe().largest_pressure
    };
    let viscous = |mu: &str| largest(restart(&text, &state, "viscosity = 10.0", mu).unwrap());
    let ratio = viscous("viscosity = 40.0") / viscous("viscosity = 20.0");
    assert!((ratio - 2.0).abs() < 1e-9, "{ratio}");
}

/// An automatic time step is chosen anew when the stiffness or the mass is another: with a
/// quarter of the density the contacts' bound halves.
#[test]
fn an_automatic_time_step_follows() {
    let text = squeezed().replacen("dt = 3.0e-4", "dt = \"auto\"", 1);
    let state = state_in(&text, "load", 50);
    let dt = |mut simulation: Simulation| {
        simulation.advance().unwrap();
        simulation.time_step_bounds().unwrap().contact
    };
    let before = dt(Simulation::restart(plan(&text), state.clone()).unwrap());
    let light = restart(&text, &state, "young = 1.0e6", "young = 1.0e6\ndensity = 650.0").unwrap();
    let ratio = dt(light) / before;
    // The bounds of the state are up to 50 steps old.
    assert!((ratio / 0.5 - 1.0).abs() < 0.05, "{ratio}");
}

/// Growth takes another goal, friction and time step at once.
#[test]
fn growth_goes_on_to_another_goal() {
    let text = squeezed();
    let state = state_in(&text, "compact", 203);
    let mut other = restart(&text, &state, "dt = \"auto\"", "dt = 1.0e-4").unwrap();
    other.advance().unwrap();
    assert_eq!(other.dt(), 1e-4);
    let mut other = restart(&text, &state, "stress = 1.0e4", "stress = 1.5e4").unwrap();
    while other.outcomes().is_empty() {
        other.advance().unwrap();
    }
    let Outcome::Compact(reached) = &other.outcomes()[0].outcome else { panic!("no growth") };
    // Within the stage's tolerance.
    assert!((reached.stress_pa / 1.5e4 - 1.0).abs() < 1e-3, "{reached:?}");
}

/// Cycles end unloaded, also where a restart asks for fewer than were begun.
#[test]
fn cycles_may_become_fewer_and_other() {
    let stage = r#"
        [[stage]]
        kind = "cycle"
        wall = "y_max"
        from = 1.0e4
        to = 1.1e4
        cycles = 3
        dt = "auto"
    "#;
    let text = scene(60, "", &format!("{COMPACT}{stage}"));
    let mut simulation = start(&text);
    advance_to(&mut simulation, "cycle");
    // Loading for the second time: three holds are over, and 1.1 kPa above the first.
    let strained = |s: &Simulation| s.coupled().dem().walls()[WallId::YMax].control;
    let (mut seen, mut last) = (0, strained(&simulation));
    while seen < 4 {
        simulation.advance().unwrap();
        let now = strained(&simulation);
        seen += u32::from(now != last);
        last = now;
    }
    let state = simulation.state();
    let mut fewer = restart(&text, &state, "cycles = 3", "cycles = 1").unwrap();
    finish(&mut fewer);
    let Outcome::Cycle(cycles) = &fewer.outcomes()[1].outcome else { panic!("no cycles") };
    assert_eq!(cycles.stress_pa.len() % 2, 1);
    assert!(cycles.stress_pa.len() < 7, "{cycles:?}");
    assert!((cycles.stress_pa.last().unwrap() / 1e4 - 1.0).abs() < 1e-3);
    let mut higher = restart(&text, &state, "to = 1.1e4", "to = 1.2e4").unwrap();
    finish(&mut higher);
    let Outcome::Cycle(cycles) = &higher.outcomes()[1].outcome else { panic!("no cycles") };
    assert!((cycles.stress_pa[5] / 1.2e4 - 1.0).abs() < 1e-3, "{cycles:?}");
    let error = restart(&text, &state, "wall = \"y_max\"", "wall = \"x_max\"").err().unwrap();
    assert!(error.to_string().contains("`wall` in stage \"cycle\""), "{error}");
}

/// What a consolidation under way is reckoned from cannot change; its end and the profiles that
/// are still to come can.
#[test]
fn a_consolidation_keeps_what_it_is_reckoned_from() {
    let stage = r#"
        [[stage]]
        kind = "consolidate"
        wall = "y_max"
        stress = 1.1e4
        until_tv = 0.05
        profiles = [0.001, 0.02]
        max_velocity = 0.1
    "#;
    let text = scene(100, "remesh_interval = 40", &format!("{COMPACT}{MEASURE}{stage}"));
    let mut simulation = start(&text);
    advance_to(&mut simulation, "consolidate");
    while simulation.consolidation().is_none_or(|c| c.profiles.is_empty()) {
        simulation.advance().unwrap();
    }
    let state = simulation.state();
    for (old, new, key) in [
        (
            "stress = 1.1e4\n        until",
            "stress = 1.3e4\n        until",
            "`stress` in stage \"consolidate\" is 13000.0, was 11000.0",
        ),
        ("{ y_max = 0.0 }", "{ y_max = 5.0 }", "`pressure.y_max` in [fluid] is 5.0, was 0.0"),
    ] {
        let error = restart(&text, &state, old, new).err().unwrap();
        assert!(error.is_input() && error.to_string().contains(key), "{error}");
    }
    let new = "until_tv = 0.03\n        profiles = [0.0005, 0.001, 0.01, 0.025]";
    let old = "until_tv = 0.05\n        profiles = [0.001, 0.02]";
    let mut other = restart(&text, &state, old, new).unwrap();
    finish(&mut other);
    let Outcome::Consolidate(c) = &other.outcomes()[3].outcome else { panic!("no consolidation") };
    let taken: Vec<f64> = c.profiles.iter().map(|p| p.time_factor).collect();
    assert_eq!(taken.len(), 3, "{taken:?}");
    let last = c.samples.last().unwrap().time_factor;
    assert!((0.03..0.035).contains(&last), "{last}");
}

/// What is over stays as it was, and that is told; what is to come may be added, left out, or
/// another.
#[test]
fn stages_that_are_over_and_stages_to_come() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let past = restart(&text, &state, "stress = 1.0e4", "stress = 3.0e4").unwrap();
    let (key, effect, said) = only_change(&past);
    assert_eq!((key.as_str(), effect), ("stage.compact.stress", Effect::None));
    assert!(said.contains("no effect") && said.contains("the stage is over"), "{said}");
    let added = "steps = 20\n[[stage]]\nkind = \"run\"\nname = \"more\"\nsteps = 7";
    let mut longer = restart(&text, &state, "steps = 20", added).unwrap();
    assert_eq!(only_change(&longer).0, "stage.more");
    finish(&mut longer);
    assert_eq!(longer.step(), state.step() + 50 + 20 + 7);
    let mut other = restart(&text, &state, "steps = 20", "steps = 9").unwrap();
    finish(&mut other);
    assert_eq!(other.step(), state.step() + 50 + 9);
}

/// Output and title change nothing that is computed: the bits are those of a run that went on.
#[test]
fn output_changes_no_bit() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let mut whole = Simulation::restart(plan(&text), state.clone()).unwrap();
    assert!(whole.restarted().unwrap().changed.is_empty());
    let mut other = restart(&text, &state, "history_every = 10", "history_every = 5").unwrap();
    let (key, effect, _) = only_change(&other);
    assert_eq!((key.as_str(), effect), ("output.history_every", Effect::Used));
    finish(&mut whole);
    finish(&mut other);
    assert_eq!(whole.state_hash(), other.state_hash());
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("dempfv-restart-{}-{name}", std::process::id()))
}

/// Spheres and box are those of the state: a cloud's keys, its seed, the packing's file, whichever
/// of file and scene gives the box. Each refusal has key, both values, and what would be right.
#[test]
fn other_spheres_and_another_box_are_refused() {
    let text = squeezed();
    let state = state_in(&text, "load", 2);
    for (old, new, words) in [
        ("seed = 3", "seed = 4", "`seed` is 4, was 3: it draws other spheres"),
        ("count = 100", "count = 101", "`cloud.count` in [particles] is 101, was 100"),
        (
            "max = [1, 1, 1]",
            "max = [1, 1.5, 1]",
            "to [1, 1.5, 1], it went from [0, 0, 0] to [1, 1, 1]",
        ),
    ] {
        let error = restart(&text, &state, old, new).err().unwrap();
        assert!(error.is_input(), "{error}");
        let message = error.to_string();
        assert!(message.contains(words) && message.contains("without --restart"), "{message}");
    }

    let spheres = "0.3 0.5 0.5 0.2\n0.7 0.5 0.5 0.2\n";
    let file = temporary("packing.txt");
    let packing = |text: &str| std::fs::write(&file, text).unwrap();
    let text = format!(
        "[particles]\npacking = {file:?}\n[dem]\ndt = 1e-5\n[[stage]]\nkind = \"run\"\nsteps = 9"
    );
    packing(&format!("# box 0 0 0 1 1 1\n{spheres}"));
    let mut simulation = start(&text);
    advance(&mut simulation, 3);
    let state = simulation.state();
    let again = |text: &str| Simulation::restart(plan(text), state.clone());
    // The box of the file, said by the scene, is the same box.
    let boxed = format!("[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n{text}");
    packing(spheres);
    assert!(again(&boxed).is_ok());
    let tight = again(&text).err().unwrap().to_string();
    assert!(tight.contains("the box goes from [0.0999"), "{tight}");
    packing(&format!("# box 0 0 0 1 1 1\n{spheres}0.5 0.9 0.5 0.05\n"));
    let more = again(&text).err().unwrap().to_string();
    assert!(more.contains("has 3 spheres, the run began with 2"), "{more}");
    packing(&format!("# box 0 0 0 1 1 1\n{}", spheres.replace("0.7", "0.72")));
    let moved = again(&text).err().unwrap().to_string();
    assert!(moved.contains("other positions or radii"), "{moved}");
    std::fs::remove_file(&file).unwrap();
}

/// The strain of pores counts from the positions that their network was built of, also where a
/// restart brings the rule.
#[test]
fn a_strain_rule_counts_from_the_last_remesh() {
    let load = "walls = { y_max = { velocity = -0.5 } }";
    let text = squeezed().replace("walls = { y_max = { stress = 1.1e4 } }", load);
    let text = text.replace("remesh_interval = 40", "remesh_interval = 1000");
    let state = state_in(&text, "load", 30);
    let rule = "remesh_interval = 1000\nremesh_strain = 1e-3";
    // 30 steps of 0.15 mm have strained the box by 0.4 %: the network is due at once.
    let mut strained = restart(&text, &state, "remesh_interval = 1000", rule).unwrap();
    strained.advance().unwrap();
    assert_eq!(strained.coupled().network_age(), 1);
}

/// A checkpoint of an earlier format is refused in one sentence.
#[test]
fn an_earlier_format_is_refused() {
    let file = temporary("format.dempfv");
    checkpoint::save(&file, &7_u64).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    // The format's number stands behind the eight magic bytes.
    bytes[8] = 7;
    std::fs::write(&file, bytes).unwrap();
    let error = checkpoint::load::<u64>(&file).unwrap_err().to_string();
    std::fs::remove_file(&file).unwrap();
    assert!(error.contains("format 7") && error.contains("format 11"), "{error}");
    assert!(error.contains("begin the run anew"), "{error}");
}

/// A stage that has begun keeps its name and its place: another name, a stage before it, or none in
/// its place would go on with what it was told, so it is refused.
#[test]
fn stages_that_have_begun_keep_their_names() {
    let text = squeezed();
    let state = state_in(&text, "load", 50);
    let other = "[[stage]]\nkind = \"run\"\nname = \"other\"\nsteps = 40\n";
    let load = text.find("[[stage]]\n        kind = \"run\"\n        name = \"load\"").unwrap();
    let rest = text.find("[[stage]]\n        kind = \"run\"\n        name = \"rest\"").unwrap();
    let renamed = text.replacen("name = \"load\"", "name = \"Load\"", 1);
    let before = format!("{}{other}{}", &text[..load], &text[load..]);
    let without = format!("{}{}", &text[..load], &text[rest..]);
    for (edited, found) in [(renamed, "`Load`"), (before, "`other`"), (without, "`rest`")] {
        let error = Simulation::restart(plan(&edited), state.clone()).err().unwrap();
        let message = error.to_string();
        assert!(error.is_input() && message.contains("`load`"), "{message}");
        assert!(message.contains(found), "{message}");
    }
}
