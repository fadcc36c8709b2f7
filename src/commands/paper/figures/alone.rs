//! Each acceleration on its own.

use super::speed::show;
use crate::commands::format::three_digits;
use crate::commands::paper::draw::{self, cell};
use crate::commands::paper::measured::{Measured, Row};
use crate::commands::paper::specimens::ALONE;
use crate::commands::paper::timing::{INTERVAL, Mode, STEPS};

/// Wall time of the paper's steps (s), where it was measured.
type Total = fn(&Row) -> Option<f64>;

/// What each acceleration does to the time of 600 steps.
pub fn section(measured: &Measured) -> String {
    let all = measured.all_cores();
    let rows: [(String, Total); 6] = [
        ("none, 1 core (composed)".to_owned(), |row| composed(row, Mode::OneCore, Mode::OneCore)),
        (format!("none, {all} (composed)"), |row| composed(row, Mode::AllCores, Mode::AllCores)),
        (format!("parallel tasks alone, {all} (composed)"), |row| {
            composed(row, Mode::AllCores, Mode::Tasks)
        }),
        ("factor reuse alone, 1 core".to_owned(), |row| through(row, Mode::Reuse)),
        (format!("factor reuse and background, {all}"), |row| through(row, Mode::Background)),
        (format!("all together, {all}"), |row| through(row, Mode::Accelerated)),
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
         reuse, a factor serves {INTERVAL} steps. 30,000 spheres are 1 × 2 × 3 copies of 5,000.\n\n"
    );
    text + &draw::table(&header, rows)
}

/// So many remeshes and steps, from what one of each takes.
fn composed(row: &Row, remesh: Mode, step: Mode) -> Option<f64> {
    Some(STEPS as f64 * (row.timing(remesh)?.remesh() + row.timing(step)?.step()))
}

/// A run from its first step to its last.
fn through(row: &Row, mode: Mode) -> Option<f64> {
    row.timing(mode).map(|t| t.number("wall_s"))
}
