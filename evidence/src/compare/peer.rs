//! Starts YADE on a script of ours, and takes its result.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use dempfv_report::json;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::bench::{self, ending};

/// What every script begins with.
const COMMON: &str = include_str!("scripts/common.py");

/// A workplace with YADE.
pub type Bench = bench::Bench<Yade>;

/// YADE on this machine.
pub struct Yade {
    program: PathBuf,
    /// Its version, as it says itself: `2023.02a` on Debian 12.
    pub version: String,
}

/// What a script hands back.
#[derive(Debug, Serialize, Deserialize)]
pub struct Answer<T> {
    /// What it was asked for.
    pub result: T,
    /// The most memory that the process held (bytes).
    pub peak_memory_bytes: u64,
}

impl Yade {
    /// Asks the program for its version.
    ///
    /// # Errors
    /// [`Error::Peer`] when it is not there or is something else.
    pub fn find(program: &Path) -> Result<Yade, Error> {
        let fails = |what: String| Error::Peer { step: "yade --version".into(), what, log: None };
        let output =
            Command::new(program).arg("--version").stdin(Stdio::null()).output().map_err(|e| {
                let program = program.display();
                fails(format!("{program} does not start: {e}; install Debian's package `yade`"))
            })?;
        let text = String::from_utf8_lossy(&output.stdout);
        let version = text.lines().find_map(|line| line.strip_prefix("Yade version:"));
        match version.map(str::trim).filter(|v| output.status.success() && !v.is_empty()) {
            Some(version) => Ok(Yade { program: program.to_owned(), version: version.to_owned() }),
            None => {
                let (program, said) = (program.display(), text.lines().next().unwrap_or("nothing"));
                let end = ending(output.status);
                Err(fails(format!(
                    "{program} says `{said}` and {end}, where YADE names its version; \
                     name YADE with --yade"
                )))
            }
        }
    }
}

impl Bench {
    /// Runs a script in YADE. It finds its job as the dictionary `job`, and ends with
    /// `finish(result)`.
    ///
    /// # Errors
    /// [`Error::Peer`] when YADE does not start, crashes, or its result is none; its log
    /// is kept.
    pub fn yade<T: DeserializeOwned>(
        &self,
        step: &str,
        script: &str,
        threads: usize,
        job: &impl Serialize,
    ) -> Result<Answer<T>, Error> {
        let script = format!("{COMMON}\n{script}");
        let mut command = Command::new(&self.peer.program);
        command.arg(format!("-j{threads}")).args(["-n", "-x"]);
        self.script(step, "YADE", command, &script, threads, job)
    }
}

impl<P> bench::Bench<P> {
    /// Runs a script in Debian's Python, which has what YADE depends on; in the same way.
    ///
    /// # Errors
    /// As [`yade`](Bench::yade).
    pub fn python<T: DeserializeOwned>(
        &self,
        step: &str,
        script: &str,
        job: &impl Serialize,
    ) -> Result<Answer<T>, Error> {
        let script = format!("{COMMON}\n{script}");
        self.script(step, "Python", Command::new("/usr/bin/python3"), &script, 1, job)
    }

    /// Runs a script by an interpreter, which finds its job and the place of its result in
    /// the environment.
    ///
    /// # Errors
    /// As [`yade`](Bench::yade).
    pub fn script<T: DeserializeOwned>(
        &self,
        step: &str,
        program: &str,
        mut command: Command,
        script: &str,
        threads: usize,
        job: &impl Serialize,
    ) -> Result<Answer<T>, Error> {
        let jobs = self.folder.join("jobs");
        let result = jobs.join(format!("{step}.result.json"));
        let input = jobs.join(format!("{step}.json"));
        let path = self.write(&format!("jobs/{step}.py"), script)?;
        json::write(&input, job)?;
        command.arg(&path).env("DEMPFV_JOB", &input).env("DEMPFV_RESULT", &result);
        for name in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(name, threads.to_string());
        }
        self.run_for(step, program, &mut command, &result)
    }

    /// Runs a command that leaves its result in a file, as JSON.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails or leaves no such file; its log is kept.
    pub fn run_for<T: DeserializeOwned>(
        &self,
        step: &str,
        program: &str,
        command: &mut Command,
        result: &Path,
    ) -> Result<T, Error> {
        // The result of an earlier call must not pass for that of this one.
        let _ = std::fs::remove_file(result);
        let log = self.run_logged(step, program, command)?;
        let wrong = |what: String| Error::Peer {
            step: step.to_owned(),
            what: format!("{program} {what}"),
            log: Some(log.clone()),
        };
        let text =
            std::fs::read(result).map_err(|e| wrong(format!("ended without a result ({e})")))?;
        serde_json::from_slice(&text)
            .map_err(|e| wrong(format!("left something unexpected in {}: {e}", result.display())))
    }
}
