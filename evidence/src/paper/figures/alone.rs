//! Each acceleration on its own.

use dempfv_report::format::three_digits;
use dempfv_report::markdown::{self, cell};

use super::speed::show;
use crate::paper::measured::{Measured, Row};
use crate::paper::specimens::ALONE;
use crate::paper::timing::{INTERVAL, Mode, STEPS};

/// Wall time of the paper's steps (s), where it was measured.
type Total = fn(&Row) -> Option<f64>;

/// What each acceleration does to the time of 600 steps.
pub fn section(measured: &Measured) -> String {
    let all = measured.all_cores();
    let rows: [(String, Total); 9] = [
        ("none, 1 core (composed)".to_owned(), |row| composed(row, Mode::OneCore, Mode::OneCore)),
        ("none, 1 core, analyses only where the pattern changed".to_owned(), |row| {
            through(row, Mode::Plain)
        }),
        (format!("none, {all} (composed)"), |row| composed(row, Mode::AllCores, Mode::AllCores)),
        (format!("parallel tasks alone, {all} (composed)"), |row| {
            composed(row, Mode::AllCores, Mode::Tasks)
        }),
        ("factor reuse alone, 1 core".to_owned(), |row| through(row, Mode::Reuse)),
        (format!("factor reuse and background, {all}"), |row| through(row, Mode::Background)),
        (format!("all together, {all}"), |row| through(row, Mode::Accelerated)),
        ("none, CHOLMOD, 1 core (composed)".to_owned(), |row| {
            composed(row, Mode::Cholmod, Mode::Cholmod)
        }),
        (format!("all together, CHOLMOD, {all}"), |row| through(row, Mode::AcceleratedCholmod)),
    ];
    let specimens: Vec<&Row> = ALONE.iter().filter_map(|&spheres| measured.row(spheres)).collect();
    let mut header = vec![format!("{STEPS} steps")];
    for row in &specimens {
        header.extend([format!("{} spheres (s)", row.name()), "faster by".to_owned()]);
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let none = rows[0].1;
    let rows = rows.iter().map(|(name, total)| {
        let cells = specimens.iter().flat_map(|row| {
            let gain = none(row).zip(total(row)).map(|(none, total)| none / total);
            [cell(total(row), show), cell(gain, three_digits)]
        });
        [name.clone()].into_iter().chain(cells).collect()
    });
    let mut text = "### Each on its own\n\n".to_owned();
    text += &format!(
        "A background needs an old factor to go on with, so it comes on top of the reuse. With \
         reuse, a factor serves {INTERVAL} steps. Composed totals have an analysis in every step; see \
         Figure 5. 30,000 spheres are 1 × 2 × 3 copies of 5,000.\n\n"
    );
    text += &markdown::table(&header, rows);
    for row in &specimens {
        text += &same_bits(row);
    }
    text
}

/// Whether all accelerations together end where the plain path ends.
fn same_bits(row: &Row) -> String {
    let hash = |mode| row.timing(mode).map(|t| t.text("state_hash").to_owned());
    let (Some(all), Some(plain)) = (hash(Mode::Accelerated), hash(Mode::Ahead)) else {
        return String::new();
    };
    let name = row.name();
    match all == plain {
        true => format!(
            "With {name} spheres, all together end in the same bits of every position, velocity and \
             pressure (`{all}`) as the plain path with the same swap points: one core, one task \
             after another, each network built while the time loop waits.\n\n"
        ),
        false => format!(
            "With {name} spheres, all together end in other bits than the plain path, which they \
             must not: see the raw timings.\n\n"
        ),
    }
}

/// So many remeshes and steps, from what one of each takes.
fn composed(row: &Row, remesh: Mode, step: Mode) -> Option<f64> {
    Some(STEPS as f64 * (row.timing(remesh)?.remesh() + row.timing(step)?.step()))
}

/// A run from its first step to its last.
fn through(row: &Row, mode: Mode) -> Option<f64> {
    row.timing(mode).map(|t| t.number("wall_s"))
}
