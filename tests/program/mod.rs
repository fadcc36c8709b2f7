//! The program as a user runs it, in a folder of its own.
#![allow(dead_code, reason = "every test file uses some of these")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// A folder of one test, gone at its end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("dempfv-run-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        let path = self.0.join(name);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Every file below the folder, with its bytes.
    pub fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut found = BTreeMap::new();
        collect(&self.0, &mut found);
        found
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dempfv"));
        command.current_dir(&self.0).args(args);
        command
    }

    pub fn dempfv(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Runs the program, interrupts it when this file is there (the handler stands before
    /// the first file is written), and expects it to say so.
    pub fn interrupt(&self, args: &[&str], file: &str) {
        let mut child =
            self.command(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let patience = Instant::now();
        while !self.0.join(file).exists() && patience.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let kill = format!("kill -INT {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
    }

    /// Runs the program and expects it to be done.
    pub fn done(&self, args: &[&str]) -> String {
        let output = self.dempfv(args);
        assert!(output.status.success(), "{args:?}: {}", error(&output));
        String::from_utf8(output.stdout).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn collect(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, found);
        } else {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
}

pub fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A packing that the project ships.
pub fn packing(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("packings").join(name).to_str().unwrap().to_owned()
}

/// A cloud of 120 spheres in a box of 1 m that settles at 10 kPa, and further
/// stages. The shipped oedometer in small.
pub fn scene(stages: &str, output: &str) -> String {
    format!(
        r#"title = "small"
seed = 3
[box]
min = [0, 0, 0]
max = [1, 1, 1]
[particles]
cloud = {{ count = 120, spread = 0.3333, porosity = 0.95 }}
young = 1.0e6
[dem]
dt = 3.0e-4
damping = 0.2
[fluid]
viscosity = 10.0
remesh_interval = 40
remesh_strain = 1e-3
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "compact"
stress = 1.0e4
friction_angle = 3.0
dt = "auto"
{stages}
[output]
history_every = 10
{output}
"#
    )
}

/// Everything that a consolidation needs, and a shear after it.
pub const STAGES: &str = r#"
[[stage]]
kind = "cycle"
wall = "y_max"
from = 1.0e4
to = 1.1e4
cycles = 1
[[stage]]
kind = "permeability"
axis = "y"
[[stage]]
kind = "consolidate"
wall = "y_max"
stress = 1.1e4
until_tv = 0.03
profiles = [0.001, 0.01]
max_velocity = 0.1
[[stage]]
kind = "run"
steps = 150
walls = { x_min = { velocity = 0.05 } }
"#;
