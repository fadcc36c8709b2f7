//! The subcommands, and what they share.
//!
//! A subcommand is one file with `Args` (what the user may say), `run` (what it does) and
//! a report that is both [`Display`](std::fmt::Display) (for people, on stdout) and
//! [`Serialize`](serde::Serialize) (for programs, `--json`). It becomes one variant of
//! [`Command`] and one line of [`execute`].

mod accuracy;
pub mod check;
mod context;
mod describe;
pub mod doctor;
mod error;
mod kernels;
mod memory;
pub mod network;
pub mod pack;
pub mod permeability;
pub mod run;
pub mod solve;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
pub use context::{Context, Options};
pub use error::Error;

use crate::evidence;

/// Simulates saturated granular matter: spheres in contact (DEM), coupled to the flow
/// through the pores between them (PFV).
#[derive(Parser)]
#[command(name = "dempfv", version, propagate_version = true)]
pub struct Cli {
    /// What holds for every subcommand.
    #[command(flatten)]
    pub options: Options,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Subcommand)]
pub enum Command {
    /// Validate a scene and print its plan: effects, sizes, time step, cost
    Check(check::Args),
    /// Carry out a scene: history, pictures, summary
    Run(run::Args),
    /// Make a settled packing from a scene or from options
    Pack(pack::Args),
    /// Triangulate a packing and solve one static flow; the network as JSON with --json
    Network(network::Args),
    /// Permeability of a packing along each axis, with Kozeny-Carman beside it
    Permeability(permeability::Args),
    /// Solve a Matrix Market system with each solver: times, fill, residual
    Solve(solve::Args),
    /// Show library versions, cores, memory and GPU, and what to install
    Doctor(doctor::Args),
    /// Measurements of this program.
    #[command(flatten)]
    Evidence(evidence::Command),
}

/// Exit status of a run that Ctrl-C ended: 128 + SIGINT, as shells report it.
const INTERRUPTED: u8 = 130;

/// Does what the command says and hands out its report.
///
/// # Errors
/// What the subcommand returns; nothing has been printed then.
pub fn execute(command: Command, context: &Context) -> Result<ExitCode, Error> {
    let mut status = ExitCode::SUCCESS;
    match command {
        Command::Check(args) => context.deliver(&check::run(&args)?)?,
        Command::Run(args) => {
            let report = run::run(&args, context)?;
            if report.interrupted {
                status = ExitCode::from(INTERRUPTED);
            }
            context.deliver(&report)?;
        }
        Command::Pack(args) => match pack::run(&args, context)? {
            Some(report) => context.deliver(&report)?,
            None => status = ExitCode::from(INTERRUPTED),
        },
        Command::Network(args) => context.deliver(&network::run(&args, context)?)?,
        Command::Permeability(args) => context.deliver(&permeability::run(&args)?)?,
        Command::Solve(args) => context.deliver(&solve::run(&args)?)?,
        Command::Doctor(args) => context.deliver(&doctor::run(&args)?)?,
        Command::Evidence(command) => evidence::run(&command, context)?,
    }
    Ok(status)
}
