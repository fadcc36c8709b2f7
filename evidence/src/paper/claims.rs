//! The claims of the paper's summary beside ours.

use dempfv_report::format::three_digits;
use dempfv_report::markdown::{NOTHING, table};

use super::figures::{acceleration, composed_of, gain, interval};
use super::gpu::OnGpu;
use super::measured::Measured;
use super::timing::{Mode, Timing};

/// Number of unknowns of the paper's largest specimen.
const LARGEST: f64 = 2.0e6;

/// A claim, what was measured here, and why that is not the same.
struct Claim {
    theirs: &'static str,
    ours: Option<String>,
    why: String,
}

/// Every claim beside ours, as a table.
pub fn section(measured: &Measured) -> String {
    let rows = claims(measured)
        .into_iter()
        .map(|c| vec![c.theirs.to_owned(), c.ours.unwrap_or_else(|| NOTHING.to_owned()), c.why]);
    let mut text = "## The claims of the paper's summary, and ours\n\n".to_owned();
    text += &table(&["the paper", "ours", "where ours differs"], rows).replacen(
        "---:|---:",
        "---|---",
        1,
    );
    text
}

fn claims(measured: &Measured) -> Vec<Claim> {
    vec![
        in_all(measured),
        saved(measured, "The GPU takes 75 % off the factorization at 2.1 million unknowns", |t| {
            t.per_remesh("factor")
        }),
        saved(
            measured,
            "The GPU takes 50 % off the time of the background at 2.1 million unknowns",
            |t| t.remesh(),
        ),
        pays(measured),
        saved(measured, "The GPU makes λ_rm 42 % better", interval),
        tasks(measured),
        build(measured),
    ]
}

fn in_all(measured: &Measured) -> Claim {
    let found = measured.largest(acceleration);
    let ours = found.as_ref().map(|(row, a)| {
        let besides = match a.measured {
            Some(_) => String::new(),
            None => format!(
                " (composed; {}x if no step needs an analysis)",
                three_digits(a.factor_without_analyses())
            ),
        };
        let theirs =
            row.timing(Mode::Cholmod).and_then(composed_of).map(|none| none / a.accelerated);
        let theirs = theirs.map_or(String::new(), |times| {
            format!(
                "; {}x against no acceleration with CHOLMOD, the paper's solver",
                three_digits(times)
            )
        });
        format!("{}x at {}{besides}{theirs}", three_digits(a.factor()), unknowns(row.unknowns()))
    });
    let why = "Ours has no GPU in it and its default solver on both sides, and compares with one \
               core that remeshes at every step (Figure 5): the ratio is that of a remesh to a step, so it grows with the size, and \
               it is the smaller the faster the remesh was before.";
    Claim { theirs: "170x faster in all, at 2.1 million unknowns", ours, why: why.to_owned() }
}

/// What stands where no GPU was measured.
fn no_gpu(theirs: &'static str) -> Claim {
    let why = "No machine with a GPU was at hand: not measured.".to_owned();
    Claim { theirs, ours: None, why }
}

/// How much less something is with a GPU than on one core of the same machine, at the
/// largest size.
fn saved(measured: &Measured, theirs: &'static str, value: fn(&Timing) -> f64) -> Claim {
    let Some((row, on)) = measured.largest(|row| row.gpu.first().cloned()) else {
        return no_gpu(theirs);
    };
    let less = 1.0 - value(&on.with_gpu) / value(&on.one_core);
    let change = if less < 0.0 { "more" } else { "less" };
    let percent = 100.0 * less.abs();
    let ours = format!("{percent:.0} % {change} at {} ({})", unknowns(row.unknowns()), on.name);
    let why = format!(
        "CHOLMOD, beside one core of {}; the GPU did {:.0} % of the operations, ordering and network are \
         the CPU's.",
        on.machine,
        100.0 * on.with_gpu.gpu_share().min(1.0)
    );
    Claim { theirs, ours: Some(ours), why }
}

/// From which size on the factorization is faster with a GPU than on one core, and than on
/// all cores.
fn pays(measured: &Measured) -> Claim {
    let theirs = "The GPU pays from 30,000 spheres on";
    let rows: Vec<_> =
        measured.rows.iter().filter_map(|row| Some((row, row.gpu.first()?))).collect();
    let Some((_, last)) = rows.last() else { return no_gpu(theirs) };
    let from = |other: fn(&OnGpu) -> f64| {
        let slower = rows.iter().rposition(|(_, on)| on.with_gpu.per_remesh("factor") >= other(on));
        let first = rows.get(slower.map_or(0, |k| k + 1));
        first.map_or("at no size".to_owned(), |(row, _)| format!("from {} spheres on", row.name()))
    };
    let ours = format!(
        "{} beside one core, {} beside {} cores ({})",
        from(|on| on.one_core.per_remesh("factor")),
        from(|on| on.all_cores.factor_s),
        last.threads,
        last.name
    );
    let why = "Sizes that were measured; smaller supernodes stay on the CPU.".to_owned();
    Claim { theirs, ours: Some(ours), why }
}

fn tasks(measured: &Measured) -> Claim {
    let gains = || measured.rows.iter().filter_map(|row| Some((gain(row)?, row)));
    let best = gains().max_by(|a, b| a.0.total_cmp(&b.0));
    let ours = best.zip(measured.largest(gain)).map(|((best, at), (row, last))| {
        format!(
            "{}x at best ({}), {}x at {}",
            three_digits(best),
            unknowns(at.unknowns()),
            three_digits(last),
            unknowns(row.unknowns())
        )
    });
    let why = "Our contacts take a smaller share of a step than YADE's, and use every core \
               already: there is little to hide behind the solve (Figure 9: at most).";
    Claim { theirs: "Parallel tasks: 1.2x, or 30 %", ours, why: why.to_owned() }
}

fn build(measured: &Measured) -> Claim {
    let found = measured.largest(|row| row.timing(Mode::AllCores).map(|t| t.remesh()));
    let ours = found.as_ref().map(|(row, time)| {
        // Shares out its work only where bits may differ.
        let shared = row.timing(Mode::AllCores).zip(row.factored).map(|(t, f)| {
            let time = t.per_remesh("network") + f.analyze_s + f.factor_s;
            format!("; {} s with CHOLMOD and its BLAS on all of them", three_digits(time))
        });
        let (size, cores) = (unknowns(row.unknowns()), measured.all_cores());
        let shared = shared.unwrap_or_default();
        format!("{} s at {size} on {cores}{shared}", three_digits(*time))
    });
    let why = match found {
        Some((row, _)) if row.unknowns().is_none_or(|n| n < LARGEST) => {
            "Not the paper's size: the largest specimen was not run.".to_owned()
        }
        Some((_, time)) if time <= 140.0 => String::new(),
        _ => "The paper's machine had more cores.".to_owned(),
    };
    let theirs = "At most 140 s to build, analyze and factor 2.1 million unknowns";
    Claim { theirs, ours, why }
}

fn unknowns(n: Option<f64>) -> String {
    match n {
        Some(n) if n >= 1e6 => format!("{:.2} million unknowns", n * 1e-6),
        Some(n) => format!("{} unknowns", dempfv_report::format::count(n as u64)),
        None => String::new(),
    }
}
