//! `dempfv compare peers`: the contest with what people would pick instead: YADE and LAMMPS
//! for the simulation; CHOLMOD with METIS, MKL's PARDISO and faer for the linear algebra.

mod contacts;
mod coupled;
mod draw;
mod dry;
mod forces;
pub mod job;
mod lammps;
mod lammps_law;
mod linear;
mod model;
mod network;
mod others;
mod page;
mod rows;
mod sizes;

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dempfv::InputError;
use dempfv::io::atomic;
use dempfv::solver::SolverKind;
use dempfv_report::machine;
use dempfv_report::output::{OutputArgs, make_folder};
use dempfv_report::table;
use serde::{Deserialize, Serialize};

use self::job::Job;
use self::others::{Lammps, Name, Others};
use self::rows::Row;
use self::sizes::Sizes;
use super::peer::{Bench, Yade};
use crate::Error;
use crate::limits::Limits;

/// The report, and the folder of its figures beside it.
const PAGE: &str = "report.md";
const FIGURES: &str = "report";
/// The report of contacts alone.
const CONTACTS: &str = "contacts.md";
/// How long the machine is looked at before the first run.
const LOOK: Duration = Duration::from_secs(2);
/// Threads of every program.
const THREADS: usize = 2;
/// Runs of every program, by turns.
const RUNS: usize = 3;

/// What the contest takes.
#[derive(clap::Args)]
pub struct Args {
    /// Small packings and one run each: whether everything works
    #[arg(long)]
    quick: bool,
    /// Programs to leave out
    #[arg(long, value_name = "PROGRAM", value_enum, num_args = 1..)]
    without: Vec<Name>,
    /// Only the effects of contacts beside LAMMPS
    #[arg(long)]
    contacts: bool,
    /// Our solver that is compared [default: frontal where there is one]
    #[arg(long, value_name = "NAME")]
    solver: Option<String>,
    /// YADE
    #[arg(long, value_name = "PROGRAM", default_value = "yade")]
    yade: PathBuf,
    /// LAMMPS
    #[arg(long, value_name = "PROGRAM", default_value = "lmp")]
    lammps: PathBuf,
    /// A Python that has `pypardiso`
    #[arg(long, value_name = "PROGRAM", default_value = "out/compare-peers/venv/bin/python")]
    python: PathBuf,
    /// The program that `evidence/peers/faer` is built to
    #[arg(long, value_name = "PROGRAM", default_value = "target/peers/release/faer-peer")]
    faer: PathBuf,
    #[command(flatten)]
    output: OutputArgs,
}

/// What everything is measured with.
pub struct Contest<'a> {
    bench: &'a Bench,
    others: Others,
    /// Our solver's name.
    ours: &'a str,
    threads: usize,
    runs: usize,
    quick: bool,
}

impl Contest<'_> {
    /// So many steps, or fewer where all is to be quick.
    fn scaled(&self, steps: u64) -> u64 {
        if self.quick { steps / 10 } else { steps }
    }
}

/// What was measured.
#[derive(Serialize)]
struct Results {
    start: Start,
    /// At the beginning and at the end.
    limits: [Limits; 2],
    dry: Vec<dry::Case>,
    contacts: Vec<contacts::Case>,
    coupled: Vec<coupled::Case>,
    network: Vec<network::Case>,
    inside: Vec<coupled::Inside>,
    linear: Vec<linear::Case>,
}

/// The machine before the first run.
#[derive(Serialize, Deserialize)]
struct Start {
    day: String,
    load: String,
    busy_cores: Option<f64>,
}

/// How the contest came out.
#[derive(Serialize)]
pub struct Report {
    rows: Vec<[String; 8]>,
    reached: usize,
    page: PathBuf,
}

/// Runs everything and writes the report.
///
/// # Errors
/// What is wrong in the options; a program that is not there, or that fails.
pub fn run(args: &Args) -> Result<Report, Error> {
    let ours = solver(args.solver.as_deref())?;
    let name = if args.quick { "compare-peers-quick" } else { "compare-peers" };
    let folder = args.output.place(Path::new(name));
    let yade = Yade::find(&args.yade)?;
    let others = others(args)?;
    make_folder(&folder)?;
    let lammps = others.lammps.as_ref().map_or("none", |l| &l.version);
    let processor = machine::processor().unwrap_or_default();
    let versions = format!("YADE {}, LAMMPS {lammps}, on {processor}", yade.version);
    let bench = Bench::new(folder, yade, &versions)?;
    if args.output.force {
        bench.forget("")?;
    }
    let runs = if args.quick { 1 } else { RUNS };
    let contest =
        Contest { bench: &bench, others, ours, threads: THREADS, runs, quick: args.quick };
    let sizes = if args.quick { sizes::QUICK } else { sizes::FULL };
    if args.contacts {
        return only_contacts(&contest, &sizes);
    }
    let results = measure(&contest, &sizes)?;
    let rows = rows::rows(&contest, &results);
    let path = bench.folder.join(PAGE);
    let figures = bench.folder.join(FIGURES);
    std::fs::create_dir_all(&figures).map_err(|e| dempfv::Error::io(&figures, e))?;
    let drawn = draw::all(&results, &figures)?;
    page::write(&contest, &results, &rows, &drawn, &path)?;
    let reached = rows.iter().filter(|row| row.is_reached()).count();
    Ok(Report { rows: rows.iter().map(Row::cells).collect(), reached, page: path })
}

