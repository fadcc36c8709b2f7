//! The report: the rows of the contest, and below them everything that was measured.

use std::path::Path;

use dempfv::io::atomic;
use dempfv_report::format::{bytes, count, three_digits};
use dempfv_report::{machine, versions};

use super::contacts::{self, Case};
use super::coupled::{self, PHASES, REMESH, Way};
use super::linear;
use super::model;
use super::rows::Row;
use super::{Contest, FIGURES, Results};
use crate::Error;

/// Other programs that keep more cores than this busy make times rough.
const DISTURBED: f64 = 0.1;

/// Writes it. `drawn`: names of the figures, and what they show.
///
/// # Errors
/// The system refuses.
pub fn write(
    contest: &Contest,
    results: &Results,
    rows: &[Row],
    drawn: &[(&str, &str)],
    path: &Path,
) -> Result<(), Error> {
    let mut text = head(contest, results);
    text += &contest_table(rows);
    for (name, what) in drawn {
        text += &format!("\n![{what}]({FIGURES}/{name}.png)\n");
    }
    text += &limits(results);
    text += &dry(results);
    text += &contacts::section(&results.contacts);
    text += &coupled(contest, results);
    text += &network(results);
    text += &linear(results);
    text += &inside(results);
    atomic::write(path, text.as_bytes())?;
    Ok(())
}

fn head(contest: &Contest, results: &Results) -> String {
    let ours = versions::all();
    let of = |name: &str| ours.get(name).map_or("unknown", String::as_str);
    let version = |name: &str| {
        let sides = results.linear.iter().flat_map(|c| &c.sides);
        sides.filter(|s| s.name == name).map(|s| s.version.clone()).next()
    };
    let none = || "left out".to_owned();
    let lammps = contest.others.lammps.as_ref().map(|l| l.version.clone());
    let mut text = format!(
        "# dempfv beside what people would pick instead\n\n\
         Everything on this page was measured in one run on {}, program by program in turn, by \
         `make compare`. Every program had {} threads (LAMMPS as many processes). Times are medians, \
         with the range in brackets.\n\n\
         Machine: {}. Load average before the first run {}, other programs kept {} cores busy.\n\n\
         dempfv {} ({}) with the solver `{}`, rustc {}; YADE {}; LAMMPS {}; CHOLMOD {} (SuiteSparse \
         {}) with METIS {} and {}; PARDISO: {}; faer {}.\n\n",
        results.start.day,
        contest.threads,
        machine::description(),
        results.start.load,
        results.start.busy_cores.map_or("an unknown number of".to_owned(), |b| format!("{b:.1}")),
        of("dempfv"),
        of("git"),
        contest.ours,
        of("rustc"),
        contest.bench.peer.version,
        lammps.unwrap_or_else(none),
        of("cholmod"),
        of("suitesparse"),
        of("metis"),
        versions::blas_with_kernels(),
        version(linear::PARDISO_NAME).unwrap_or_else(none),
        version(linear::FAER).unwrap_or_else(none),
    );
    if results.start.busy_cores.is_some_and(|busy| busy > DISTURBED) {
        text += "**The machine was not at rest: these times are rough.**\n\n";
    }
    if contest.quick {
        text += "**Small packings and single runs (`--quick`): no times to quote.**\n\n";
    }
    text
}

/// The page of contacts alone.
pub fn contacts(contest: &Contest, cases: &[Case]) -> String {
    let ours = versions::all();
    let of = |name: &str| ours.get(name).map_or("unknown", String::as_str);
    let lammps = contest.others.lammps.as_ref().map_or("left out", |l| &l.version);
    format!(
        "# Contacts of dempfv beside those of LAMMPS\n\nMeasured on {} by `dempfv compare peers \
         --contacts`. Machine: {}. dempfv {} ({}), rustc {}; LAMMPS {lammps}.\n{}",
        machine::today(),
        machine::description(),
        of("dempfv"),
        of("git"),
        of("rustc"),
        contacts::section(cases)
    )
}

fn contest_table(rows: &[Row]) -> String {
    let mut text = "## The contest\n\n| # | what | on | measured | must | aim | outcome | with |\n\
                    |--:|:--|:--|--:|--:|--:|:--|:--|\n"
        .to_owned();
    for row in rows {
        text += &format!("| {} |\n", row.cells().join(" | "));
    }
    text
}

fn limits(results: &Results) -> String {
    let mut text =
        "\n## What the machine can do\n\nMeasured in the same run, at its beginning and \
                    at its end: memory read by sums over 512 MiB, products of square matrices of \
                    2,048 rows by the BLAS; the best of five each.\n\n| | 1 thread | 2 threads |\n\
                    |:--|--:|--:|\n"
            .to_owned();
    let [first, last] = &results.limits;
    let rows = [
        ("memory, GB/s", first.bandwidth, last.bandwidth),
        ("dgemm, GFLOP/s", first.double, last.double),
        ("sgemm, GFLOP/s", first.single, last.single),
    ];
    for (name, first, last) in rows {
        let cell = |i: usize| format!("{:.1}, {:.1}", 1e-9 * first[i], 1e-9 * last[i]);
        text += &format!("| {name} | {} | {} |\n", cell(0), cell(1));
    }
    text
}

