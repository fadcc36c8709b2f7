//! docs/effects.md is what the effects say of themselves.
//!
//! `DEMPFV_WRITE_DOCS=1 cargo test --test effects_page` writes the page anew.

use std::fmt::Write;
use std::path::Path;

use dempfv::scene::{Plan, known_keys};
use dempfv::{Effect, EffectKey, Family};

const HEAD: &str = "\
# Effects

A scene simulates the effects that it names, and nothing else: what is off has no array, no branch in
a loop, no library call. `dempfv check SCENE` lists what is on, what that makes necessary, and what is
off. This page is written from what each effect's file says of itself. The cost is what a step takes
more at 20,000 spheres than without the effect, where `make effect-costs` has measured it.
";

const FAMILIES: [(Family, &str); 5] = [
    (Family::Contacts, "Contacts"),
    (Family::Bodies, "Spheres"),
    (Family::Boundaries, "Walls and cells"),
    (Family::Fluid, "Fluid"),
    (Family::Numerics, "How it is computed"),
];

fn effects() -> Vec<&'static Effect> {
    Plan::default().effects().into_iter().map(|(effect, _)| effect).collect()
}

/// The costs that the last `make effect-costs` found.
fn costs() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/effect-costs.csv"))
        .unwrap()
}

/// What an effect adds to a step, and on top of which scene; nothing where it was not priced.
fn cost(effect: &str, costs: &str) -> String {
    let mut rows = costs.lines().map(|row| row.split(',').collect::<Vec<_>>());
    match rows.find(|row| row[0] == effect).as_deref() {
        Some([_, over, adds, _]) if !adds.is_empty() => format!("{adds} % of {over}"),
        Some([_, _, _, step]) => format!("{step} ms"),
        _ => String::new(),
    }
}

fn page() -> String {
    let costs = costs();
    let mut page = HEAD.to_owned();
    for (family, title) in FAMILIES {
        let _ = write!(
            page,
            "\n## {title}\n\n| effect | equation | keys (unit, default) | needs | cost | source | test |\n\
             |---|---|---|---|---|---|---|\n"
        );
        for effect in effects().into_iter().filter(|effect| effect.family == family) {
            let Effect { name, equation, source, needs, test, .. } = effect;
            let keys: Vec<String> = effect.keys.iter().map(key).collect();
            let keys = keys.join("; ");
            let cost = cost(name, &costs);
            let cells = [name, equation, keys.as_str(), needs, cost.as_str(), source, test];
            let cells = cells.map(|cell| cell.replace('|', "\\|"));
            let _ = writeln!(page, "| {} |", cells.join(" | "));
        }
    }
    page
}

fn key(EffectKey { key, unit, default }: &EffectKey) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!("{unit}, ") };
    format!("{key} ({unit}{default})")
}

#[test]
fn the_page_is_what_effects_say() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/effects.md");
    let page = page();
    if std::env::var_os("DEMPFV_WRITE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        there == page,
        "docs/effects.md is old; DEMPFV_WRITE_DOCS=1 cargo test --test effects_page"
    );
}

/// Each effect has a name of its own, an equation and a test that is there, and its keys are keys
/// of scenes.
#[test]
fn what_effects_say_is_so() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let known: Vec<&str> = known_keys().flat_map(|(_, keys)| keys.iter().copied()).collect();
    let effects = effects();
    for (i, effect) in effects.iter().enumerate() {
        let name = effect.name;
        assert!(effects[..i].iter().all(|other| other.name != name), "{name} twice");
        assert!(!effect.equation.is_empty(), "{name}");
        for key in effect.keys {
            let word = key.key.split([' ', '.']).next().unwrap();
            assert!(known.contains(&word), "{name}: `{word}` is no key");
        }
        let tests = effect.test.split(", ").filter(|test| test.ends_with(".rs"));
        assert!(!effect.test.is_empty(), "{name}");
        for test in tests {
            assert!(root.join(test).exists(), "{name}: no {test}");
        }
    }
}
