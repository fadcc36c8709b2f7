//! Hands over to the crate that measures this program and compares it with others, which
//! is the feature `evidence`.

#[cfg(feature = "evidence")]
pub use dempfv_evidence::{Command, Error};
#[cfg(not(feature = "evidence"))]
pub use without::{Command, Error, run};

#[cfg(feature = "evidence")]
use crate::commands::{self, Context};

/// Measures, and hands out the report.
///
/// # Errors
/// What the measurement returns; or, after the report, that something lies outside its
/// bounds.
#[cfg(feature = "evidence")]
pub fn run(command: &Command, context: &Context) -> Result<(), commands::Error> {
    let report = dempfv_evidence::run(command, context.threads)?;
    context.deliver(&report)?;
    Ok(report.judge()?)
}

/// A program without the crate: it knows what the subcommands are, and says where they are.
#[cfg(not(feature = "evidence"))]
mod without {
    use std::ffi::OsString;

    use crate::commands::{self, Context};

    /// The subcommands of the crate, with anything behind them.
    #[derive(clap::Subcommand)]
    pub enum Command {
        #[command(hide = true)]
        Compare(Anything),
        #[command(hide = true)]
        Paper(Anything),
        #[command(hide = true)]
        EveryStep(Anything),
        #[command(hide = true)]
        EffectCosts(Anything),
        #[command(hide = true)]
        Accuracy(Anything),
        #[command(hide = true)]
        AccuracyYade(Anything),
        #[command(hide = true)]
        RepresentativeVolume(Anything),
    }

    #[derive(clap::Args)]
    #[command(disable_help_flag = true)]
    pub struct Anything {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        _words: Vec<OsString>,
    }

    /// The program was built without what it is asked for.
    #[derive(Debug, thiserror::Error)]
    #[error(
        "`{0}` is not in this program, which was built without the feature `evidence`; build it \
         with `cargo build --release`, without `--no-default-features`"
    )]
    pub struct Error(&'static str);

    impl Error {
        /// The user has asked for it.
        pub fn is_input(&self) -> bool {
            true
        }
    }

    /// # Errors
    /// Always.
    pub fn run(command: &Command, _: &Context) -> Result<(), commands::Error> {
        let name = match command {
            Command::Compare(_) => "compare",
            Command::Paper(_) => "paper",
            Command::EveryStep(_) => "every-step",
            Command::EffectCosts(_) => "effect-costs",
            Command::Accuracy(_) => "accuracy",
            Command::AccuracyYade(_) => "accuracy-yade",
            Command::RepresentativeVolume(_) => "representative-volume",
        };
        Err(Error(name).into())
    }
}
