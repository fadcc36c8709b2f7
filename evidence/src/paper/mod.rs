//! `dempfv paper`: the figures of Caulk, Catalano and Chareyre (2020), measured on this
//! machine, and the claims of their summary beside ours.

mod built;
mod claims;
mod draw;
mod factored;
mod figures;
mod gpu;
mod jobs;
mod machine;
mod measured;
mod page;
mod raw;
mod remesh;
mod specimens;
mod timing;

use std::fmt;
use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv_report::output::{OutputArgs, make_folder};
use serde::Serialize;

use self::figures::Figure;
use self::jobs::Jobs;
use self::machine::Machine;
use self::measured::Measured;
use crate::Error;
use crate::bench::Bench;

/// The page.
const PAGE: &str = "paper.md";

/// What `paper` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Measure only what these figures need; the page also shows what is known of others
    #[arg(long = "figure", value_name = "N", value_enum, value_delimiter = ',')]
    figures: Vec<Figure>,
    /// Measure only the specimens of so many spheres
    #[arg(long, value_name = "SPHERES", value_delimiter = ',')]
    sizes: Vec<u32>,
    /// Measure this machine's first GPU instead, beside its cores, for the GPU rows
    #[arg(long)]
    gpu: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// What was written.
#[derive(Serialize)]
pub struct Report {
    page: PathBuf,
    machine: String,
    left_out: Vec<String>,
}

/// Measures what is not known yet, and writes the page. Points that an earlier call into the
/// same folder has measured stay as they are, unless `--force` is given.
///
/// # Errors
/// What is wrong in the options; or which point failed. All points before it are kept.
pub fn run(args: &Args, threads: usize) -> Result<Report, Error> {
    let specimens = specimens::chosen(&args.sizes)?;
    let figures = if args.figures.is_empty() { &Figure::ALL[..] } else { &args.figures };
    let machine = Machine::here(threads);
    let mut jobs = match args.gpu {
        true => Jobs::with_gpu(&specimens, &machine)?,
        false => Jobs::new(figures, &specimens, &machine)?,
    };
    let folder = folder(&args.output)?;
    make_folder(&folder)?;
    let bench: Bench = Bench::lasting(folder, (), &machine.to_string())?;
    if args.output.force {
        jobs.forget(&bench)?;
    }
    jobs.carry_out(&bench, threads)?;
    let measured = Measured::collect(&bench, threads)?;
    let page = page::write(&bench.folder, PAGE, &measured, &machine, &jobs.left_out)?;
    Ok(Report { page, machine: machine.to_string(), left_out: jobs.left_out })
}

/// Where everything goes, by absolute path: scenes lie in it and name packings in it.
fn folder(output: &OutputArgs) -> Result<PathBuf, InputError> {
    let folder = output.place(Path::new("paper"));
    std::path::absolute(&folder).ok().filter(|f| !f.exists() || f.is_dir()).ok_or_else(|| {
        InputError::new(format!("--out {} is no folder", folder.display()), "name a folder")
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  measured on    {}", self.machine)?;
        for what in &self.left_out {
            writeln!(f, "  left out       {what}")?;
        }
        writeln!(f, "  written        {}", self.page.display())
    }
}
