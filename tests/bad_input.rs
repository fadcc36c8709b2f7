//! Whatever is wrong in the input: exit status 2, one message that names file, line and
//! remedy, and nothing written.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own for each test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path =
            std::env::temp_dir().join(format!("dempfv-bad-input-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn check(folder: &Path, scene: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dempfv"))
        .current_dir(folder)
        .args(["check", "--json", "report.json"])
        .arg(scene)
        .output()
        .unwrap()
}

/// A good scene; the faults are edits of it. Line numbers count from its first line.
const GOOD: &str = r#"title = "good"
seed = 1
[box]
min = [0.0, 0.0, 0.0]
max = [1.0, 1.0, 1.0]
[particles]
cloud = { count = 100, spread = 0.3, porosity = 0.9 }
density = 2600.0
young = 1.0e6
friction_angle = 30.0
[walls]
friction_angle = 0.0
[dem]
dt = 1.0e-4
damping = 0.2
gravity = [0, 0, -9.81]
[fluid]
viscosity = 1.0e-3
clamp = "none"
solver = "cholmod"
pressure = { y_max = 0.0 }
no_flow = ["x_min"]
[[stage]]
kind = "compact"
stress = 1.0e4
[[stage]]
kind = "cycle"
wall = "y_max"
from = 1.0e4
to = 1.1e4
[[stage]]
kind = "permeability"
axis = "y"
[[stage]]
kind = "consolidate"
wall = "y_max"
stress = 1.1e4
until_tv = 1.5
profiles = [0.1, 0.5]
[[stage]]
kind = "run"
steps = 10
walls = { y_max = { stress = 1.0e3 }, x_min = "fixed" }
[output]
history_every = 10
"#;

/// One fault: what to replace in the good scene by what, the line of the message, and
/// what the message must say (what is wrong, and the remedy).
type Fault = (&'static str, &'static str, usize, &'static [&'static str]);

