//! The section of the report on times: tables and a plot.

use std::path::Path;

use dempfv::solver::{FRONTAL_FROM, SolverKind};
use dempfv_report::format::{bytes, count, three_digits};
use dempfv_report::plot::{Axis, Mark, SERIES, Series, xy};

use super::runs::Tuning;
use super::{Case, INTERVAL, Part, Side, Times};
use crate::Error;

/// Name of the plot's files.
const FIGURE: &str = "time";
/// Other programs that keep more cores than this busy make times rough.
const DISTURBED: f64 = 0.1;

/// The section; its figure goes into the folder.
pub fn write(part: &Part, folder: &Path) -> Result<String, Error> {
    draw(part, folder)?;
    let mut text = introduction();
    if let Some(busy) = part.busy_cores.filter(|&busy| busy > DISTURBED) {
        text += &format!(
            "\n**Other programs kept {busy:.1} cores busy just before: these times are rough.**\n"
        );
    }
    text += &format!("\n{}", summary(part));
    text += &format!("\n![Time per step against the number of spheres]({FIGURE}.png)\n");
    text += &format!("\n{}", slower(part));
    let sizes = part.cases.chunk_by(|a, b| a.spheres == b.spheres);
    for cases in sizes {
        text += &format!("\n{}", phases(cases));
    }
    text += &format!("\n{}", trials(part));
    Ok(text)
}

/// The ratios of the times per step.
pub fn headline(part: &Part) -> Option<String> {
    let ratios: Vec<String> = part
        .cases
        .iter()
        .map(|case| {
            let [yade, ours] = [case.yade, case.ours].map(|side| side.times.per_step(INTERVAL));
            let (spheres, threads) = (count(case.spheres as u64), threads(case.threads));
            format!("{} ({spheres} spheres, {threads})", ratio(yade, ours))
        })
        .collect();
    let list = ratios.join(", ");
    (!ratios.is_empty())
        .then(|| format!("time: a coupled step takes YADE so many times longer: {list}"))
}

/// A number of threads in words.
fn threads(n: usize) -> String {
    if n == 1 { "1 thread".to_owned() } else { format!("{n} threads") }
}

fn introduction() -> String {
    format!(
        "\
## Time and memory

The specimen of Caulk et al. (2020): E = 1 MPa, k_s/k_n = 0.5, 30° friction, 1 kPa held on `y_max` by a \
servo, drained there, μ = 1 mPa·s, Δt = 1 µs, YADE's clamp on in both programs. They ran by turns on the \
same machine with the same number of threads, each in a process of its own.

YADE's times are its own: `execTime` of its engines and `FlowEngine.timingDeltas`, read after every step \
(the reading not counted). Ours are `phases_ms` of `summary.json`. A remesh is what the steps with a new \
network take beyond the others: triangulation, throats, ordering, analysis, factorization. YADE's first \
step, with its collider's first sort, is not counted; ours is. Ours factors and solves by its \
default, `{}`: CHOLMOD below {} unknowns, its frontal solver from there on, which uses all threads.
",
        SolverKind::default(),
        count(FRONTAL_FROM as u64),
    )
}

/// Time per step, remeshes included, and memory: the figures to quote.
fn summary(part: &Part) -> String {
    let mut text =
        "| spheres | pores | threads | YADE, ms a step | dempfv, ms a step | YADE/dempfv | \
                    YADE, memory | dempfv, memory |\n|--:|--:|--:|--:|--:|--:|--:|--:|\n"
            .to_owned();
    for case in &part.cases {
        let times = [case.yade, case.ours].map(|side| side.times.per_step(INTERVAL));
        text += &format!(
            "| {} | {} | {} | {} | {} | **{}** | {} | {} |\n",
            count(case.spheres as u64),
            count(case.pores),
            case.threads,
            three_digits(times[0]),
            three_digits(times[1]),
            ratio(times[0], times[1]),
            bytes(case.yade.peak_memory_bytes as f64),
            bytes(case.ours.peak_memory_bytes as f64),
        );
    }
    text += "\nA step with its share of a remesh every 200 steps. Memory is the most that the process held (VmHWM)";
    let base = part.cases.iter().find_map(|c| c.yade.base_memory_bytes);
    match base {
        Some(base) => {
            text + &format!(
                "; {} of YADE's is there before the first sphere.\n",
                bytes(base as f64)
            )
        }
        None => text + ".\n",
    }
}