fn dry(results: &Results) -> String {
    let mut text = "\n## A dry step\n\nA settled packing between six walls that stand still, with \
                    friction of 30° and rotation; Δt = 2·10⁻⁵ s. The first 100 steps are not timed. \
                    LAMMPS: `gran/hooke/history`, one stiffness for all pairs (ours and YADE's \
                    follow the radii), viscous damping in the contacts as strong as the local \
                    damping of the others.\n\n| spheres | program | ms a step | contacts |\n\
                    |--:|:--|--:|--:|\n"
        .to_owned();
    for case in &results.dry {
        let sides = [("YADE", Some(&case.yade)), ("LAMMPS", case.lammps.as_ref())];
        for (name, side) in sides.into_iter().chain([("dempfv", Some(&case.ours))]) {
            let Some(side) = side else { continue };
            text += &format!(
                "| {} | {name} | {} | {} |\n",
                count(case.spheres as u64),
                side.step_s.show(1e-3),
                count(side.contacts as u64)
            );
        }
    }
    text
}

fn coupled(contest: &Contest, results: &Results) -> String {
    let mut text = "\n## A coupled step\n\nThe specimen of Caulk et al. (2020): E = 1 MPa, \
                    k_s/k_n = 0.5, 30° friction, 1 kPa held on `y_max` by a servo, drained there, \
                    μ = 1 mPa·s, Δt = 1 µs, YADE's clamp on in both programs, a remesh every 200 \
                    steps; ours with `tolerance = 1e-6`, what came of it is below. Ours: whole intervals from one remesh to the next, by the clock. YADE: \
                    the mean of the steps between remeshes and a remesh's time over 200. The \
                    contest compares remeshes that stop the steps in both programs; YADE's own \
                    background thread was not tried, and ours takes a second pool of threads.\n\n\
                    | spheres | pores | YADE, ms | dempfv, remesh in turn, ms | in the background, \
                    ms | YADE without remeshes, ms | dempfv without, ms |\n\
                    |--:|--:|--:|--:|--:|--:|--:|\n"
        .to_owned();
    for case in &results.coupled {
        let whole = |way: Way| {
            let side = case.ours.iter().find(|side| side.way == way);
            side.map_or("–".to_owned(), |side| side.whole_s.show(1e-3))
        };
        let apart = case.ours.iter().find(|side| side.way == Way::InTurn);
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {} |\n",
            count(case.spheres as u64),
            count(case.pores),
            case.yade_s.show(1e-3),
            whole(Way::InTurn),
            whole(Way::Background),
            case.yade_step_s.show(1e-3),
            apart.map_or("–".to_owned(), |side| side.step_s.show(1e-3)),
        );
    }
    text += &pressures(results);
    for case in &results.coupled {
        text += &phases(contest, results, case);
    }
    text + "\nMore than 100 %: what a phase needs stays in the caches from step to step.\n"
}

fn pressures(results: &Results) -> String {
    let mut text = "\nPressures against CHOLMOD's in double precision, refined, on the same network \
                    and motion: largest error over the largest pressure, and |b − G p|₂/|b|₂ summed \
                    up throat by throat; the worst of the steps looked at, the first ones after \
                    remeshes among them.\n\n| spheres | largest error | residual | steps looked at \
                    |\n|--:|--:|--:|--:|\n"
        .to_owned();
    for case in &results.coupled {
        let worst = |v: &[f64]| crate::bench::sample::worst(v.iter().copied());
        text += &format!(
            "| {} | {:.1e} | {:.1e} | {} |\n",
            count(case.spheres as u64),
            worst(&case.pressure.pressure_errors),
            worst(&case.pressure.residuals),
            case.pressure.pressure_errors.len(),
        );
    }
    text
}

/// A step of ours phase by phase, beside the least that the machine needs for it.
fn phases(contest: &Contest, results: &Results, case: &coupled::Case) -> String {
    let Some(side) = case.ours.iter().find(|side| side.way == Way::InTurn) else {
        return String::new();
    };
    let mut text = format!(
        "\n### {} spheres, phase by phase\n\n| phase | least work | at the machine's limit, ms | \
         taken, ms | share of the limit reached |\n|:--|:--|--:|--:|--:|\n",
        count(case.spheres as u64)
    );
    let works = model::phases(case, side, model::entry(contest.ours));
    for ((name, work), taken) in PHASES.iter().zip(works).zip(&side.phases_s) {
        let floor = work.floor(&results.limits[0]);
        text += &format!(
            "| {} | {} | {} | {} | {:.0} % |\n",
            name.replace('_', " "),
            work.words,
            three_digits(1e3 * floor),
            three_digits(1e3 * taken),
            100.0 * floor / taken,
        );
    }
    for (name, taken) in REMESH.iter().zip(&side.remesh_s) {
        text += &format!("| a remesh: {name} | | | {} | |\n", three_digits(1e3 * taken));
    }
    text
}

