//! `dempfv compare`: other programs on the same input, side by side in one run.

mod conditions;
mod coupled;
mod dry;
mod edges;
mod figures;
mod filling;
mod injection;
pub(crate) mod loading;
mod network;
mod page;
pub(crate) mod peer;
mod peers;
mod periodic;
mod reference;
mod time;
mod verdict;

use std::fmt;
use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv_report::output::{OutputArgs, make_folder};
use dempfv_report::table;
use serde::Serialize;
use serde::de::DeserializeOwned;

use self::peer::Bench;
use self::verdict::Verdict;
use crate::Error;

/// File that marks a result.
const PAGE: &str = "yade.md";
/// The packings that are compared when none is named, as they lie in a checkout.
const PACKINGS: [&str; 3] = [SHIPPED[0], SHIPPED[1], SHIPPED[2]];
/// Those whose networks are compared then: also one of very different spheres, and one that
/// is nearly a lattice.
const SHIPPED: [&str; 5] = [
    "packings/oedometer-1000.txt",
    "packings/oedometer-5000.txt",
    "packings/oedometer-20000.txt",
    "packings/polydisperse-2000.txt",
    "packings/lattice-1000.txt",
];

/// What `compare` takes.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    with: Peer,
}

/// The programs that there is a comparison with.
#[derive(clap::Subcommand)]
enum Peer {
    /// Pore networks, mechanics, coupled runs and times beside Debian's YADE
    Yade(YadeArgs),
    /// Speed beside YADE, LAMMPS, CHOLMOD with METIS, PARDISO and faer
    Peers(peers::Args),
    /// One measurement, in a process of its own; for `compare peers`
    #[command(hide = true)]
    Job(peers::job::Args),
}

/// What the comparison with YADE takes.
#[derive(clap::Args)]
struct YadeArgs {
    /// Packing files; those that the project ships if none is given
    packings: Vec<PathBuf>,
    /// Measure only these parts; the report also shows the others where they are known
    #[arg(long = "part", value_name = "PART", value_enum)]
    parts: Vec<PartName>,
    /// The program to compare with
    #[arg(long, value_name = "PROGRAM", default_value = "yade")]
    yade: PathBuf,
    /// Instead of the report, write what YADE finds into this folder, as reference for
    /// tests: of small loadings, of an injection, and of the networks of the packings named
    #[arg(long, value_name = "DIR", conflicts_with = "parts")]
    write_reference: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// The parts of the comparison.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum PartName {
    /// The pore network and its static flow, pore for pore
    Network,
    /// Forces between neighbours
    Edges,
    /// Pores that are held at a pressure, and Darcy conductances
    Injection,
    /// The start of a flow of a compressible fluid
    Compressible,
    /// The flow through a periodic cell
    Periodic,
    /// Loading without fluid
    Dry,
    /// Loading with fluid
    Coupled,
    /// Time per step and phase, and memory
    Time,
}

/// One part of the comparison: measured, judged and shown.
trait Part: Serialize + DeserializeOwned {
    /// Name of its file, and of its logs.
    const NAME: &'static str;

    /// Runs both programs.
    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Self, Error>;

    /// What was compared, with the bound that each has to keep.
    fn verdicts(&self) -> Vec<Verdict>;

    /// What else a reader should know first, in one line.
    fn headline(&self) -> Option<String> {
        None
    }

    /// Its section of the report, in Markdown; its figures go into the folder, and its
    /// links name their files alone.
    fn section(&self, folder: &Path) -> Result<String, Error>;
}

/// How a comparison came out.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Report {
    /// With YADE.
    Yade(YadeReport),
    /// With all peers.
    Peers(peers::Report),
    /// A measurement, which has written its own file.
    Job,
}

/// How the comparison with YADE came out.
#[derive(Serialize)]
pub struct YadeReport {
    yade: String,
    verdicts: Vec<Verdict>,
    page: PathBuf,
}