const FAULTS: &[Fault] = &[
    // Names.
    ("density", "densty", 8, &["unknown key `densty` in [particles]", "did you mean `density`?"]),
    ("viscosity", "viscocity", 18, &["unknown key `viscocity`", "did you mean `viscosity`?"]),
    ("[dem]", "[demm]", 13, &["unknown key `demm`", "did you mean `dem`?"]),
    (
        "damping = 0.2",
        "viscosity = 0.2",
        15,
        &["unknown key `viscosity` in [dem]", "it belongs in [fluid]"],
    ),
    ("damping", "qwertyuiop", 15, &["unknown key `qwertyuiop`", "known: dt, safety, damping"]),
    ("\"cholmod\"", "\"colmod\"", 20, &["`solver`", "\"colmod\"", "did you mean `cholmod`?"]),
    ("\"none\"", "\"yadde\"", 19, &["`clamp`", "did you mean `yade`?"]),
    ("wall = \"y_max\"\nfrom", "wall = \"y_maxx\"\nfrom", 28, &["did you mean `y_max`?"]),
    ("\"compact\"", "\"compct\"", 24, &["`kind`", "did you mean `compact`?"]),
    (
        "pressure = { y_max",
        "pressure = { ymax",
        21,
        &["unknown wall `ymax`", "did you mean `y_max`?"],
    ),
    ("no_flow = [\"x_min\"]", "no_flow = [\"front\"]", 22, &["\"front\"", "known: x_min, x_max"]),
    ("axis = \"y\"", "axis = \"w\"", 33, &["`axis`", "\"w\""]),
    // Types and units.
    (
        "viscosity = 1.0e-3",
        "viscosity = \"1e-3 Pa s\"",
        18,
        &["a text (\"1e-3 Pa s\")", "a number above 0 in Pa·s"],
    ),
    ("young = 1.0e6", "young = true", 9, &["`young`", "true", "in Pa"]),
    ("title = \"good\"", "title = 3", 1, &["`title` is 3", "a text in quotes"]),
    ("seed = 1", "seed = 1.5", 2, &["`seed` is 1.5", "a whole number"]),
    ("seed = 1", "seed = -1", 2, &["`seed` is -1", "a whole number of 0 or more"]),
    ("gravity = [0, 0, -9.81]", "gravity = -9.81", 16, &["`gravity`", "three numbers in m/s²"]),
    ("gravity = [0, 0, -9.81]", "gravity = [0, -9.81]", 16, &["has 2 numbers", "three numbers"]),
    ("no_flow = [\"x_min\"]", "no_flow = \"x_min\"", 22, &["`no_flow`", "an array of wall names"]),
    ("[dem]", "[[dem]]", 13, &["[dem]", "an array", "give a table"]),
    // Values.
    ("dt = 1.0e-4", "dt = 0.0", 14, &["`dt` in [dem] is 0.0", "a number above 0 in s"]),
    ("dt = 1.0e-4", "dt = \"automatic\"", 14, &["`dt`", "auto"]),
    ("dt = 1.0e-4", "dt = nan", 14, &["`dt` in [dem] is nan", "a number above 0"]),
    ("density = 2600.0", "density = -2600.0", 8, &["is -2600.0", "above 0 in kg/m³"]),
    ("viscosity = 1.0e-3", "viscosity = inf", 18, &["is inf", "above 0 in Pa·s"]),
    ("damping = 0.2", "damping = 1.0", 15, &["from 0 to below 1"]),
    ("clamp = \"none\"", "remesh = \"backgrond\"", 19, &["did you mean `background`?"]),
    ("clamp = \"none\"", "remesh_interval = \"automatic\"", 19, &["`remesh_interval`", "auto"]),
    (
        "clamp = \"none\"",
        "remesh_interval = \"auto\"",
        19,
        &["a background that is not there", "add `remesh = \"background\"`"],
    ),
    (
        "clamp = \"none\"",
        "swap = \"when ready\"",
        19,
        &["nothing is built in the background", "add `remesh = \"background\"`"],
    ),
    (
        "clamp = \"none\"",
        "on_failure = \"retry\"",
        19,
        &["no old network left to go on with", "add `remesh = \"ahead\"`"],
    ),
    ("friction_angle = 30.0", "friction_angle = 90.0", 10, &["below 90 in degrees"]),
    ("porosity = 0.9", "porosity = 1.0", 7, &["`porosity`", "above 0 and below 1"]),
    ("porosity = 0.9", "porosity = 0.3", 7, &["do not fit", "porosity above 0.62"]),
    ("count = 100", "count = 0", 7, &["`count`", "1 or more"]),
    ("porosity = 0.9", "radius = 0.7", 7, &["do not fit"]),
    ("max = [1.0, 1.0, 1.0]", "max = [1.0, 0.0, 1.0]", 5, &["y = 0", "a `max` above `min`"]),
    ("to = 1.1e4", "to = 0.9e4", 30, &["is 9000, not above `from` = 10000"]),
    ("profiles = [0.1, 0.5]", "profiles = [0.5, 0.1]", 39, &["0.1 after 0.5", "ascending"]),
    (
        "profiles = [0.1, 0.5]",
        "profiles = [0.5, 2.0]",
        39,
        &["2 after 0.5", "up to `until_tv` = 1.5"],
    ),
    ("history_every = 10", "history_every = 0", 45, &["1 or more"]),
    ("steps = 10\n", "steps = 0\n", 42, &["`steps`", "1 or more"]),
    // Parts against each other.
    (
        "[particles]\ncloud = { count = 100, spread = 0.3, porosity = 0.9 }",
        "[particles]\npacking = \"none.txt\"",
        7,
        &["there is no file", "none.txt", "name an existing packing file"],
    ),
    (
        "density = 2600.0",
        "packing = \"none.txt\"",
        8,
        &["`packing` in [particles] is a second source", "keep `packing` or `cloud`"],
    ),
    ("cloud = {", "# cloud = {", 6, &["neither `packing` nor `cloud`", "give `packing"]),
    ("porosity = 0.9", "porosity = 0.9, radius = 0.1", 7, &["more than one of", "keep one"]),
    (", porosity = 0.9", "", 7, &["how large the spheres are", "give one of `porosity`"]),
    (
        "no_flow = [\"x_min\"]",
        "no_flow = [\"x_min\", \"y_max\"]",
        22,
        &["y_max, which has two conditions", "take y_max out"],
    ),
    (
        "stress = 1.0e3 }",
        "stress = 1.0e3, velocity = 0.1 }",
        43,
        &["y_max has two conditions", "keep one of the two"],
    ),
    (
        "stress = 1.0e3 }",
        "velocity = 0.1, max_velocity = 1.0 }",
        43,
        &["`max_velocity`", "it belongs to `stress`"],
    ),
    ("\"fixed\"", "7", 43, &["`x_min` in `walls`", "give \"fixed\""]),
    (
        "pressure = {",
        "# pressure = {",
        17,
        &["no wall with imposed pressure and no storage", "undetermined", "add `pressure"],
    ),
    ("steps = 10\n", "steps = 10\ntime = 1.0\n", 43, &["more than one end", "give one of `steps"]),
    ("steps = 10\n", "", 40, &["does not say when it ends", "give one of `steps"]),
    (
        "steps = 10\n",
        "until = { strain = 0.1, axis = \"z\" }\n",
        40,
        &["the walls there do not move", "a velocity or a stress"],
    ),
    (
        "steps = 10\nwalls = { y_max = { stress = 1.0e3 }, x_min = \"fixed\" }",
        "until = { strain = 0.1, axis = \"x\" }\nwalls = { x_min = { velocity = -0.1 } }",
        40,
        &["the walls move the other way", "positive in compression"],
    ),
    ("viscosity = 1.0e-3\n", "", 17, &["[fluid] has no `viscosity`", "a number above 0 in Pa·s"]),
    (
        "kind = \"cycle\"\nwall = \"y_max\"",
        "kind = \"cycle\"\nwall = \"x_max\"",
        34,
        &["needs the oedometric modulus along y", "kind = \"cycle\" and wall = \"y_max\""],
    ),
    (
        "axis = \"y\"",
        "axis = \"x\"",
        34,
        &["needs the permeability along y", "kind = \"permeability\" and axis = \"y\""],
    ),
    (
        "y_max = 0.0 }",
        "y_max = 0.0, z_min = 0.0 }",
        34,
        &["z_min drains across it", "on y_max, y_min or both, and on no other wall"],
    ),
    (
        "y_max = 0.0 }",
        "y_max = 0.0, y_min = 1.0 }",
        34,
        &["drains at both ends of y, at 0 Pa and at 1 Pa", "the same pressure on y_max and y_min"],
    ),
    (
        "[dem]\ndt = 1.0e-4\ndamping = 0.2\ngravity = [0, 0, -9.81]\n",
        "",
        19,
        &["moves spheres, but there is no [dem]", "add [dem]"],
    ),
    (
        "kind = \"permeability\"",
        "kind = \"permeability\"\nname = \"cycle\"",
        33,
        &["the name of an earlier stage", "a name of its own"],
    ),
    ("kind = \"compact\"", "stress = 2.0", 25, &["TOML", "duplicate key"]),
    ("kind = \"compact\"", "", 23, &["a [[stage]] has no `kind`", "one of compact"]),
    // Mechanics of a stage.
    ("stress = 1.0e4\n", "stress = 1.0e4\ndt = 0.0\n", 26, &["`dt` in a compact stage is 0.0"]),
    ("steps = 10\n", "steps = 10\ndamping = 1.0\n", 43, &["`damping` in a run stage", "below 1"]),
    (
        "axis = \"y\"\n",
        "axis = \"y\"\ndt = 1.0\n",
        34,
        &["unknown key `dt` in a permeability stage", "it belongs in [dem]"],
    ),
    // What is right, but for how it is written.
    ("viscosity = 1.0e-3", "viscosity = .001", 18, &["not TOML", "write the number as 0.001"]),
    ("\"cholmod\"", "cholmod", 20, &["not TOML", "put the text in quotes: \"cholmod\""]),
    (
        "density = 2600.0",
        "packing = ../a.txt",
        8,
        &["not TOML", "put the text in quotes: \"../a.txt\""],
    ),
    // Not TOML.
    ("seed = 1", "seed = ", 2, &["not TOML", "correct the syntax"]),
    ("[fluid]", "[fluid", 17, &["not TOML"]),
];