fn network(results: &Results) -> String {
    let mut text =
        "\n## The network\n\nFrom positions and radii to pores, throats and conductances; \
                    and with the operators G, E, F. The first build of each process is not \
                    counted. YADE: what a remesh takes beside its factorization.\n\n| spheres | \
                    pores | triangulation, pores, throats, ms | all, ms | YADE, ms |\n\
                    |--:|--:|--:|--:|--:|\n"
            .to_owned();
    for case in &results.network {
        let yade = results.coupled.iter().find(|c| c.spheres == case.spheres);
        text += &format!(
            "| {} | {} | {} | {} | {} |\n",
            count(case.spheres as u64),
            count(case.pores as u64),
            case.network_s.show(1e-3),
            case.all_s.show(1e-3),
            yade.map_or("–".to_owned(), |c| c.yade_network_s.show(1e-3)),
        );
    }
    text
}

fn linear(results: &Results) -> String {
    let limits = &results.limits[0];
    let mut text = "\n## The linear systems\n\nMatrices of real networks, without any clamp. Each \
                    solver in a process of its own, by turns. The solution is known: that of spheres \
                    that move towards the drained top, or for the largest a smooth field; the \
                    right-hand side was multiplied out in twice the working precision. Residual: \
                    |b − A x|∞/(|A|∞ |x|∞ + |b|∞), and beside it |b − A x|₂/|b|₂, summed up in twice \
                    the working precision by the same code for all. Error: the largest over the largest pressure. Memory: the most that the \
                    process held beyond the system that it had read.\n"
        .to_owned();
    for case in &results.linear {
        let unknowns = case.unknowns as f64;
        text += &format!(
            "\n### {} unknowns\n\n{} spheres ({}), {} entries on and below the diagonal.\n\n| solver \
             | ordering | ordering and analysis, s | factorization, s | solve, ms | nnz(L) | memory \
             | B an unknown | residual | over b | error |\n|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
            count(case.unknowns as u64),
            count(case.spheres as u64),
            case.origin,
            count(case.entries as u64),
        );
        for side in &case.sides {
            text += &format!(
                "| {} | {} | {} | {} | {} | {:.3e} | {} | {} | {:.1e} | {:.1e} | {:.1e} |\n",
                side.name,
                side.ordering,
                side.analyze_s.show(1.0),
                side.factor_s.show(1.0),
                side.solve_s.show(1e-3),
                side.nnz_l,
                bytes(side.taken()),
                three_digits(side.taken() / unknowns),
                side.errors.residual,
                side.errors.missing,
                side.errors.forward,
            );
        }
        text.push('\n');
        for failed in &case.failed {
            text += &format!("**Failed:** {failed}.\n\n");
        }
        for side in case.sides.iter().filter(|side| side.flops.is_some()) {
            let flops = side.flops.unwrap_or(f64::NAN);
            text += &format!(
                "{}: {:.2e} operations take the machine {} s in double and {} s in single precision \
                 at least, {:.0} and {:.0} % of what was taken; its factor has room for {}: all of \
                 it would be read twice in {} ms, {:.0} % of a solve.\n\n",
                side.name,
                flops,
                three_digits(flops / limits.double[1]),
                three_digits(flops / limits.single[1]),
                100.0 * flops / limits.double[1] / side.factor_s.median(),
                100.0 * flops / limits.single[1] / side.factor_s.median(),
                bytes(side.factor_bytes),
                three_digits(2e3 * side.factor_bytes / limits.bandwidth[1]),
                200.0 * side.factor_bytes / limits.bandwidth[1] / side.solve_s.median(),
            );
        }
    }
    text
}

fn inside(results: &Results) -> String {
    let mut text = "\n## A solve in the time loop\n\nThe coupled specimen with one solver and the \
                    other, by turns, between remeshes; the first ten steps are not counted. A solve \
                    is all between the rates of volume and the pressures: right-hand side, \
                    prediction, refinement. Tolerance: what the scene says a solve may leave, of \
                    fluid mass and of the estimated error. With all digits ours asks for less than the \
                    default, so that the residual is what CHOLMOD leaves: where that takes a third \
                    correction now and then, the mean tells. CHOLMOD's solve \
                    uses one thread of the BLAS here. A plain solve of CHOLMOD, which the contest \
                    also counts if it is faster, has the residual “over b” of the tables above.\n\n| spheres | unknowns | solver | tolerance | \
                    ms a solve | mean | residual | largest error of a pressure |\n\
                    |--:|--:|:--|--:|--:|--:|--:|--:|\n"
        .to_owned();
    for case in &results.inside {
        for side in &case.sides {
            text += &format!(
                "| {} | {} | {} | {} | {} | {} | {:.1e} | {:.1e} |\n",
                count(case.spheres as u64),
                count(side.unknowns as u64),
                side.solver,
                side.tolerance().unwrap_or("1e-11, the default"),
                side.solve_s.show(1e-3),
                three_digits(1e3 * side.solve_s.mean()),
                side.residual,
                side.pressure_error,
            );
        }
    }
    text
}
