//! `dempfv accuracy-yade`: what accuracy costs in time in YADE, on the same axes as ours.

mod curve;
mod page;
mod runs;

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dempfv::InputError;
use dempfv::io::atomic;
use dempfv_report::machine;
use dempfv_report::output::{OutputArgs, lock_folder, make_folder};
use serde::Serialize;

use self::curve::{Point, Quantity};
use self::runs::{Course, Way, loading, model_time, run as run_one};
use crate::bench::sample::Sample;
use crate::compare::loading::Packing;
use crate::compare::peer::{Bench, Yade};
use crate::{Error, Result};

/// The file that marks a result, and the other ones beside it.
const PAGE: &str = "yade.md";
const CSV: &str = "yade.csv";
const JSON: &str = "yade.json";
const PICTURE: &str = "yade";
/// The packings, as they lie in a checkout.
const PACKING: &str = "packings/oedometer-5000.txt";
const QUICK_PACKING: &str = "packings/oedometer-1000.txt";
/// Steps from one remesh to the next, those of Caulk et al. (2020), fig. 2, and finer ones. The first is
/// that of the references.
const INTERVALS: [u64; 10] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const QUICK_INTERVALS: [u64; 5] = [1, 10, 50, 200, 1000];
/// Turns of a setting that takes YADE less than so many seconds.
const TURNS: usize = 3;
const SHORT: f64 = 60.0;
/// What the two references may be apart by: that of `compare yade` for coupled loadings.
const BOUND: f64 = 1e-2;
/// How long the machine is looked at before the first run.
const LOOK: Duration = Duration::from_secs(2);

/// What `accuracy-yade` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Packing file; 5,000 spheres that the project ships if not given, 1,000 with --quick
    packing: Option<PathBuf>,
    /// Five intervals, one turn each: minutes
    #[arg(long)]
    quick: bool,
    /// The program to compare with
    #[arg(long, value_name = "PROGRAM", default_value = "yade")]
    yade: PathBuf,
    #[command(flatten)]
    output: OutputArgs,
}

/// What was found.
#[derive(Serialize)]
pub struct Report {
    yade: String,
    packing: PathBuf,
    spheres: usize,
    pores: u64,
    threads: usize,
    /// Model time of each run (s).
    model_time_s: f64,
    points: Vec<Point>,
    /// How far the two references are apart (1).
    references_apart: References,
    /// Cores that other programs kept busy just before.
    busy_cores: Option<f64>,
    #[serde(skip)]
    page: PathBuf,
}

/// How far our reference is from YADE's, over the latter.
#[derive(Clone, Copy, Serialize)]
struct References {
    pressure: f64,
    settlement: f64,
}

impl Report {
    /// What the program ends with after the report: an error where the programs do not load the same packing,
    /// so that their times tell nothing.
    pub fn judge(&self) -> Result<()> {
        let References { pressure, settlement } = self.references_apart;
        let is_outside = |apart: &f64| apart.is_nan() || *apart > BOUND;
        match [pressure, settlement].into_iter().filter(is_outside).count() {
            0 => Ok(()),
            count => Err(Error::Differs { count, page: self.page.clone() }),
        }
    }
}

/// Runs both programs by turns and writes the table, the picture and the page.
///
/// # Errors
/// What is wrong in the options; or which run failed, and where its log is.
pub fn run(args: &Args, threads: usize) -> Result<Report> {
    let shipped = Path::new(if args.quick { QUICK_PACKING } else { PACKING });
    let named = args.packing.as_deref().unwrap_or(shipped);
    let path = named.canonicalize().map_err(|e| {
        let remedy = "name a packing file, or start in a checkout of the project";
        InputError::new(format!("{}: {e}", named.display()), remedy)
    })?;
    let packing = Packing::load(&path)?;
    let folder = args.output.folder(Path::new("accuracy-yade"), PAGE)?;
    let yade = Yade::find(&args.yade)?;
    make_folder(&folder)?;
    let _alone = lock_folder(&folder)?;
    let versions = format!("YADE {}", yade.version);
    let bench = Bench::new(folder, yade, &versions)?;
    // What was stopped before its end goes on; a result that is there is measured again.
    if bench.folder.join(PAGE).exists() {
        bench.forget("")?;
    }
    let busy_cores = machine::busy_cores(LOOK);
    let (intervals, turns) = match args.quick {
        true => (&QUICK_INTERVALS[..], 1),
        false => (&INTERVALS[..], TURNS),
    };
    let courses = measure(&bench, &packing, (intervals, turns), threads)?;
    let time = model_time(&loading(&packing, 1));
    let [yade_reference, our_reference] = [0, 1].map(|way| &courses[0][way][0]);
    let points = courses.iter().zip(intervals).flat_map(|(ways, &interval)| {
        Way::ALL.into_iter().zip(ways).map(move |(way, turns)| {
            let reference = if way == Way::Yade { yade_reference } else { our_reference };
            let error = |quantity: Quantity| quantity.error(&turns[0], reference);
            Point {
                way,
                interval,
                seconds: turns.iter().map(|course| course.seconds / time).collect::<Sample>(),
                error_pressure: error(Quantity::Pressure),
                error_settlement: error(Quantity::Settlement),
            }
        })
    });
    let apart = |quantity: Quantity| quantity.error(our_reference, yade_reference);
    let report = Report {
        yade: bench.peer.version.clone(),
        packing: named.to_owned(),
        spheres: packing.spheres.len(),
        pores: yade_reference.pores,
        threads,
        model_time_s: time,
        points: points.collect(),
        references_apart: References {
            pressure: apart(Quantity::Pressure),
            settlement: apart(Quantity::Settlement),
        },
        busy_cores,
        page: bench.folder.join(PAGE),
    };
    page::picture(&report).save(&bench.folder, PICTURE)?;
    atomic::write(&bench.folder.join(CSV), page::csv(&report).as_bytes())?;
    dempfv_report::json::write(&bench.folder.join(JSON), &report)?;
    atomic::write(&report.page, page::markdown(&report, PICTURE).as_bytes())?;
    Ok(report)
}

/// For each interval and each way the runs of all turns: one interval after the other, and in each the
/// programs by turns, so that a drift of the machine's speed meets both.
fn measure(
    bench: &Bench,
    packing: &Packing,
    (intervals, turns): (&[u64], usize),
    threads: usize,
) -> Result<Vec<[Vec<Course>; 3]>> {
    let mut all: Vec<[Vec<Course>; 3]> = vec![];
    for &interval in intervals {
        let loading = loading(packing, interval);
        let mut ways = Way::ALL.map(|_| vec![]);
        for turn in 1..=turns {
            let is_long = |ways: &[Vec<Course>; 3]| ways[0][0].seconds > SHORT;
            if turn > 1 && is_long(&ways) {
                break;
            }
            for (way, courses) in Way::ALL.into_iter().zip(&mut ways) {
                let name = format!("{}-{interval}-turn-{turn}", way.key());
                let input = (&packing.path, &loading, threads);
                courses.push(bench.remembered(&name, &input, || {
                    run_one(bench, (way, &name), packing, &loading, threads)
                })?);
            }
        }
        all.push(ways);
    }
    Ok(all)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "YADE {} beside dempfv {}\n", self.yade, env!("CARGO_PKG_VERSION"))?;
        for line in page::words(self).lines() {
            writeln!(f, "  {line}")?;
        }
        writeln!(f, "  written        {}", self.page.display())
    }
}
