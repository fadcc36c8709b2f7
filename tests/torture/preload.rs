//! The program with calls that fail: `fail.c` is compiled and preloaded.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What `fail.c` has written down.
pub struct Log(PathBuf);

impl Log {
    pub fn new(path: PathBuf) -> Log {
        Log(path)
    }

    fn lines(&self) -> Vec<(String, u64, u64)> {
        let text = std::fs::read_to_string(&self.0).unwrap_or_default();
        let line = |line: &str| {
            let mut words = line.split_whitespace();
            let name = words.next()?.to_owned();
            Some((name, words.next()?.parse().ok()?, words.next()?.parse().ok()?))
        };
        text.lines().filter_map(line).collect()
    }

    /// A count at the end of a run that ended by itself.
    pub fn total(&self, name: &str) -> Option<u64> {
        self.lines().iter().find(|(n, ..)| n == name).map(|&(_, n, _)| n)
    }

    /// The first call that failed, and its bytes.
    pub fn failure(&self) -> Option<(String, u64)> {
        let totals = ["calls", "allocations"];
        let mut lines = self.lines().into_iter();
        lines.find(|(name, ..)| !totals.contains(&name.as_str())).map(|(name, _, b)| (name, b))
    }
}

/// Prepares a command to fail as `settings` say; what happens is in the log.
pub fn preload(command: &mut Command, folder: &Path, settings: &[(&str, String)]) -> Log {
    let log = folder.join("fail.log");
    let _ = std::fs::remove_file(&log);
    command.env("LD_PRELOAD", library()).env("FAIL_LOG", &log);
    command.envs(settings.iter().map(|(name, value)| (name, value)));
    Log::new(log)
}

/// `fail.c`, compiled once.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/torture/fail.c");
        let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join("torture-fail.so");
        let mut cc = Command::new("cc");
        cc.args(["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"]).arg(&library).arg(source);
        let output = cc.output().expect("a C compiler named cc is needed");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        library
    })
}
