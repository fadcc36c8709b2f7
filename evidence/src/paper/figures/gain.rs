//! Figure 9: what the parallel tasks gain.

use std::path::Path;

use dempfv_report::format::{si, three_digits};
use dempfv_report::markdown::{self, cell};
use dempfv_report::plot::Axis;

use super::UNKNOWNS;
use super::build::unknowns;
use crate::Error;
use crate::paper::draw::{self, Curve};
use crate::paper::measured::{Measured, Row};
use crate::paper::timing::Mode;

/// How many times faster a step is with the fluid's tasks beside the contacts (1).
pub fn gain(row: &Row) -> Option<f64> {
    Some(sequential(row)? / row.timing(Mode::Tasks)?.step())
}

/// Time of a step with one task after the other (s); by turns with the parallel ones where
/// runs were repeated.
fn sequential(row: &Row) -> Option<f64> {
    let by_turns = row.timing(Mode::Tasks).and_then(|t| t.step_without_tasks());
    by_turns.or_else(|| row.timing(Mode::AllCores).map(|t| t.step()))
}

/// The most that it can be: the contacts, or the fluid, cost nothing (1).
fn most(row: &Row) -> Option<f64> {
    let timing = row.timing(Mode::AllCores)?;
    let fluid: f64 =
        ["volume_rates", "solve", "fluid_forces"].map(|p| timing.per_step(p)).iter().sum();
    let contacts = timing.per_step("contacts");
    Some(timing.step() / (timing.step() - fluid.min(contacts)))
}

pub fn section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let title = "Gain of the parallel tasks";
    let curves = [
        Curve::new("measured", measured.over_unknowns(gain)),
        Curve::new("if the shorter branch cost nothing", measured.over_unknowns(most)),
    ];
    let y = Axis::linear("Step without / step with (1)");
    let picture = draw::draw(title, "", Axis::log(UNKNOWNS), y, &curves);
    let mut text = "## Figure 9: parallel tasks\n\n".to_owned();
    text += &format!(
        "Volumes, solve and fluid forces run beside the contacts and are joined before the \
         integration; on {}. Contacts use all cores even without that, so what is left to gain is \
         the time that they take, less what they lose to the branch beside them. Results are the \
         same bits. Where runs are repeated, both kinds take turns.\n\n",
        measured.all_cores()
    );
    text += &draw::save(folder, "fig-9", title, &picture)?;
    let rows = measured.rows.iter().map(|row| {
        vec![
            row.name(),
            unknowns(row),
            cell(sequential(row), |time| si(time, "s")),
            cell(row.timing(Mode::Tasks), |t| si(t.step(), "s")),
            cell(gain(row), three_digits),
            cell(most(row), three_digits),
        ]
    });
    let header = [
        "spheres",
        "unknowns",
        "step, one after the other",
        "step, side by side",
        "gain",
        "at most",
    ];
    text += &markdown::table(&header, rows);
    Ok(text)
}
