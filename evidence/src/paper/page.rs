//! The page: what was measured, on what, beside what the paper says.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use dempfv::io::atomic;
use dempfv::solver::{FRONTAL_FROM, SolverKind};
use dempfv_report::format::count;
use dempfv_report::{machine, versions};

use super::draw::FOLDER;
use super::figures::Figure;
use super::machine::Machine;
use super::measured::Measured;
use super::timing::{self, Mode};
use super::{claims, raw};
use crate::Error;

/// Cores that other programs may keep busy for times to count as undisturbed.
const DISTURBED: f64 = 0.2;

/// Writes the page with its figures and the raw timings; returns where it is.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    folder: &Path,
    name: &str,
    measured: &Measured,
    machine: &Machine,
    left_out: &[String],
) -> Result<PathBuf, Error> {
    let figures = folder.join(FOLDER);
    std::fs::create_dir_all(&figures).map_err(|e| dempfv::Error::io(&figures, e))?;
    let mut text = head(measured, machine);
    text += &gpus(measured);
    text += &disturbed(measured);
    text += &claims::section(measured);
    for figure in Figure::ALL {
        text += &figure.section(measured, folder)?;
    }
    text += &format!(
        "## Raw timings\n\n[timings.csv]({FOLDER}/timings.csv) has every run: the seven timings of \
         section 5.3 (allocate, build, analyze, factor, solve, volumes, forces) and the rest of a \
         step, in seconds.\n"
    );
    if !left_out.is_empty() {
        text += &format!("\nNot measured on this machine: {}.\n", left_out.join("; "));
    }
    atomic::write(&figures.join("timings.csv"), raw::csv(measured).as_bytes())?;
    let path = folder.join(name);
    atomic::write(&path, text.as_bytes())?;
    Ok(path)
}

fn head(measured: &Measured, machine: &Machine) -> String {
    let versions = versions::all();
    let of = |name| versions.get(name).map_or("unknown", String::as_str);
    let blas = versions::blas_with_kernels();
    format!(
        "# The paper's accelerations, measured\n\n\
         `dempfv paper` wrote this page and its figures on {}, and `make paper` writes them anew. \
         The figures have the numbers of Caulk, Catalano and Chareyre (2020). The specimens are \
         cubes of spheres that have settled at 1 kPa, with the paper's load, time step (1 µs), \
         viscosity and drainage; the largest has as many unknown pressures as the paper's. The \
         solver is the default one, `{}`, where no other is named: CHOLMOD below {} unknowns, the \
         frontal solver from there on. The \
         paper's times are those of its own machines, so ratios compare and times do not.\n\n\
         Measured on {machine}. Machine: {}. dempfv {} ({}), CHOLMOD {} (SuiteSparse {}), METIS \
         {}, CGAL {}, {blas}, rustc {}. Times by the clock, of the fastest of three runs up to \
         40,000 spheres and of single runs above, on a machine whose speed drifts by tens of per \
         cent.\n\n",
        machine::today(),
        SolverKind::default(),
        count(FRONTAL_FROM as u64),
        machine::description(),
        of("dempfv"),
        revisions(measured),
        of("cholmod"),
        of("suitesparse"),
        of("metis"),
        of("cgal"),
        of("rustc"),
    )
}

/// Says where the GPU columns come from.
fn gpus(measured: &Measured) -> String {
    let mut found: Vec<_> = measured.rows.iter().flat_map(|row| &row.gpu).collect();
    found.sort_by_key(|on| &on.name);
    found.dedup_by_key(|on| &on.name);
    let lines = found.into_iter().map(|on| {
        format!(
            "Columns \"{}\" may be of another machine than the rest of their tables: {} ({} cores \
             used), measured on {}. The claims below compare them with cores of that machine.\n\n",
            on.name, on.machine, on.threads, on.day
        )
    });
    lines.collect()
}

/// Says which runs had to share the machine.
fn disturbed(measured: &Measured) -> String {
    let runs = measured.rows.iter().chain(&measured.alone).flat_map(|row| {
        let busy = |mode| row.timing(mode).and_then(|t| t.busy_cores());
        Mode::ALL.map(|mode| Some((timing::name(&row.specimen, mode), busy(mode)?)))
    });
    let shared: Vec<String> = runs
        .flatten()
        .filter(|(_, busy)| *busy > DISTURBED)
        .map(|(name, busy)| format!("{name} ({busy:.1})"))
        .collect();
    match shared.is_empty() {
        true => String::new(),
        false => format!(
            "**Not at rest:** other programs kept cores busy just before these runs, whose times \
             are too long: {}.\n\n",
            shared.join(", ")
        ),
    }
}

/// Revisions of this program that the measurements were made with.
fn revisions(measured: &Measured) -> String {
    let runs = measured.rows.iter().flat_map(|row| Mode::ALL.map(|mode| row.timing(mode)));
    let of_runs = runs.flatten().filter_map(|timing| timing.versions().remove("git"));
    let ends = measured.remesh.iter().flat_map(|r| &r.intervals).map(|end| end.git.clone());
    let found: BTreeSet<String> = of_runs.chain(ends).collect();
    match found.len() {
        0 => format!("revision {}", versions::GIT),
        1 => format!("revision {}", found.into_iter().collect::<String>()),
        _ => format!("revisions {}", found.into_iter().collect::<Vec<_>>().join(", ")),
    }
}
