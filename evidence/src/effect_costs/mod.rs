//! `dempfv effect-costs`: what each effect adds to the time of a step, all in one run.

mod cases;

use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use dempfv::InputError;
use dempfv::io::atomic;
use dempfv::io::packing::Packing;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv_report::format::three_digits;
use dempfv_report::machine;
use dempfv_report::output::{OutputArgs, make_folder};
use dempfv_report::progress::Progress;
use serde::Serialize;

use self::cases::{CASES, Case};
use crate::Error;
use crate::bench::sample::Sample;

/// The page, and its numbers for docs/effects.md.
const PAGE: &str = "effect-costs.md";
const TABLE: &str = "effect-costs.csv";
/// Steps of a turn of a scene with fluid: one remesh.
const WET_STEPS: u64 = 200;
/// Steps of a turn of a dry scene, of about a second.
const DRY_STEPS: u64 = 1_000;
/// Turns that are timed, after one that is not.
const TURNS: u64 = 7;
/// How long the machine is looked at before the first turn.
const LOOK: Duration = Duration::from_secs(2);

/// What `effect-costs` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Packing file
    #[arg(default_value = "packings/oedometer-20000.txt")]
    packing: PathBuf,
    /// Turns that are timed
    #[arg(long, default_value_t = TURNS, value_parser = clap::value_parser!(u64).range(1..))]
    turns: u64,
    #[command(flatten)]
    output: OutputArgs,
}

/// What each effect costs.
#[derive(Serialize)]
pub struct Report {
    page: PathBuf,
    costs: Vec<Cost>,
}

/// What a scene costs beside the one that it changes.
#[derive(Serialize)]
struct Cost {
    case: &'static str,
    over: Option<&'static str>,
    effects: &'static [&'static str],
    /// ms.
    step: Sample,
    /// Time of a step over that of the other scene in the same turn.
    ratio: Sample,
}

const HEAD: &str = "# What effects cost

`make effect-costs` wrote this page. Scenes that differ by one effect are carried out by turns: 1,000
steps of a dry scene, 200 of one with fluid, which has one remesh in them. The first turn is not timed. A step is the
median of the turns, with the range; what an effect adds is the median of the ratios to the scene below
it in the same turn, so that a machine that gets slower or faster in between changes little. An effect
that is off is not in the program's loops: see [effects.md](effects.md).

";

/// Measures every case and writes the page.
///
/// # Errors
/// What is wrong in the options; or why a run cannot go on.
pub fn run(args: &Args) -> Result<Report, Error> {
    let packing = args.packing.canonicalize().map_err(|e| {
        let remedy = "name a packing file, or start in a checkout of the project";
        InputError::new(format!("{}: {e}", args.packing.display()), remedy)
    })?;
    let folder = args.output.folder(Path::new("effect-costs"), PAGE)?;
    make_folder(&folder)?;
    let busy = machine::busy_cores(LOOK);
    let costs = measure(&packing, args.turns)?;
    let path = folder.join(PAGE);
    atomic::write(&path, page(&args.packing, &costs, busy).trim_end().as_bytes())?;
    atomic::write(&folder.join(TABLE), csv(&costs).as_bytes())?;
    Ok(Report { page: path, costs })
}

fn steps_of(case: &Case) -> u64 {
    if case.is_wet() { WET_STEPS } else { DRY_STEPS }
}

fn measure(packing: &Path, turns: u64) -> Result<Vec<Cost>, Error> {
    let mut progress = Progress::new();
    let box_ = Packing::read(packing).map_err(dempfv::Error::from)?.bounds.ok_or_else(|| {
        let what = format!("{}: no line `# box`", packing.display());
        InputError::new(what, "give the box that the spheres are in")
    })?;
    let mut runs = vec![];
    for case in CASES {
        let scene = case.scene(packing, &box_.size(), (turns + 1) * steps_of(case));
        runs.push(Simulation::new(Plan::from_toml(&scene, None)?)?);
    }
    let mut times = vec![Sample::default(); CASES.len()];
    for turn in 0..=turns {
        for ((case, run), times) in CASES.iter().zip(&mut runs).zip(&mut times) {
            progress.wait(&format!("turn {turn} of {turns}: {}", case.name));
            let start = Instant::now();
            let steps = steps_of(case);
            for _ in 0..steps {
                run.advance()?;
            }
            if turn > 0 {
                times.0.push(1e3 * start.elapsed().as_secs_f64() / steps as f64);
            }
            progress.waited();
        }
    }
    let step_of = |name: &str| CASES.iter().position(|case| case.name == name).map(|i| &times[i]);
    let cost = |(case, step): (&Case, &Sample)| {
        let below = case.over.and_then(step_of);
        let ratio = below.map_or(Sample::default(), |below| {
            step.0.iter().zip(&below.0).map(|(step, below)| step / below).collect()
        });
        let Case { name, over, effects, .. } = *case;
        Cost { case: name, over, effects, step: step.clone(), ratio }
    };
    Ok(CASES.iter().zip(&times).map(cost).collect())
}

fn page(packing: &Path, costs: &[Cost], busy: Option<f64>) -> String {
    let name = packing.file_stem().unwrap_or_default().to_string_lossy();
    let mut page = HEAD.to_owned();
    // Writing to a string cannot fail.
    let _ = writeln!(
        page,
        "{name}, {} threads. {}. Measured on {}{}.\n\n\
         | scene | changes | ms a step | adds |\n|---|---|---:|---:|",
        rayon::current_num_threads(),
        machine::description(),
        machine::today(),
        busy.map_or(String::new(), |busy| format!("; others kept {busy:.1} cores busy")),
    );
    for cost in costs {
        let adds = cost.over.map_or("–".to_owned(), |_| show(&cost.ratio));
        let over = cost.over.unwrap_or("–");
        let _ = writeln!(page, "| {} | {over} | {} | {adds} |", cost.case, cost.step.show(1.0));
    }
    page
}

/// A ratio as what it adds: the median, and the range.
fn show(ratio: &Sample) -> String {
    let [low, high] = ratio.range();
    format!("{} ({} to {})", percent(ratio.median()), percent(low), percent(high))
}

fn percent(ratio: f64) -> String {
    format!("{:+.0} %", 100.0 * (ratio - 1.0))
}

fn csv(costs: &[Cost]) -> String {
    let mut text = "effect,over,adds_percent,step_ms\n".to_owned();
    for Cost { effects, over, ratio, step, .. } in costs {
        for effect in *effects {
            let adds =
                over.map_or(String::new(), |_| format!("{:.0}", 100.0 * (ratio.median() - 1.0)));
            let _ = writeln!(
                text,
                "{effect},{},{adds},{}",
                over.unwrap_or_default(),
                three_digits(step.median())
            );
        }
    }
    text
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for cost in &self.costs {
            let adds = cost.over.map_or(String::new(), |over| {
                format!("{:>8} of {over}", percent(cost.ratio.median()))
            });
            writeln!(f, "  {:<24}{:>9.3} ms {adds}", cost.case, cost.step.median())?;
        }
        writeln!(f, "  written        {}", self.page.display())
    }
}
