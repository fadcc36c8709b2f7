//! What it costs, and what it gains, when the network follows the spheres at
//! every step: `make every-step`, or
//! `cargo run --release --example every_step -- FOLDER [SPHERES ...]`.
//!
//! Writes `FOLDER/every-step.md` with its figures and points in
//! `FOLDER/every-step/`.

#[allow(dead_code, unused_imports, reason = "the program draws more than this")]
#[path = "../src/report/plot/mod.rs"]
mod plot;

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use dempfv::coupling::Phase;
use dempfv::coupling::Update;
use dempfv::io::atomic;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use plot::{Axis, Mark, SERIES, Series, xy};

/// Steps of each run, and between two looks at the pressures.
const STEPS: u64 = 2000;
const LOOK: u64 = 50;
/// Remesh intervals.
const INTERVALS: [u64; 5] = [20, 60, 200, 600, 2000];

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

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "out".to_owned());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder.join("every-step"))?;
    let mut sizes: Vec<String> = arguments.collect();
    if sizes.is_empty() {
        sizes = vec!["1000".to_owned(), "5000".to_owned()];
    }
    let mut page = HEAD.to_owned();
    for spheres in sizes {
        let packing = format!("{}/packings/oedometer-{spheres}.txt", env!("CARGO_MANIFEST_DIR"));
        page += &section(&packing, &spheres, folder)?;
    }
    atomic::write(&folder.join("every-step.md"), page.trim_end().as_bytes())?;
    println!("{}", folder.join("every-step.md").display());
    Ok(())
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

fn section(packing: &str, spheres: &str, folder: &Path) -> Result<String, Box<dyn Error>> {
    let reference = run(packing, 1, Update::Remesh)?;
    let mut runs = vec![];
    for update in Update::ALL {
        for interval in INTERVALS {
            runs.push(run(packing, interval, update)?);
        }
    }
    let mut text = format!(
        "## {spheres} spheres\n\n![Error against cost](every-step/error-{spheres}.png)\n\n\
         A remesh at every step takes {:.3} ms a step on {} threads.\n\n\
         | remesh interval | update | networks, of them early | ms a step | of it update | of it \
         solve | applications a solve | mean error | largest error |\n\
         |---:|---|---:|---:|---:|---:|---:|---:|---:|\n",
        reference.ms,
        rayon::current_num_threads(),
    );
    let mut points = "interval,update,networks,early,ms_per_step,update_ms,solve_ms,applications,\
                      largest_estimate,mean_error,largest_error\n"
        .to_owned();
    let mut curves = Update::ALL.map(|_| (vec![], vec![]));
    for run in &runs {
        let (mean, largest) = errors(run, &reference);
        let Run { interval, ms, update_ms, solve_ms, networks, worn_out, applications, .. } = run;
        let update = run.update.name();
        let taken = |x: f64, digits: usize| match run.update {
            Update::Remesh => "—".to_owned(),
            Update::EveryStep => format!("{x:.digits$}"),
        };
        writeln!(
            text,
            "| {interval} | {update} | {networks}, {worn_out} | {ms:.3} | {} | {solve_ms:.3} | {} \
             | {mean:.1e} | {largest:.1e} |",
            taken(*update_ms, 3),
            taken(*applications, 1),
        )?;
        writeln!(
            points,
            "{interval},{update},{networks},{worn_out},{ms},{update_ms},{solve_ms},{applications},{:e},\
             {mean:e},{largest:e}",
            run.largest_estimate
        )?;
        let (x, y) = &mut curves[run.update as usize];
        x.push(*ms);
        y.push(mean);
    }
    atomic::write(&folder.join(format!("every-step/points-{spheres}.csv")), points.as_bytes())?;
    picture(&curves, spheres, folder)?;
    let worst = runs.iter().map(|r| r.largest_estimate).fold(0.0, f64::max);
    writeln!(text, "\nNo solve's estimated error of the pressures was above {worst:.1e}.\n")?;
    Ok(text)
}

fn picture(
    curves: &[(Vec<f64>, Vec<f64>); 2],
    spheres: &str,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
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
    Ok(picture.save(&folder.join("every-step"), &format!("error-{spheres}"))?)
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

fn run(packing: &str, interval: u64, update: Update) -> Result<Run, Box<dyn Error>> {
    let scene = format!(
        "[particles]\npacking = {packing:?}\n[dem]\ndt = 1.0e-6\n\
         [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = {interval}\nupdate = {:?}\n\
         [[stage]]\nkind = \"run\"\nsteps = {STEPS}\nwalls = {{ y_max = {{ stress = 1.0e4 }} }}\n",
        update.name()
    );
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
    let (coupled, counts) = (simulation.coupled(), *simulation.coupled().update_counts());
    let per_step = |phase| 1e3 * coupled.phases().spent(phase).as_secs_f64() / STEPS as f64;
    let run = Run {
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
    };
    eprintln!("{packing}: every {interval}, {}: {:.3} ms a step", update.name(), run.ms);
    Ok(run)
}
