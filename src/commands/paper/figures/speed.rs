//! Figures 5 and 8: what a step costs with and without the accelerations.

use std::path::Path;

use super::build::{device_table, unknowns};
use super::{UNKNOWNS, by_device};
use crate::commands::Error;
use crate::commands::format::{duration, three_digits};
use crate::commands::paper::draw::{self, Curve, cell};
use crate::commands::paper::measured::{Measured, Row};
use crate::commands::paper::timing::{INTERVAL, Mode, STEPS, Timing};
use crate::report::plot::Axis;

/// The paper's 600 steps of one specimen.
#[derive(Clone, Copy)]
pub struct Acceleration {
    /// Without any acceleration (s): 600 remeshes and 600 steps on one core, composed of
    /// what each takes.
    pub composed: f64,
    /// The same where it was run through (s).
    pub measured: Option<f64>,
    /// With all accelerations (s).
    pub accelerated: f64,
}

impl Acceleration {
    /// How many times faster the accelerations are (1).
    pub fn factor(&self) -> f64 {
        self.measured.unwrap_or(self.composed) / self.accelerated
    }
}

/// Figure 5 of one specimen; `None` unless it was measured.
pub fn acceleration(row: &Row) -> Option<Acceleration> {
    let accelerated = row.timing(Mode::Accelerated)?.number("wall_s");
    let measured = row.timing(Mode::Plain).map(|t| t.number("wall_s"));
    Some(Acceleration { composed: composed(row)?, measured, accelerated })
}

fn composed(row: &Row) -> Option<f64> {
    let one = row.timing(Mode::OneCore)?;
    Some(STEPS as f64 * (one.remesh() + one.step()))
}

/// Figure 5: none against all.
pub fn acceleration_section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let title = "No acceleration against all of them";
    let none = measured.over_unknowns(|row| {
        row.timing(Mode::Plain).map(|t| t.number("wall_s")).or_else(|| composed(row))
    });
    let all = measured.over_unknowns(|row| Some(row.timing(Mode::Accelerated)?.number("wall_s")));
    let curves = [
        Curve::new("no acceleration, 1 core", none),
        Curve::new(format!("all but the GPU, {}", measured.all_cores()), all),
    ];
    let y = Axis::log("Wall time of 600 steps (s)");
    let picture = draw::draw(title, "", Axis::log(UNKNOWNS), y, &curves);
    let mut text = "## Figure 5: none against all\n\n".to_owned();
    text += &format!(
        "{STEPS} steps. Without acceleration: one core, and a remesh, with its analysis and its \
         factorization, at every step. With all of them but the GPU: {}, a factor that serves \
         {INTERVAL} steps, the next one made in the background, and the fluid's tasks beside the \
         contacts. Where a run without acceleration would take long, its total is composed: {STEPS} \
         times what one remesh and one step take, both timed on one core.\n\n",
        measured.all_cores()
    );
    text += &draw::save(folder, "fig-5", title, &picture)?;
    let rows = measured.rows.iter().map(|row| {
        let a = acceleration(row);
        vec![
            row.name(),
            unknowns(row),
            cell(composed(row), duration),
            cell(row.timing(Mode::Plain), |t| duration(t.number("wall_s"))),
            cell(row.timing(Mode::Accelerated), |t| duration(t.number("wall_s"))),
            cell(a, |a| three_digits(a.factor())),
            cell(row.timing(Mode::Accelerated), |t| {
                format!("{:.1} GB", t.number("peak_memory_bytes") * 1e-9)
            }),
        ]
    });
    let header = [
        "spheres",
        "unknowns",
        "none, composed",
        "none, measured",
        "all but the GPU",
        "faster by",
        "its peak memory",
    ];
    text += &draw::table(&header, rows);
    Ok(text)
}

/// Remesh interval of eq. 15 of the paper, λ_rm = 2 t_bg v_iter (steps): a background that
/// starts at half the interval is ready at its end.
pub fn interval(timing: &Timing) -> f64 {
    2.0 * timing.remesh() / timing.step()
}

/// Figure 8: time per iteration, remesh interval of eq. 15, Cundall number.
pub fn section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let mut text = "## Figure 8: speed\n\n".to_owned();
    text += "An iteration is a step between two remeshes, as timed after one remesh on an \
             otherwise idle machine. The remesh interval of eq. 15 is 2 t_bg v_iter, with t_bg the \
             time of a remesh and v_iter the steps per second on the same device: a background \
             that begins at half the interval is then ready at its end. The Cundall number is \
             particles times steps per second.\n\n";
    let accelerated = Curve::new(
        "all but the GPU, remeshes included",
        measured.over_unknowns(|row| Some(row.timing(Mode::Accelerated)?.wall_per_step())),
    );
    let mut curves = by_device(measured, Timing::step);
    curves.push(accelerated);
    text += &part(
        measured,
        folder,
        ("fig-8a", "Time per iteration", "Time (s)"),
        curves,
        Timing::step,
    )?;
    let curves = by_device(measured, interval);
    let names = ("fig-8b", "Remesh interval of eq. 15", "Steps");
    text += &part(measured, folder, names, curves, interval)?;
    let cundall = |t: &Timing| t.number("particles") / t.step();
    let accelerated = Curve::new(
        "all but the GPU, remeshes included",
        measured.over_unknowns(|row| {
            let timing = row.timing(Mode::Accelerated)?;
            Some(timing.number("particles") / timing.wall_per_step())
        }),
    );
    let mut curves = by_device(measured, cundall);
    curves.push(accelerated);
    let names = ("fig-8c", "Cundall number", "Particles × steps per second (1/s)");
    text += &part(measured, folder, names, curves, cundall)?;
    Ok(text)
}

fn part(
    measured: &Measured,
    folder: &Path,
    (file, title, unit): (&str, &str, &str),
    curves: Vec<Curve>,
    value: impl Fn(&Timing) -> f64,
) -> Result<String, Error> {
    let picture = draw::draw(title, "", Axis::log(UNKNOWNS), Axis::log(unit), &curves);
    let mut text = draw::save(folder, file, title, &picture)?;
    text += &format!("{title}:\n\n{}", device_table(measured, value));
    Ok(text)
}
