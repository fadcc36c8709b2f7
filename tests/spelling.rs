//! Numbers and texts as people write them, and files that are something else: each message says
//! what is wrong and how to write it, and no byte of a file reaches the terminal as a command.

mod program;

use program::{Folder, error};
use serde_json::Value;

const SCENE: &str = r#"seed = 1
[box]
min = [0.0, 0.0, 0.0]
max = [1.0, 1.0, 1.0]
[particles]
cloud = { count = 100, porosity = 0.9 }
[dem]
[fluid]
viscosity = 1.0e-3
pressure = { y_max = 0.0 }
[[stage]]
kind = "run"
steps = 1000
"#;

fn checked(folder: &Folder, old: &str, new: &str) -> std::process::Output {
    assert!(SCENE.contains(old), "{old}");
    folder.write("scene.toml", &SCENE.replacen(old, new, 1));
    folder.dempfv(&["check", "scene.toml", "--json", "report.json"])
}

/// What is no TOML, or no number there, is told with the line and the right spelling.
#[test]
fn a_wrong_spelling_is_told_with_the_right_one() {
    let folder = Folder::new("wrong-spelling");
    for (old, new, line, words) in [
        ("1.0e-3", ".001", 9, "write the number as 0.001"),
        ("1.0e-3", "+.5", 9, "write the number as 0.5"),
        ("1.0e-3", "1.", 9, "write the number as 1.0"),
        ("1.0e-3", "1d-3", 9, "write the number as 0.001"),
        ("1.0e-3", "1.0D-3", 9, "write the number as 0.001"),
        ("1.0e-3", "0,001", 9, "write the number with a point and without commas"),
        ("y_max = 0.0", "y_max = .5", 10, "write the number as 0.5"),
        (
            "cloud = { count = 100, porosity = 0.9 }",
            "packing = ../a.txt",
            6,
            "in quotes: \"../a.txt\"",
        ),
        ("steps = 1000", "steps = 1.5e0", 13, "is 1.5e0; give a whole number of 1 or more"),
        ("steps = 1000", "steps = -1e3", 13, "is -1e3; give a whole number of 1 or more"),
        // Which whole number a float above 2⁵³ is, it does not say.
        ("steps = 1000", "steps = 1e16", 13, "is 1e16; give a whole number"),
        (
            "steps = 1000",
            "steps = \"1000\"",
            13,
            "is a text (\"1000\"); give a whole number of 1 or more, without quotes: 1000",
        ),
        ("1.0e-3", "1e-3Pa·s", 9, "write the number without `Pa·s`"),
        ("1.0e-3", "\u{2212}1e-3", 9, "write the number as -0.001"),
        ("y_max = 0.0", "y_max = \"5 kPa\"", 10, "in Pa, without quotes and without `kPa`"),
        ("[dem]", "[dem]\ndt = \"1e-5\"", 8, "s, or \"auto\", without quotes: 1e-5"),
    ] {
        let output = checked(&folder, old, new);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{new}: {message}");
        assert!(message.contains(&format!("scene.toml:{line}: ")), "{new}: {message}");
        assert!(message.contains(words) && message.lines().count() == 1, "{new}: {message}");
    }
}

/// A whole number may have a point, an exponent, a sign, thousands, or another base.
#[test]
fn whole_numbers_are_read_in_any_spelling_that_is_exact() {
    let folder = Folder::new("right-spelling");
    for spelling in ["1e3", "1000.0", "1.0e3", "+1000", "1_000", "1_000.0", "0x3e8", "0o1750"] {
        let output = checked(&folder, "steps = 1000", &format!("steps = {spelling}"));
        assert!(output.status.success(), "{spelling}: {}", error(&output));
        let steps =
            &folder.json("report.json")["plan"]["stages"][0]["kind"]["run"]["until"]["steps"];
        assert_eq!(*steps, Value::from(1000), "{spelling}");
    }
    for (spelling, viscosity) in [("0x10", 16.0), ("1_000", 1000.0), ("1_000.5", 1000.5)] {
        let output = checked(&folder, "1.0e-3", spelling);
        assert!(output.status.success(), "{spelling}: {}", error(&output));
        let read = &folder.json("report.json")["plan"]["fluid"]["viscosity"];
        assert_eq!(*read, Value::from(viscosity), "{spelling}");
    }
}

