//! The state that a run ends with: a packing, snapshots, contacts, and a checkpoint from which
//! other scenes start.

mod program;

use program::{Folder, error};

const STAGES: &str =
    "[[stage]]\nkind = \"run\"\nsteps = 30\nwalls = { y_max = { stress = 1.1e4 } }";

/// A scene that starts from the spheres of a file and does nothing but look.
fn from(packing: &str) -> String {
    format!(
        "[particles]\npacking = \"{packing}\"\nyoung = 1.0e6\n[dem]\ndt = 1e-12\n\
         [[stage]]\nkind = \"run\"\nsteps = 1\n[output]\npictures = false\n"
    )
}

/// Without being asked for snapshots or checkpoints, a finished run leaves both, and a packing. A scene
/// starts from either, with the same bits: places, radii and the box of the end, at rest.
#[test]
fn a_finished_run_leaves_its_state() {
    let folder = Folder::new("end-state");
    folder.write("scene.toml", &program::scene(STAGES, ""));
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let steps = folder.json("out/summary.json")["steps"].as_u64().unwrap();
    for kind in ["spheres", "pores"] {
        assert!(folder.0.join(format!("out/{kind}-{steps:09}.vtu")).exists(), "{kind}");
        assert!(
            folder.read(&format!("out/{kind}.pvd")).contains(&format!("{kind}-{steps:09}.vtu"))
        );
    }
    folder.write("text.toml", &from("out/final-packing.txt"));
    folder.write("state.toml", &from("out/checkpoint.dempfv"));
    let hash = |scene: &str, out: &str| {
        folder.done(&["run", scene, "--out", out]);
        folder.json(&format!("{out}/summary.json"))["state_hash"].clone()
    };
    assert_eq!(hash("text.toml", "text"), hash("state.toml", "state"));
    // The box has come down from 1 m under the load.
    let packing = folder.read("out/final-packing.txt");
    let edges = packing.lines().find(|l| l.starts_with("# box")).unwrap();
    let top: f64 = edges.split_whitespace().nth(6).unwrap().parse().unwrap();
    assert!(top < 1.0 && top > 0.9, "{edges}");

    // Commands that read packings read checkpoints too, and tell a foreign one.
    let k = folder.done(&["permeability", "out/checkpoint.dempfv", "--json", "-"]);
    assert_eq!(k, folder.done(&["permeability", "out/final-packing.txt", "--json", "-"]));
    folder.done(&["pack", "out/checkpoint.dempfv", "--tile", "2", "1", "1", "--out", "two"]);
    assert_eq!(folder.read("two/packing.txt").lines().filter(|l| !l.starts_with('#')).count(), 240);
    let bytes = std::fs::read(folder.0.join("out/checkpoint.dempfv")).unwrap();
    std::fs::write(folder.0.join("cut.dempfv"), &bytes[..bytes.len() / 2]).unwrap();
    let cut = folder.dempfv(&["permeability", "cut.dempfv"]);
    assert_eq!(cut.status.code(), Some(2));
    assert!(error(&cut).contains("cut short"), "{}", error(&cut));

    // More stages than the run had: it goes on from where it ended.
    let more = format!("{STAGES}\n[[stage]]\nkind = \"run\"\nname = \"more\"\nsteps = 10\n");
    folder.write("more.toml", &program::scene(&more, ""));
    folder.done(&["run", "more.toml", "--restart", "out/checkpoint.dempfv", "--out", "more"]);
    assert_eq!(folder.json("more/summary.json")["steps"].as_u64(), Some(steps + 10));
}

/// The table of contacts has those that the summary counts; on each wall their normal forces add up to
/// the stress that the history has; no shear is above tan 30° of the normal force, and shear is
/// normal to the normal.
#[test]
fn contacts_are_listed() {
    let folder = Folder::new("contacts");
    folder.write("scene.toml", &program::scene(STAGES, "contacts = true\nstate = true"));
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let table = folder.read("out/contacts.csv");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| names.iter().position(|n| *n == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len() as u64, folder.json("out/summary.json")["contacts"].as_u64().unwrap());
    let number = |row: &[&str], name: &str| row[at(name)].parse::<f64>().unwrap();
    let history = folder.read("out/history.csv");
    let header: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let last: Vec<&str> = history.lines().last().unwrap().split(',').collect();
    let value = |name: &str| -> f64 {
        last[header.iter().position(|h| *h == name).unwrap()].parse().unwrap()
    };
    for wall in ["x_min", "y_max"] {
        let of_wall = rows.iter().filter(|row| row[at("partner")] == wall);
        let force: f64 = of_wall.map(|row| number(row, "normal_force_n")).sum();
        let area = if wall == "x_min" {
            value("size_y_m") * value("size_z_m")
        } else {
            value("size_x_m") * value("size_z_m")
        };
        let stress = value(&format!("contact_stress_{wall}_pa"));
        // The history has the forces of the last step's beginning, the list those of its end.
        assert!((force / area / stress - 1.0).abs() < 0.01, "{wall}: {} {stress}", force / area);
    }
    for row in &rows {
        let shear = ["shear_x_n", "shear_y_n", "shear_z_n"].map(|n| number(row, n));
        let normal = ["normal_x", "normal_y", "normal_z"].map(|n| number(row, n));
        let (size, force) = (number(row, "shear_force_n"), number(row, "normal_force_n"));
        assert!(size <= 30f64.to_radians().tan() * force * 1.01, "{row:?}");
        let along: f64 = shear.iter().zip(normal).map(|(s, n)| s * n).sum();
        assert!(along.abs() <= 1e-2 * force, "{row:?}");
    }
}

/// Pictures of q, volume and pore pressure where a stage shears; none where one does not. A plane that
/// does not cut the box is refused, and so is one without a fluid.
#[test]
fn pictures_follow_what_a_scene_does() {
    let folder = Folder::new("shear");
    let shear = "[[stage]]\nkind = \"run\"\nname = \"shear\"\nuntil = { strain = 0.002, axis = \"y\" }\n\
                 walls = { y_max = { velocity = -0.1 } }";
    let plane = |at: &str| format!("section = {{ axis = \"x\", position = {at} }}");
    folder.write("scene.toml", &program::scene(&format!("{STAGES}\n{shear}"), &plane("0.3")));
    folder.done(&["run", "scene.toml", "--out", "out"]);
    let picture = folder.read("out/shear-shear.svg");
    assert!(picture.contains("<svg"));
    assert!(!folder.0.join("out/shear-run.svg").exists());
    assert!(
        folder.0.join("out/stress-run.svg").exists() && folder.0.join("out/section.svg").exists()
    );
    folder.write("outside.toml", &program::scene(STAGES, &plane("1.5")));
    let outside = folder.dempfv(&["check", "outside.toml"]);
    assert_eq!(outside.status.code(), Some(2));
    assert!(error(&outside).contains("from 0 to 1"), "{}", error(&outside));
}
