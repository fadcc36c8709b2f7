//! The reference of scene keys (docs/scene.md) tells what the parser does.

use std::collections::BTreeSet;
use std::path::Path;

use dempfv::scene::{Plan, known_keys};

/// A row of a table of keys.
struct Row {
    /// Heading above it, in lower case: the name of the table.
    section: String,
    key: String,
    default: String,
}

fn rows() -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene.md");
    let text = std::fs::read_to_string(path).unwrap();
    let mut rows = Vec::new();
    let mut section = String::new();
    for line in text.lines() {
        if line.starts_with('#') {
            section = line.trim_start_matches('#').trim().to_lowercase();
        } else if line.starts_with("| `") {
            let cells: Vec<&str> = line.split(" |").map(|c| c.trim_matches(['|', ' '])).collect();
            let key = cells[0].trim_matches('`').to_owned();
            rows.push(Row { section: section.clone(), key, default: cells[2].to_owned() });
        }
    }
    rows
}

#[test]
fn every_known_key_is_described_and_every_described_key_is_known() {
    let described: BTreeSet<(String, String)> =
        rows().into_iter().map(|r| (r.section, r.key)).collect();
    let known: BTreeSet<(String, String)> = known_keys()
        .flat_map(|(table, keys)| keys.iter().map(move |k| (table.to_owned(), (*k).to_owned())))
        .collect();
    let missing: Vec<_> = known.difference(&described).collect();
    let dead: Vec<_> = described.difference(&known).collect();
    assert!(missing.is_empty(), "not in docs/scene.md: {missing:?}");
    assert!(dead.is_empty(), "unknown to the parser: {dead:?}");
}

/// Writing every default of the reference into a scene changes nothing.
#[test]
fn defaults_are_those_of_the_reference() {
    let rows = rows();
    let defaults = |section: &str| -> String {
        rows.iter()
            .filter(|r| r.section == section && r.default.starts_with('`'))
            .map(|r| format!("{} = {}\n", r.key, r.default.trim_matches('`')))
            .collect()
    };
    let inline = |section: &str| defaults(section).trim_end().replace('\n', ", ");
    let scene = |explicit: bool| {
        let table = |section: &str| if explicit { defaults(section) } else { String::new() };
        let (cloud, until, walls) = match explicit {
            true => (
                format!(", {}", inline("`cloud`")),
                format!(", {}", inline("`until`")),
                // One wall moves, or the strain would never come.
                format!(
                    "{{ {} }}",
                    inline("`walls`").replace("x_max = \"fixed\"", "x_max = { stress = 1 }")
                ),
            ),
            false => (String::new(), String::new(), "{ x_max = { stress = 1 } }".to_owned()),
        };
        format!(
            "title = \"t\"\n{}\n[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\
             [particles]\ncloud = {{ count = 9, radius = 0.01{cloud} }}\n{}\n\
             [walls]\n{}\n[dem]\n{}\n[fluid]\nviscosity = 1\npressure = {{ y_max = 0 }}\n{}\n[output]\n{}\n\
             [[stage]]\nkind = \"compact\"\nstress = 1\n{}\n\
             [[stage]]\nkind = \"cycle\"\nwall = \"y_max\"\nfrom = 1\nto = 2\n{}\n\
             [[stage]]\nkind = \"permeability\"\naxis = \"y\"\n{}\n\
             [[stage]]\nkind = \"consolidate\"\nwall = \"y_max\"\nstress = 2\nuntil_tv = 1\n{}\n\
             [[stage]]\nkind = \"run\"\nuntil = {{ strain = 0.1, axis = \"x\"{until} }}\nwalls = {walls}\n",
            table("the scene"),
            table("[particles]"),
            table("[walls]"),
            table("[dem]"),
            table("[fluid]"),
            table("[output]"),
            table("a compact stage"),
            table("a cycle stage"),
            table("a permeability stage"),
            table("a consolidate stage"),
        )
    };
    let read = |explicit| {
        let text = scene(explicit);
        Plan::from_toml(&text, None).unwrap_or_else(|e| panic!("{e}\n{text}"))
    };
    assert_eq!(read(true), read(false));
    assert!(scene(true).contains("damping = 0.2"), "no defaults were found");
}
