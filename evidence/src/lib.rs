//! Everything that measures `dempfv` or compares it, as subcommands of the program: see
//! [`Command`]. Whoever calls [`run`] hands out the [`Report`] and then asks it for its
//! [judgement](Report::judge).
//!
//! Measurements run in processes of their own, in which the calling program is started
//! again: it offers these subcommands under the names that they have here,
//! beside its own.
#![warn(missing_docs)]

mod accuracy;
mod accuracy_yade;
mod bench;
mod compare;
mod effect_costs;
mod error;
mod every_step;
pub mod limits;
mod paper;
mod volume;

use std::fmt;

pub use error::{Error, Result};
use serde::Serialize;

/// What to measure.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Compare with another program on the same input, side by side in one run
    Compare(compare::Args),
    /// The figures of Caulk et al. (2020), measured on this machine
    Paper(paper::Args),
    /// What it costs and gains when the network follows the spheres at every step
    EveryStep(every_step::Args),
    /// What each effect adds to the time of a step
    EffectCosts(effect_costs::Args),
    /// What accuracy costs in time: a scene's settings against a reference
    Accuracy(accuracy::Args),
    /// The same beside YADE: remesh intervals of one loading in both programs
    AccuracyYade(accuracy_yade::Args),
    /// How far one packing stands for all that are made in the same way, over its size
    RepresentativeVolume(volume::Args),
}

/// How a measurement came out: for people by [`Display`](fmt::Display), for programs by
/// [`Serialize`].
#[derive(Serialize)]
#[serde(transparent)]
pub struct Report(Kind);

#[derive(Serialize)]
#[serde(untagged)]
enum Kind {
    Compare(compare::Report),
    Paper(paper::Report),
    EveryStep(every_step::Report),
    EffectCosts(effect_costs::Report),
    Accuracy(accuracy::Report),
    AccuracyYade(accuracy_yade::Report),
    RepresentativeVolume(volume::Report),
}

/// Measures what is asked for, with so many threads where the measurement does not choose
/// them itself.
///
/// # Errors
/// What is wrong in the options; or which measurement failed, and where its log is.
pub fn run(command: &Command, threads: usize) -> Result<Report> {
    Ok(Report(match command {
        Command::Compare(args) => Kind::Compare(compare::run(args)?),
        Command::Paper(args) => Kind::Paper(paper::run(args, threads)?),
        Command::EveryStep(args) => Kind::EveryStep(every_step::run(args)?),
        Command::EffectCosts(args) => Kind::EffectCosts(effect_costs::run(args)?),
        Command::Accuracy(args) => Kind::Accuracy(accuracy::run(args)?),
        Command::AccuracyYade(args) => Kind::AccuracyYade(accuracy_yade::run(args, threads)?),
        Command::RepresentativeVolume(args) => Kind::RepresentativeVolume(volume::run(args)?),
    }))
}

impl Report {
    /// What the program ends with after the report.
    ///
    /// # Errors
    /// [`Error::Differs`] when something lies outside its bounds and nothing explains why.
    pub fn judge(&self) -> Result<()> {
        match &self.0 {
            Kind::Compare(report) => report.judge(),
            Kind::AccuracyYade(report) => report.judge(),
            Kind::Paper(_)
            | Kind::EveryStep(_)
            | Kind::EffectCosts(_)
            | Kind::Accuracy(_)
            | Kind::RepresentativeVolume(_) => Ok(()),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kind::Compare(report) => report.fmt(f),
            Kind::Paper(report) => report.fmt(f),
            Kind::EveryStep(report) => report.fmt(f),
            Kind::EffectCosts(report) => report.fmt(f),
            Kind::Accuracy(report) => report.fmt(f),
            Kind::AccuracyYade(report) => report.fmt(f),
            Kind::RepresentativeVolume(report) => report.fmt(f),
        }
    }
}