/// A row of the table of phases: its name, and its value in a run (ms).
type Row = (&'static str, fn(&Times) -> f64);

/// What no phase accounts for.
const REST: &str = "the rest";

const ROWS: [Row; 10] = [
    ("contacts", |t| t.step.contacts),
    ("integration, servo", |t| t.step.integration),
    ("volumes", |t| t.step.volumes),
    ("solve", |t| t.step.solve),
    ("forces", |t| t.step.forces),
    (REST, |t| t.step.other()),
    ("**a step between remeshes**", |t| t.step.all),
    ("remesh: network", |t| t.remesh.network()),
    ("remesh: order, analyse, factorize", |t| t.remesh.factor),
    ("**one remesh**", |t| t.remesh.all),
];

/// Phase by phase, of one packing.
fn phases(cases: &[Case]) -> String {
    let Some(first) = cases.first() else { return String::new() };
    let repeats = match first.runs {
        1 => "one run each".to_owned(),
        n => format!("median of {n} runs each"),
    };
    let mut text = format!(
        "### {} spheres, {} pores\n\nMilliseconds; {repeats} of {} steps.\n\n|",
        count(first.spheres as u64),
        count(first.pores),
        first.steps
    );
    for case in cases {
        let threads = threads(case.threads);
        text += &format!(" | YADE, {threads} | dempfv, {threads} | YADE/dempfv");
    }
    text += &format!(" |\n|:--{} |\n", " | --: | --: | --:".repeat(cases.len()));
    for (name, value) in ROWS {
        text += &format!("| {name}");
        for case in cases {
            let [yade, ours] = [case.yade, case.ours].map(|side: Side| value(&side.times));
            let ratio = match is_slower(name, yade, ours) {
                true => format!("**{}, slower**", ratio(yade, ours)),
                false => ratio(yade, ours),
            };
            text += &format!(" | {} | {} | {ratio}", three_digits(yade), three_digits(ours));
        }
        text += " |\n";
    }
    for case in cases.iter().filter(|c| c.threads > 1) {
        text += &format!(
            "\nWith {} threads YADE solved with {}, the faster way here.\n",
            case.threads,
            blas(case.tuning.blas_threads)
        );
    }
    text
}

/// Where ours takes longer: which phase, on what.
fn slower(part: &Part) -> String {
    let mut found = Vec::new();
    for case in &part.cases {
        for (name, value) in ROWS {
            let [yade, ours] = [case.yade, case.ours].map(|side: Side| value(&side.times));
            if is_slower(name, yade, ours) {
                found.push(format!(
                    "- {}, {} spheres, {}: {} ms against {} ms",
                    name.trim_matches('*'),
                    count(case.spheres as u64),
                    threads(case.threads),
                    three_digits(ours),
                    three_digits(yade)
                ));
            }
        }
    }
    match found.is_empty() {
        true => "In no phase is dempfv slower than YADE.\n".to_owned(),
        false => format!("dempfv is slower than YADE in:\n\n{}\n", found.join("\n")),
    }
}

/// Whether ours takes longer in a phase; what is left over is none.
fn is_slower(row: &str, yade: f64, ours: f64) -> bool {
    row != REST && ours > yade
}

/// YADE's time over ours.
fn ratio(yade: f64, ours: f64) -> String {
    // Phases of a few microseconds are no ground for a ratio.
    match yade.abs().max(ours.abs()) < 0.02 || ours <= 0.0 || yade <= 0.0 {
        true => "–".to_owned(),
        false => format!("{:.1}", yade / ours),
    }
}

fn blas(threads: usize) -> String {
    match threads {
        1 => "one thread of the BLAS".to_owned(),
        n => format!("{n} threads of the BLAS"),
    }
}

/// YADE's solvers beside each other.
fn trials(part: &Part) -> String {
    let Some(first) = part.trials.first() else { return String::new() };
    let mut text = format!(
        "### YADE's solvers\n\nOn {} spheres, one run each. `useSolver = 3`, the default, calls CHOLMOD \
         through Eigen, `useSolver = 4` calls it directly. What was the faster with most threads was \
         used above.\n\n| useSolver | threads | of them the BLAS | solve, ms | one remesh, ms | a step, \
         remesh every 200, ms |\n|--:|--:|--:|--:|--:|--:|\n",
        count(first.spheres as u64)
    );
    for trial in &part.trials {
        let Tuning { solver, blas_threads } = trial.tuning;
        text += &format!(
            "| {solver} | {} | {blas_threads} | {} | {} | {} |\n",
            trial.threads,
            three_digits(trial.times.step.solve),
            three_digits(trial.times.remesh.all),
            three_digits(trial.times.per_step(INTERVAL)),
        );
    }
    text
}

/// Time per step over the number of spheres, both programs, each number of threads.
fn draw(part: &Part, folder: &Path) -> Result<(), Error> {
    let mut numbers: Vec<usize> = part.cases.iter().map(|c| c.threads).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mut curves = Vec::new();
    for (program, color) in [("YADE", SERIES[1]), ("dempfv", SERIES[0])] {
        for &n in &numbers {
            let cases: Vec<&Case> = part.cases.iter().filter(|c| c.threads == n).collect();
            let x: Vec<f64> = cases.iter().map(|c| c.spheres as f64).collect();
            let side = |c: &Case| if program == "YADE" { c.yade } else { c.ours };
            let y: Vec<f64> = cases.iter().map(|c| side(c).times.per_step(INTERVAL)).collect();
            let dash = (n == 1 && numbers.len() > 1).then_some([5.0, 3.0]);
            curves.push((format!("{program}, {}", threads(n)), x, y, color, dash));
        }
    }
    let series: Vec<Series> = curves
        .iter()
        .flat_map(|(name, x, y, color, dash)| {
            let line = Mark::Line { width: 1.6, dash: *dash };
            let dots = Mark::Dots { radius: 3.0, apart: 0.0 };
            [(Some(name.clone()), line), (None, dots)].map(|(name, mark)| Series {
                name,
                x,
                y,
                color: *color,
                mark,
            })
        })
        .collect();
    xy(
        "Time per coupled step",
        "a step with its share of a remesh every 200 steps",
        Axis::log("Spheres"),
        Axis::log("Time per step (ms)"),
        &series,
    )
    .save(folder, FIGURE)?;
    Ok(())
}