/// What makes a terminal blink, clear its screen or change its title: a bell, escape sequences of
/// both forms, a line that overwrites the one before it, and characters that turn the text round.
const HOSTILE: &str = "\u{7}\u{1b}[2J\u{1b}]0;t\u{9b}31m\r\u{8}\u{202e}\u{feff}";

/// One line without anything that a terminal would obey, and not a screen full.
fn assert_harmless(output: &std::process::Output, of: &str) {
    let message = error(output);
    assert_eq!(output.status.code(), Some(2), "{of}: {message:?}");
    let text = message.strip_suffix('\n').unwrap_or(&message);
    let hostile = |c: char| c.is_control() || "\u{202e}\u{feff}\u{9b}".contains(c);
    assert!(!text.contains(hostile), "{of}: {message:?}");
    assert!(text.len() < 1000, "{of}: {} bytes", text.len());
}

#[test]
fn no_byte_of_a_file_reaches_the_terminal_as_a_command() {
    let folder = Folder::new("hostile");
    let long = HOSTILE.repeat(2000);
    let run = |arguments: &[&str]| folder.dempfv(arguments);

    // A scene: in a key, a text, a name, a comment without end; and as raw bytes.
    for (old, new) in [
        ("[dem]", format!("[\"de{HOSTILE}m\"]").replace('\u{1b}', "\\u001b")),
        ("kind = \"run\"", format!("kind = \"{}\"", "\\u001b[2J".repeat(500))),
        ("kind = \"run\"", format!("kind = \"run\"\nname = \"{}\"\nname = 1", "\\u001b[2J")),
        ("seed = 1", format!("seed = \"{}\"", "\\u001b[2J\\u0007".repeat(500))),
        ("seed = 1", format!("seed = {long}")),
        ("seed = 1", format!("\u{1b}[2J = 1{long}")),
    ] {
        assert_harmless(&checked(&folder, old, &new), &format!("a scene with {old}"));
    }
    let bytes: Vec<u8> = (0..=255).cycle().take(100_000).collect();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.0.join(name), bytes).unwrap();
    write("raw", &bytes);
    for arguments in [
        ["check", "raw"],
        ["run", "raw"],
        ["network", "raw"],
        ["permeability", "raw"],
        ["solve", "raw"],
    ] {
        assert_harmless(&run(&arguments), arguments[0]);
    }

    // Packings and matrices: a word, a line, a header.
    let matrix = "%%MatrixMarket matrix coordinate real symmetric\n";
    for (name, text) in [
        ("packing", format!("0.5 0.5 {HOSTILE}x 0.1\n")),
        ("packing", format!("0.5 0.5 0.5 {}\n", long.replace('\r', ""))),
        ("packing", format!("x y z {}\n1 1 1 1\n", "\u{1b}[2J".repeat(999))),
        ("solve", format!("%%MatrixMarket matrix {HOSTILE} real symmetric\n")),
        ("solve", format!("{matrix}{long}\n")),
        ("solve", format!("{matrix}1 1 1\n1 1 {long}\n")),
        ("solve", format!("{matrix}1 1 1\n{long} 1 1\n")),
        ("solve", format!("{matrix}1 1 1\n1 1 1.0\n{long}\n")),
    ] {
        folder.write("file", &text);
        let command = if name == "packing" { "network" } else { "solve" };
        assert_harmless(&run(&[command, "file"]), &format!("{name}: {:.60}", text.escape_debug()));
    }

    // Checkpoints: raw bytes, another program's version, and names within.
    folder.write("scene.toml", SCENE);
    let restart = |of: &str| {
        assert_harmless(&run(&["run", "scene.toml", "--restart", "raw"]), of);
    };
    restart("raw bytes");
    let mut head = b"dempfvCP\x07\0\0\0".to_vec();
    head.extend([0; 12]);
    head.extend((long.len() as u32).to_le_bytes());
    head.extend(long.as_bytes());
    write("raw", &head);
    restart("a version");
    write("raw", long.as_bytes());
    restart("text");
}
