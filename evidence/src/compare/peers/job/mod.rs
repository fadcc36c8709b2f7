//! What is measured in a process of its own: `dempfv compare job JOB RESULT`, which only
//! the comparison calls.

mod dry;
mod linear;
mod network;
mod steps;
mod system;

use std::path::{Path, PathBuf};
use std::process::Command;

use dempfv::InputError;
use dempfv_report::json;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use self::dry::{Contacts, Dry, Material, Stepped, Turning};
pub use self::linear::{Linear, Solved};
pub use self::network::{Build, Built};
pub use self::steps::{Run, Steps};
pub use self::system::{Errors, Made, System, Systemize};
use crate::Error;
use crate::bench::Bench;
use crate::limits::Limits;

/// What is to be done.
#[derive(Serialize, Deserialize)]
#[serde(tag = "job", rename_all = "snake_case")]
pub enum Job {
    /// What the machine can do.
    Limits {},
    /// Steps without fluid.
    Dry(Dry),
    /// Networks from positions.
    Build(Build),
    /// The file of a system.
    Systemize(Systemize),
    /// A factorization and solves.
    Linear(Linear),
    /// Steps of a scene, with its pressures checked.
    Run(Run),
}

/// What the subcommand takes.
#[derive(clap::Args)]
pub struct Args {
    job: PathBuf,
    result: PathBuf,
}

/// Does what the file says.
///
/// # Errors
/// The file is none of a job, or what the work returns.
pub fn run(args: &Args) -> Result<(), Error> {
    let text = std::fs::read(&args.job).map_err(|e| dempfv::Error::io(&args.job, e))?;
    let job: Job = serde_json::from_slice(&text).map_err(|e| {
        InputError::new(format!("{e}"), "this subcommand is for `compare peers`").in_file(&args.job)
    })?;
    let to = args.result.as_path();
    match job {
        Job::Limits {} => give(to, &Limits::measure()),
        Job::Dry(job) => give(to, &job.measure()?),
        Job::Build(job) => give(to, &job.measure()?),
        Job::Systemize(job) => give(to, &job.write()?),
        Job::Linear(job) => give(to, &job.measure()?),
        Job::Run(job) => give(to, &job.measure()?),
    }
}

fn give(path: &Path, result: &impl Serialize) -> Result<(), Error> {
    Ok(json::write(path, result)?)
}

impl<P> Bench<P> {
    /// Does a job in a process of its own.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails; its log is kept.
    pub fn job<T: DeserializeOwned>(
        &self,
        step: &str,
        job: &Job,
        threads: usize,
    ) -> Result<T, Error> {
        let mut command = Command::new(self.program(step)?);
        command.args(["--threads", &threads.to_string(), "compare", "job"]);
        self.ask(step, "dempfv", command, job)
    }

    /// Runs a program that reads a job from its next argument, a file, and writes its result
    /// into that after it.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails; its log is kept.
    pub fn ask<T: DeserializeOwned>(
        &self,
        step: &str,
        program: &str,
        mut command: Command,
        job: &impl Serialize,
    ) -> Result<T, Error> {
        let input = self.folder.join("jobs").join(format!("{step}.json"));
        let result = self.folder.join("jobs").join(format!("{step}.result.json"));
        json::write(&input, job)?;
        command.args([&input, &result]);
        self.run_for(step, program, &mut command, &result)
    }
}

/// The errors of jobs: the process that asked shows the log.
fn solver_failed(solver: &str, error: &dempfv::solver::SolverError) -> Error {
    Error::Peer { step: solver.to_owned(), what: error.to_string(), log: None }
}