#[test]
fn every_fault_of_a_scene_is_named_with_its_line_and_remedy() {
    let folder = Folder::new("scenes");
    let good = folder.write("scene.toml", GOOD);
    let output = check(&folder.0, &good);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::remove_file(folder.0.join("report.json")).unwrap();

    let mut wrong = Vec::new();
    for (old, new, line, words) in FAULTS {
        assert!(GOOD.contains(old), "{old} is not in the good scene");
        let scene = folder.write("scene.toml", &GOOD.replacen(old, new, 1));
        let output = check(&folder.0, &scene);
        let message = String::from_utf8(output.stderr).unwrap();
        let place = format!("scene.toml:{line}: ");
        let ok = output.status.code() == Some(2)
            && output.stdout.is_empty()
            && message.starts_with("error: ")
            && message.lines().count() == 1
            && message.contains(&place)
            && message.contains("; ")
            && words.iter().all(|w| message.contains(w))
            && folder.files() == ["scene.toml"];
        if !ok {
            wrong.push(format!("{old:?} -> {new:?}: want {place}{words:?}\n    got {message}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn faults_of_the_whole_scene() {
    let folder = Folder::new("whole");
    let cases: [(&str, &str); 5] = [
        ("", "the scene has no [particles]"),
        ("[particles]\ncloud = { count = 1, radius = 0.1 }\n", "needs a box to fill"),
        (
            "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\ncloud = { count = 1, radius = 0.1 }\n",
            "the scene has no [[stage]]",
        ),
        (
            "stage = []\n[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\ncloud = { count = 1, radius = 0.1 }\n",
            "[[stage]] is empty",
        ),
        (
            "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\ncloud = { count = 1, radius = 0.1 }\n[[stage]]\nkind = \"permeability\"\naxis = \"x\"\n",
            "there is no [fluid]",
        ),
    ];
    for (text, expected) in cases {
        let scene = folder.write("scene.toml", text);
        let output = check(&folder.0, &scene);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected) && message.contains("scene.toml:"), "{message}");
        assert_eq!(folder.files(), ["scene.toml"]);
    }
    let output = check(&folder.0, Path::new("missing.toml"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("missing.toml: cannot read the scene"), "{message}");
}

/// What is wrong in the packing file is told with the packing file's line.
#[test]
fn every_fault_of_a_packing_is_named_with_its_line_and_remedy() {
    const SCENE: &str = "[particles]\npacking = \"p.txt\"\n[fluid]\nviscosity = 1.0\n\
                         [[stage]]\nkind = \"permeability\"\naxis = \"x\"\n";
    const HEAD: &str = "# box 0 0 0 1 1 1\n0.5 0.5 0.5 0.1\n";
    let cases: [(&str, Option<usize>, &[&str]); 9] = [
        ("0.5 0.5 0.2 nan\n", Some(3), &["finite"]),
        ("0.5 0.5 0.2 -0.1\n", Some(3), &["-0.1", "positive"]),
        ("0.5 0.5 0.2 0\n", Some(3), &["radius"]),
        ("0.5 inf 0.2 0.1\n", Some(3), &["finite"]),
        ("0.5 0.5 0.2\n", Some(3), &["3 columns"]),
        (
            "\n0.5 0.5 1.2 0.1\n",
            Some(4),
            &["sphere 1", "outside the box", "z_max", "move it inside"],
        ),
        ("0.95 0.5 0.5 0.1\n", Some(3), &["sphere 1", "pokes through x_max by 50.0 %"]),
        (
            "0.2 0.2 0.2 0.1\n# pause\n0.5 0.5 0.5 0.1\n",
            Some(5),
            &["sphere 2 is in the same place as sphere 0", "remove one"],
        ),
        ("0.5 0.5 0.5 0.2\n", Some(3), &["sphere 1 is in the same place as sphere 0"]),
    ];
    let folder = Folder::new("packings");
    let scene = folder.write("scene.toml", SCENE);
    let run = |text: &str| {
        folder.write("p.txt", text);
        let output = check(&folder.0, &scene);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert_eq!(folder.files(), ["p.txt", "scene.toml"]);
        message
    };
    for (tail, line, words) in cases {
        let message = run(&format!("{HEAD}{tail}"));
        let place = line.map_or("p.txt: ".to_owned(), |l| format!("p.txt:{l}: "));
        assert!(message.contains(&place), "{place} is not in {message}");
        assert!(words.iter().all(|w| message.contains(w)), "{words:?} are not in {message}");
    }
    let message = run("# nothing but a comment\n");
    assert!(message.contains("p.txt") && message.contains("no sphere"), "{message}");
}

/// Wrong arguments are wrong input too.
#[test]
fn wrong_arguments_exit_with_2() {
    let folder = Folder::new("arguments");
    let scene = folder.write("scene.toml", GOOD);
    let scene = scene.to_str().unwrap();
    let cases: [&[&str]; 5] = [
        &["chekc", scene],
        &["check"],
        &["check", scene, "--threads", "0"],
        &["check", scene, "--threads", "two"],
        &["check", scene, "--json", "no/such/folder/report.json"],
    ];
    for arguments in cases {
        let output = Command::new(env!("CARGO_BIN_EXE_dempfv"))
            .current_dir(&folder.0)
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
        assert_eq!(folder.files(), ["scene.toml"]);
    }
}

/// `--json -` keeps stdout for the report alone; a file is written whole.
#[test]
fn json_goes_where_it_was_sent() {
    let folder = Folder::new("json");
    let scene = folder.write("scene.toml", GOOD);
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_dempfv"))
            .current_dir(&folder.0)
            .arg("check")
            .arg(&scene)
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let on_stdout: serde_json::Value =
        serde_json::from_str(&run(&["--json", "-", "--threads", "1"])).unwrap();
    let text = run(&["--json", "report.json", "--threads", "1"]);
    assert!(text.contains("effects on") && text.contains("time step"));
    let in_file = fs::read_to_string(folder.0.join("report.json")).unwrap();
    let in_file: serde_json::Value = serde_json::from_str(&in_file).unwrap();
    assert_eq!(on_stdout, in_file);
    assert_eq!(in_file["effects"]["on"][0], "contacts");
    assert_eq!(in_file["estimate"]["spheres"], 100);
    assert_eq!(folder.files(), ["report.json", "scene.toml"]);
}
