//! The subcommands, and what they share.
//!
//! A subcommand is one file with `Args` (what the user may say), `run` (what it does) and
//! a report that is both [`Display`](std::fmt::Display) (for people, on stdout) and
//! [`Serialize`](serde::Serialize) (for programs, `--json`). It becomes one variant of
//! [`Command`] and one line of [`execute`].

pub mod check;
mod context;
mod describe;
pub mod doctor;
mod format;
pub mod output;
pub mod solve;

use clap::{Parser, Subcommand};
pub use context::{Context, Options};
use dempfv::Error;

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
    /// Solve a Matrix Market system with each solver: times, fill, residual
    Solve(solve::Args),
    /// Show library versions, cores, memory and GPU, and what to install
    Doctor(doctor::Args),
}

/// Does what the command says and hands out its report.
///
/// # Errors
/// What the subcommand returns; nothing has been printed then.
pub fn execute(command: Command, context: &Context) -> Result<(), Error> {
    match command {
        Command::Check(args) => context.deliver(&check::run(&args)?),
        Command::Solve(args) => context.deliver(&solve::run(&args)?),
        Command::Doctor(args) => context.deliver(&doctor::run(&args)?),
    }
}