/// The part beside LAMMPS alone, on a page of its own.
fn only_contacts(contest: &Contest, sizes: &Sizes) -> Result<Report, Error> {
    let mut cases = vec![];
    for size in sizes.dry {
        cases.extend(contacts::measure(contest, &size.place(contest.bench)?)?);
    }
    let rows: Vec<Row> = cases.iter().map(rows::contacts).collect();
    let page = contest.bench.folder.join(CONTACTS);
    atomic::write(&page, page::contacts(contest, &cases).as_bytes())?;
    let reached = rows.iter().filter(|row| row.is_reached()).count();
    Ok(Report { rows: rows.iter().map(Row::cells).collect(), reached, page })
}

fn measure(contest: &Contest, sizes: &Sizes) -> Result<Results, Error> {
    let bench = contest.bench;
    let limits = |name: &str| {
        bench.remembered(name, &(), || bench.job(name, &Job::Limits {}, contest.threads))
    };
    let start = bench.remembered("start", &(), || Ok(Start::now()))?;
    let first = limits("limits-start")?;
    let place = |size: &sizes::Size| size.place(bench);
    let (mut dry, mut contacts, mut coupled, mut network) = (vec![], vec![], vec![], vec![]);
    let (mut inside, mut linear) = (vec![], vec![]);
    for size in sizes.dry {
        dry.push(dry::measure(contest, &place(size)?)?);
        contacts.extend(contacts::measure(contest, &place(size)?)?);
    }
    for size in sizes.network {
        network.push(network::measure(contest, &place(size)?)?);
    }
    for size in sizes.linear {
        linear.push(linear::measure(contest, &place(size)?)?);
    }
    for size in sizes.inside {
        inside.push(coupled::inside(contest, &place(size)?)?);
    }
    for size in sizes.coupled {
        let before = coupled.last().map(|case: &coupled::Case| case.tuning);
        coupled.push(coupled::measure(contest, &place(size)?, before)?);
    }
    let limits = [first, limits("limits-end")?];
    Ok(Results { start, limits, dry, contacts, coupled, network, inside, linear })
}

impl Start {
    fn now() -> Start {
        let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
        let load: Vec<&str> = load.split_whitespace().take(3).collect();
        let busy_cores = machine::busy_cores(LOOK);
        Start { day: machine::today(), load: load.join(", "), busy_cores }
    }
}

/// Our solver by its name.
fn solver(name: Option<&str>) -> Result<&'static str, Error> {
    const OWN: &str = "frontal";
    let Some(name) = name else {
        let own = OWN.parse::<SolverKind>().unwrap_or_default();
        return Ok(own.name());
    };
    let kind: SolverKind = name.parse().map_err(|e| {
        dempfv::Error::from(InputError::new(format!("--solver: {e}"), "name one of them"))
    })?;
    Ok(kind.name())
}

/// The programs that are not left out. All that is missing is told at once.
fn others(args: &Args) -> Result<Others, Error> {
    let left_out = |name| args.without.contains(&name);
    if args.contacts && left_out(Name::Lammps) {
        let what = "--contacts compares with LAMMPS, which --without leaves out";
        return Err(InputError::new(what, "give one of the two").into());
    }
    let wanted = |name| !left_out(name) && (!args.contacts || name == Name::Lammps);
    let lammps = wanted(Name::Lammps).then(|| Lammps::find(&args.lammps)).transpose();
    let pardiso = "`make compare` installs pypardiso there; or leave it out with --without pardiso";
    let pardiso = wanted(Name::Pardiso)
        .then(|| others::existing("PARDISO", &args.python, pardiso))
        .transpose();
    let faer = "`make compare` builds it; or leave it out with --without faer";
    let faer = wanted(Name::Faer).then(|| others::existing("faer", &args.faer, faer)).transpose();
    let missing: Vec<String> = [lammps.as_ref().err(), pardiso.as_ref().err(), faer.as_ref().err()]
        .into_iter()
        .flatten()
        .map(ToString::to_string)
        .collect();
    match missing.len() {
        0 | 1 => Ok(Others { lammps: lammps?, pardiso: pardiso?, faer: faer? }),
        _ => Err(Error::Peer { step: "peers".to_owned(), what: missing.join("; "), log: None }),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let header = ["#", "what", "on", "measured", "must", "aim", ""];
        let plain = |cells: &[String; 8]| {
            cells.iter().take(header.len()).map(|c| c.replace("**", "").replace('`', "")).collect()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(plain).collect();
        write!(f, "{}", table(&header, &rows))?;
        writeln!(f, "\n  reached        {} of {}", self.reached, self.rows.len())?;
        writeln!(f, "  written        {}", self.page.display())
    }
}
