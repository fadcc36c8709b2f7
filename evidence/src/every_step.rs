//! `dempfv every-step`: what it costs, and what it gains, when the network follows the
//! spheres at every step.

use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use dempfv::InputError;
use dempfv::coupling::{Phase, Update};
use dempfv::io::atomic;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv_report::output::{OutputArgs, make_folder};
use dempfv_report::plot::{Axis, Mark, SERIES, Series, xy};
use dempfv_report::progress::Progress;
use serde::Serialize;

use crate::Error;

/// The page, and the folder of its figures and points beside it.
const PAGE: &str = "every-step.md";
const FOLDER: &str = "every-step";
/// Steps of each run, and between two looks at the pressures.
const STEPS: u64 = 2000;
const LOOK: u64 = 50;
/// Remesh intervals.
const INTERVALS: [u64; 5] = [20, 60, 200, 600, 2000];

/// What `every-step` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Packing files
    #[arg(default_values = ["packings/oedometer-1000.txt", "packings/oedometer-5000.txt"])]
    packings: Vec<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// What was written.
#[derive(Serialize)]
pub struct Report {
    page: PathBuf,
}

/// One run, per step where that makes sense.
struct Run {
    update: Update,
    interval: u64,
    ms: f64,
    update_ms: f64,
    solve_ms: f64,
    networks: u64,
    worn_out: u64,
    applications: f64,
    largest_estimate: f64,
    /// Pressures at the spheres, at each look.
    pressures: Vec<Vec<f64>>,
}

const HEAD: &str = "# The network at every step

`make every-step` wrote this page. `update = \"every step\"` recomputes volumes, conductances and
forces from the positions of each step; the triangulation waits for the next remesh, and the
factor of the last one serves conjugate gradients. Here is what that costs and gains against
plain reuse (`update = \"remesh\"`).

The specimens have settled at 1 kPa and are loaded at once with 10 kPa on their drained wall; 2000
steps of 1 µs. The pressure at a sphere is the mean of the pores around it, by volume. The error is
that of all spheres' pressures (root of the sum of squares), relative to those of a run that
remeshes at every step; its mean is the root mean square of 40 looks, one every 50 steps.

";

/// Measures each packing and writes the page.
///
/// # Errors
/// What is wrong in the options; or why a run cannot go on.
pub fn run(args: &Args) -> Result<Report, Error> {
    for packing in &args.packings {
        packing.metadata().map_err(|e| {
            let remedy = "name packing files, or start in a checkout of the project";
            InputError::new(format!("{}: {e}", packing.display()), remedy)
        })?;
    }
    let folder = args.output.folder(Path::new("every-step"), PAGE)?;
    make_folder(&folder)?;
    make_folder(&folder.join(FOLDER))?;
    let mut page = HEAD.to_owned();
    for packing in &args.packings {
        page += &section(packing, &folder)?;
    }
    let path = folder.join(PAGE);
    atomic::write(&path, page.trim_end().as_bytes())?;
    Ok(Report { page: path })
}

/// Runs a packing at every interval, and shows what that gives.
fn section(packing: &Path, folder: &Path) -> Result<String, Error> {
    let reference = measure(packing, 1, Update::Remesh)?;
    let mut runs = vec![];
    for update in Update::ALL {
        for interval in INTERVALS {
            runs.push(measure(packing, interval, update)?);
        }
    }
    let spheres = reference.pressures.first().map_or(0, Vec::len);
    atomic::write(
        &folder.join(format!("{FOLDER}/points-{spheres}.csv")),
        points(&runs, &reference).as_bytes(),
    )?;
    picture(&runs, &reference, spheres, &folder.join(FOLDER))?;
    let mut text = format!(
        "## {spheres} spheres\n\n![Error against cost]({FOLDER}/error-{spheres}.png)\n\n\
         A remesh at every step takes {:.3} ms a step on {} threads.\n\n",
        reference.ms,
        rayon::current_num_threads(),
    );
    text += &table(&runs, &reference);
    let worst = runs.iter().map(|r| r.largest_estimate).fold(0.0, f64::max);
    text += &format!("\nNo solve's estimated error of the pressures was above {worst:.1e}.\n\n");
    Ok(text)
}

fn table(runs: &[Run], reference: &Run) -> String {
    let mut text =
        "| remesh interval | update | networks, of them early | ms a step | of it update | of it \
         solve | applications a solve | mean error | largest error |\n\
         |---:|---|---:|---:|---:|---:|---:|---:|---:|\n"
            .to_owned();
    for run in runs {
        let (mean, largest) = errors(run, reference);
        let Run { interval, ms, update_ms, solve_ms, networks, worn_out, applications, .. } = run;
        let taken = |x: f64, digits: usize| match run.update {
            Update::Remesh => "—".to_owned(),
            Update::EveryStep => format!("{x:.digits$}"),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {interval} | {} | {networks}, {worn_out} | {ms:.3} | {} | {solve_ms:.3} | {} \
             | {mean:.1e} | {largest:.1e} |",
            run.update.name(),
            taken(*update_ms, 3),
            taken(*applications, 1),
        );
    }
    text
}

