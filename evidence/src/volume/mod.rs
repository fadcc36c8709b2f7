//! `dempfv representative-volume`: how far permeability and stiffness of one packing stand for those of all
//! packings made in the same way, over its number of spheres.

mod page;
mod specimen;
mod statistics;

use std::fmt;
use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::io::atomic;
use dempfv_report::format::count;
use dempfv_report::machine;
use dempfv_report::output::{OutputArgs, lock_folder, make_folder};
use dempfv_report::progress::Progress;
use serde::Serialize;

use self::specimen::{FEWEST, Specimen, expected_steps, scene};
use self::statistics::{Law, Quantity, Size};
use crate::Result;
use crate::bench::Bench;

/// The file that marks a result, and the other ones beside it.
const JSON: &str = "representative-volume.json";
const CSV: &str = "representative-volume.csv";
const MARKDOWN: &str = "representative-volume.md";
/// Pictures: values, and what separates seeds.
const VALUES: &str = "representative-volume";
const SPREADS: &str = "representative-volume-spread";

const SPHERES: [u32; 7] = [500, 1_000, 2_000, 5_000, 10_000, 20_000, 40_000];
const SEEDS: u64 = 8;
/// Of these, with `--quick`.
const QUICK_SIZES: usize = 3;
const QUICK_SEEDS: u64 = 2;

/// What `representative-volume` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Numbers of spheres; 500 to 40,000 if not given
    #[arg(long, value_name = "N", value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(i64::from(FEWEST)..))]
    spheres: Vec<u32>,
    /// Packings of each size; 8 if not given, 2 with --quick
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..))]
    seeds: Option<u64>,
    /// The three smallest sizes, two seeds: a minute or two
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// What was found.
#[derive(Serialize)]
pub struct Report {
    sizes: Vec<Size>,
    /// How spreads fall with the number of spheres.
    laws: Vec<Law>,
    #[serde(skip)]
    words: String,
    #[serde(skip)]
    page: PathBuf,
}

/// Measures all specimens and writes the table, the pictures and the page.
///
/// # Errors
/// What is wrong in the options; or why a specimen cannot be made.
pub fn run(args: &Args) -> Result<Report> {
    let mut spheres = match (args.spheres.is_empty(), args.quick) {
        (false, _) => args.spheres.clone(),
        (true, true) => SPHERES[..QUICK_SIZES].to_vec(),
        (true, false) => SPHERES.to_vec(),
    };
    spheres.sort_unstable();
    if let Some(twice) = spheres.windows(2).find(|pair| pair[0] == pair[1]) {
        let what = format!("--spheres has {} twice", count(u64::from(twice[0])));
        return Err(InputError::new(what, "name each number of spheres once").into());
    }
    let seeds = args.seeds.unwrap_or(if args.quick { QUICK_SEEDS } else { SEEDS });
    let folder = args.output.folder(Path::new("representative-volume"), JSON)?;
    make_folder(&folder)?;
    let _alone = lock_folder(&folder)?;
    let bench = Bench::new(folder, (), "")?;
    // What was stopped before its end goes on; a result that is there is measured again.
    if bench.folder.join(JSON).exists() {
        bench.forget("")?;
    }
    let sizes = measure(&bench, &spheres, seeds)?;
    let both = [Quantity::Permeability, Quantity::Modulus];
    let laws: Vec<Law> = both.iter().filter_map(|q| Law::fit(*q, &sizes)).collect();
    page::values(&sizes).save(&bench.folder, VALUES)?;
    page::spreads(&sizes, &laws).save(&bench.folder, SPREADS)?;
    let words = page::words(&sizes, &laws);
    let path = bench.folder.join(MARKDOWN);
    let text = page::markdown(&sizes, &words, [VALUES, SPREADS]);
    let about = format!("{}. Measured on {}.\n", machine::description(), machine::today());
    atomic::write(&path, format!("{text}{about}").as_bytes())?;
    atomic::write(&bench.folder.join(CSV), page::csv(&sizes).as_bytes())?;
    let report = Report { sizes, laws, words, page: path };
    dempfv_report::json::write(&bench.folder.join(JSON), &report)?;
    Ok(report)
}

/// All specimens of all sizes, kept one by one.
fn measure(bench: &Bench, spheres: &[u32], seeds: u64) -> Result<Vec<Size>> {
    let work = |spheres: u32| f64::from(spheres) * expected_steps(spheres);
    let whole: f64 = spheres.iter().map(|&n| seeds as f64 * work(n)).sum();
    let mut progress = Progress::new();
    progress.begin("specimens", 0, true);
    let (mut done, mut steps) = (0.0, 0);
    let mut sizes = vec![];
    for &spheres in spheres {
        let mut specimens = vec![];
        for seed in 1..=seeds {
            let name = format!("{} spheres, seed {seed}", count(u64::from(spheres)));
            let specimen =
                bench.remembered(&format!("{spheres}-{seed}"), &scene(spheres, seed), || {
                    Specimen::measure(spheres, seed, |step| {
                        let share = (step as f64 / expected_steps(spheres)).min(1.0);
                        let share = (done + share * work(spheres)) / whole;
                        progress.update(steps + step, Some(share), || name.clone());
                    })
                })?;
            done += work(spheres);
            steps += specimen.steps;
            specimens.push(specimen);
        }
        sizes.push(Size::of(spheres, specimens));
    }
    progress.end(steps, "");
    Ok(sizes)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in self.words.lines() {
            writeln!(f, "  {line}")?;
        }
        writeln!(f, "  written        {}", self.page.display())
    }
}