impl Report {
    /// What the program ends with after the report: an error when something lies
    /// outside its bounds and nothing explains why. A contest is not lost by an error.
    pub fn judge(&self) -> Result<(), Error> {
        let Report::Yade(report) = self else { return Ok(()) };
        match report.verdicts.iter().filter(|v| v.fails()).count() {
            0 => Ok(()),
            count => Err(Error::Differs { count, page: report.page.clone() }),
        }
    }
}

/// Makes the comparison that is named.
///
/// # Errors
/// What is wrong in the options; or which step of the comparison failed, and where the
/// log of it is.
pub fn run(args: &Args) -> Result<Report, Error> {
    match &args.with {
        Peer::Yade(args) => run_yade(args).map(Report::Yade),
        Peer::Peers(args) => peers::run(args).map(Report::Peers),
        Peer::Job(args) => peers::job::run(args).map(|()| Report::Job),
    }
}

/// Runs YADE and ours on the same input and writes the report.
fn run_yade(args: &YadeArgs) -> Result<YadeReport, Error> {
    let networks = packings(&args.packings, &SHIPPED)?;
    let packings = packings(&args.packings, &PACKINGS)?;
    let folder = args.output.folder(Path::new("compare-yade"), PAGE)?;
    let yade = peer::Yade::find(&args.yade)?;
    make_folder(&folder)?;
    let versions = format!("YADE {}", yade.version);
    let bench = Bench::new(folder, yade, &versions)?;
    if let Some(folder) = &args.write_reference {
        make_folder(folder)?;
        reference::write(&bench, folder)?;
        injection::write(&bench, folder)?;
        if !args.packings.is_empty() {
            network::write_reference(&bench, &networks, folder)?;
        }
        return Ok(YadeReport { yade: bench.peer.version, verdicts: vec![], page: folder.clone() });
    }
    let mut page = page::Page::new(&bench)?;
    let force = args.output.force;
    let chosen = |part| args.parts.is_empty() || args.parts.contains(&part);
    page.add::<network::Part>(&bench, &networks, chosen(PartName::Network), force)?;
    page.add::<edges::Part>(&bench, &packings, chosen(PartName::Edges), force)?;
    page.add::<filling::Injected>(&bench, &packings, chosen(PartName::Injection), force)?;
    page.add::<filling::Compressible>(&bench, &packings, chosen(PartName::Compressible), force)?;
    page.add::<periodic::Part>(&bench, &[], chosen(PartName::Periodic), force)?;
    page.add::<dry::Part>(&bench, &packings, chosen(PartName::Dry), force)?;
    page.add::<coupled::Part>(&bench, &packings, chosen(PartName::Coupled), force)?;
    page.add::<time::Part>(&bench, &packings, chosen(PartName::Time), force)?;
    let path = bench.folder.join(PAGE);
    let verdicts = page.write(&path)?;
    Ok(YadeReport { yade: bench.peer.version.clone(), verdicts, page: path })
}

/// The packings to compare on, by absolute path: the other program runs elsewhere.
fn packings(named: &[PathBuf], shipped: &[&str]) -> Result<Vec<PathBuf>, InputError> {
    let shipped: Vec<PathBuf> = shipped.iter().map(PathBuf::from).collect();
    let wanted = if named.is_empty() { &shipped[..] } else { named };
    let found = wanted.iter().map(|path| {
        std::path::absolute(path).and_then(|p| p.metadata().map(|_| p)).map_err(|e| {
            let remedy = match named.is_empty() {
                true => "name packings, or start in a checkout of the project",
                false => "name packing files",
            };
            InputError::new(format!("{}: {e}", path.display()), remedy)
        })
    });
    found.collect()
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Report::Yade(report) => report.fmt(f),
            Report::Peers(report) => report.fmt(f),
            Report::Job => Ok(()),
        }
    }
}

impl fmt::Display for YadeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "YADE {} beside dempfv {}\n", self.yade, env!("CARGO_PKG_VERSION"))?;
        let rows: Vec<Vec<String>> = self.verdicts.iter().map(Verdict::row).collect();
        if !rows.is_empty() {
            write!(f, "{}", table(&Verdict::HEADER, &rows))?;
        }
        writeln!(f, "\n  written        {}", self.page.display())
    }
}