fn points(runs: &[Run], reference: &Run) -> String {
    let mut text = "interval,update,networks,early,ms_per_step,update_ms,solve_ms,applications,\
                    largest_estimate,mean_error,largest_error\n"
        .to_owned();
    for run in runs {
        let (mean, largest) = errors(run, reference);
        let Run { interval, ms, update_ms, solve_ms, networks, worn_out, applications, .. } = run;
        let _ = writeln!(
            text,
            "{interval},{},{networks},{worn_out},{ms},{update_ms},{solve_ms},{applications},{:e},\
             {mean:e},{largest:e}",
            run.update.name(),
            run.largest_estimate
        );
    }
    text
}

fn picture(runs: &[Run], reference: &Run, spheres: usize, folder: &Path) -> Result<(), Error> {
    let curves = Update::ALL.map(|update| {
        let points = runs.iter().filter(|run| run.update == update);
        points.map(|run| (run.ms, errors(run, reference).0)).unzip::<_, _, Vec<_>, Vec<_>>()
    });
    let line = Mark::Line { width: 1.6, dash: None };
    let dots = Mark::Dots { radius: 3.2, apart: 0.0 };
    let series: Vec<Series> = (curves.iter().zip(Update::ALL).zip(SERIES))
        .flat_map(|(((x, y), update), color)| {
            let line = Series { name: Some(update.name().to_owned()), x, y, color, mark: line };
            let dots = Series { name: None, mark: dots, ..line.clone() };
            [line, dots]
        })
        .collect();
    let title = format!("What an accurate pressure costs, {spheres} spheres");
    let caption = "Remesh every 20, 60, 200, 600 and 2000 steps (upwards)";
    let (x, y) = (Axis::log("Time of a step (ms)"), Axis::log("Mean error of the pressures (1)"));
    let picture = xy(&title, caption, x, y, &series);
    Ok(picture.save(folder, &format!("error-{spheres}"))?)
}

/// Root mean square and maximum over the looks of a run's error.
fn errors(run: &Run, reference: &Run) -> (f64, f64) {
    let error = |(p, q): (&Vec<f64>, &Vec<f64>)| {
        let off: f64 = p.iter().zip(q).map(|(p, q)| (p - q).powi(2)).sum();
        (off / q.iter().map(|q| q * q).sum::<f64>()).sqrt()
    };
    let all: Vec<f64> = run.pressures.iter().zip(&reference.pressures).map(error).collect();
    let mean = (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt();
    (mean, all.iter().copied().fold(0.0, f64::max))
}

/// Carries out one run.
fn measure(packing: &Path, interval: u64, update: Update) -> Result<Run, Error> {
    let scene = format!(
        "[particles]\npacking = {packing:?}\n[dem]\ndt = 1.0e-6\n\
         [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = {interval}\nupdate = {:?}\n\
         [[stage]]\nkind = \"run\"\nsteps = {STEPS}\nwalls = {{ y_max = {{ stress = 1.0e4 }} }}\n",
        update.name()
    );
    let mut progress = Progress::new();
    progress.wait(&format!("every {interval}, {}: {}", update.name(), packing.display()));
    let mut simulation = Simulation::new(Plan::from_toml(&scene, None)?)?;
    let (mut pressures, mut spent) = (vec![], 0.0);
    loop {
        let start = Instant::now();
        let more = simulation.advance()?;
        spent += start.elapsed().as_secs_f64();
        if simulation.step().is_multiple_of(LOOK) {
            pressures.push(simulation.coupled().pressure_at_spheres());
        }
        if !more {
            break;
        }
    }
    progress.waited();
    let (coupled, counts) = (simulation.coupled(), *simulation.coupled().update_counts());
    let per_step = |phase| 1e3 * coupled.phases().spent(phase).as_secs_f64() / STEPS as f64;
    Ok(Run {
        update,
        interval,
        ms: 1e3 * spent / STEPS as f64,
        update_ms: per_step(Phase::Update),
        solve_ms: per_step(Phase::Solve),
        networks: coupled.remeshes(),
        worn_out: counts.exhausted,
        applications: counts.applications as f64 / counts.solves.max(1) as f64,
        largest_estimate: counts.largest_error,
        pressures,
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  written        {}", self.page.display())
    }
}
