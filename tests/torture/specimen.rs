//! The run that is disturbed, and what it must leave.

use std::collections::BTreeMap;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{Folder, error};

/// How often something is tried: what the environment says, else a few times.
pub fn count(variable: &str, few: usize) -> usize {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// A generator with a fixed sequence (splitmix64), from `DEMPFV_SEED`.
pub struct Random(u64);

impl Random {
    pub fn new(salt: u64) -> Random {
        Random(salt.wrapping_mul(0x9e37_79b9) ^ count("DEMPFV_SEED", 1) as u64)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % n.max(1)
    }
}

/// A wet cloud that is squeezed for so many steps, with rows, frames and checkpoints.
pub fn scene(steps: u64, [rows, checkpoints, frames]: [u64; 3]) -> String {
    format!(
        r#"title = "torture"
seed = 3
[box]
min = [0, 0, 0]
max = [1, 1, 1]
[particles]
cloud = {{ count = 60, spread = 0.3333, porosity = 0.7 }}
young = 1.0e6
[dem]
dt = 2.0e-4
damping = 0.2
gravity = [0, -9.81, 0]
[fluid]
viscosity = 10.0
remesh_interval = 20
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
name = "squeeze"
steps = {half}
walls = {{ y_max = {{ velocity = -0.2 }} }}
[[stage]]
kind = "run"
name = "shear"
steps = {half}
walls = {{ x_min = {{ velocity = 0.1 }}, y_max = {{ stress = 1.0e3 }} }}
[output]
history_every = {rows}
checkpoint_every = {checkpoints}
vtk_every = {frames}
pictures = false
"#,
        half = steps / 2
    )
}

/// A folder with a scene, and the results of the run that nobody disturbs.
pub struct Specimen {
    pub folder: Folder,
    whole: BTreeMap<String, Vec<u8>>,
    hash: String,
    /// How long the undisturbed run took.
    pub time: Duration,
}

impl Specimen {
    pub fn new(name: &str, scene: &str) -> Specimen {
        let folder = Folder::new(&format!("torture-{name}"));
        folder.write("scene.toml", scene);
        let start = Instant::now();
        folder.done(&["run", "scene.toml", "--out", "whole", "--threads", "1"]);
        let time = start.elapsed();
        let hash = folder.json("whole/summary.json")["state_hash"].as_str().unwrap().to_owned();
        let mut specimen = Specimen { folder, whole: BTreeMap::new(), hash, time };
        specimen.whole = specimen.files("whole");
        specimen
    }

    /// A run into `out`, from its checkpoint where there is one.
    pub fn command(&self, out: &str) -> Command {
        let place = self.folder.0.join(out);
        let checkpoint = place.join("checkpoint.dempfv");
        let (place, from) = (place.to_str().unwrap(), checkpoint.to_str().unwrap());
        let mut command = self.folder.command(&["run", "scene.toml", "--out", place]);
        command.args(["--threads", "1", "--force"]).env("OPENBLAS_NUM_THREADS", "1");
        if checkpoint.exists() {
            command.args(["--restart", from]);
        }
        command
    }

    /// What is in a folder of results, without what differs from run to run: the times in the
    /// summary, and the checkpoint.
    fn files(&self, out: &str) -> BTreeMap<String, Vec<u8>> {
        let differs = ["summary.json", "checkpoint.dempfv"];
        std::fs::read_dir(self.folder.0.join(out))
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|entry| (entry.file_name().into_string().unwrap(), entry.path()))
            .filter(|(name, _)| !differs.contains(&name.as_str()))
            .map(|(name, path)| (name, std::fs::read(path).unwrap()))
            .collect()
    }

    /// Goes on with `out` until it is done; then every file is there, none beside them, and each
    /// has the bytes of the undisturbed run's.
    pub fn goes_on_as_if_nothing_had_been(&self, out: &str, context: &str) {
        let output = self.command(out).output().unwrap();
        assert!(output.status.success(), "{context}: {}", error(&output));
        self.is_whole(out, context);
    }

    /// A finished run: state, names and bytes of the files are those of the undisturbed one.
    pub fn is_whole(&self, out: &str, context: &str) {
        let summary = self.folder.json(&format!("{out}/summary.json"));
        assert_eq!(summary["state_hash"], self.hash, "{context}");
        let files = self.files(out);
        let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&files), names(&self.whole), "{context}");
        for (name, bytes) in &files {
            let (ours, theirs) = (lines(bytes), lines(&self.whole[name]));
            let other = ours.iter().zip(&theirs).find(|(a, b)| a != b);
            assert!(bytes == &self.whole[name], "{context}: {name}: {other:?}");
        }
    }

    /// What an unfinished run has left: whole rows that the undisturbed run has too, and frames
    /// that its collections name are there and whole.
    pub fn is_sound(&self, out: &str, context: &str) {
        let place = self.folder.0.join(out);
        if !place.exists() {
            return;
        }
        for (name, bytes) in self.files(out) {
            if name.starts_with('.') {
                continue;
            }
            let whole = &self.whole[&name];
            let is_prefix = whole.starts_with(&bytes) && bytes.ends_with(b"\n");
            let grows = name.ends_with(".csv") && is_prefix;
            let earlier = name.ends_with(".pvd");
            assert!(grows || earlier || &bytes == whole, "{context}: {name} is not whole");
            for frame in frames(&String::from_utf8_lossy(&bytes)) {
                assert!(place.join(&frame).exists(), "{context}: {name} names {frame}");
            }
        }
    }
}

/// The frames that a collection names.
fn frames(text: &str) -> Vec<String> {
    let named = text.lines().filter_map(|line| line.split_once("file=\"")?.1.split_once('"'));
    named.map(|(name, _)| name.to_owned()).collect()
}

fn lines(bytes: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect()
}

/// Waits for the end of a program, which must come within a minute.
pub fn output_of(command: &mut Command, context: &str) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    assert!(ends(&mut child, Duration::from_secs(60)), "{context}: hangs");
    child.wait_with_output().unwrap()
}

/// Waits so long for a program; one that goes on is killed.
pub fn ends(child: &mut Child, patience: Duration) -> bool {
    let start = Instant::now();
    while start.elapsed() < patience {
        if child.try_wait().unwrap().is_some() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    false
}
