//! Figures 5 and 8: what a step costs with and without the accelerations.

use std::path::Path;

use dempfv_report::format::{bytes, count, three_digits};
use dempfv_report::markdown::{self, cell};
use dempfv_report::plot::Axis;

use super::build::{device_table, unknowns};
use super::{UNKNOWNS, by_device};
use crate::Error;
use crate::paper::draw::{self, Curve};
use crate::paper::measured::{Measured, Row};
use crate::paper::timing::{INTERVAL, Mode, STEPS, Timing};

/// The paper's 600 steps of one specimen.
#[derive(Clone, Copy)]
pub struct Acceleration {
    /// Without any acceleration (s): 600 remeshes and 600 steps on one core, composed of
    /// what each takes.
    pub composed: f64,
    /// The part of it that is analysis (s): as if no pattern were ever the last one's.
    pub analyses: f64,
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

    /// The same if the composed run found each pattern unchanged and never analyzed (1).
    pub fn factor_without_analyses(&self) -> f64 {
        (self.composed - self.analyses) / self.accelerated
    }
}

/// Figure 5 of one specimen; `None` unless it was measured.
pub fn acceleration(row: &Row) -> Option<Acceleration> {
    let accelerated = row.timing(Mode::Accelerated)?.number("wall_s");
    let measured = row.timing(Mode::Plain).map(|t| t.number("wall_s"));
    let analyses = STEPS as f64 * row.timing(Mode::OneCore)?.per_remesh("analyze");
    Some(Acceleration { composed: composed(row)?, analyses, measured, accelerated })
}

fn composed(row: &Row) -> Option<f64> {
    composed_of(row.timing(Mode::OneCore)?)
}

/// So many remeshes and steps, from what one of each takes in a run.
pub fn composed_of(one: &Timing) -> Option<f64> {
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
        "{STEPS} steps. Without acceleration: one core, and a remesh at every step. With all of \
         them but the GPU: {}, a factor that serves {INTERVAL} steps, the next one made in the \
         background, and the fluid's tasks beside the contacts. A composed total is {STEPS} times \
         what one remesh and one step take, both timed on one core; it stands in for runs that \
         would take long. It has an analysis in every step. A run that is made has fewer: while the \
         pattern of the matrix stays the last step's, as it mostly does in a small packing, the \
         last analysis serves again, which cannot be switched off. The truth of a large packing \
         lies between the composed total and that without its analyses.\n\n",
        measured.all_cores()
    );
    text += &draw::save(folder, "fig-5", title, &picture)?;
    let rows = measured.rows.iter().map(|row| {
        let a = acceleration(row);
        vec![
            row.name(),
            unknowns(row),
            cell(composed(row), show),
            cell(a, |a| show(a.analyses)),
            cell(row.timing(Mode::Plain), |t| show(t.number("wall_s"))),
            cell(row.timing(Mode::Plain), |t| format!("{:.0}", t.analyses())),
            cell(row.timing(Mode::Cholmod).and_then(composed_of), show),
            cell(row.timing(Mode::Accelerated), |t| show(t.number("wall_s"))),
            cell(a, |a| three_digits(a.factor())),
            cell(row.timing(Mode::Accelerated), |t| bytes(t.number("peak_memory_bytes"))),
        ]
    });
    let header = [
        "spheres",
        "unknowns",
        "none, composed (s)",
        "of it analyses (s)",
        "none, measured (s)",
        "analyses in it",
        "none with CHOLMOD, composed (s)",
        "all but the GPU (s)",
        "faster by",
        "its peak memory",
    ];
    text += &markdown::table(&header, rows);
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
    text += "An iteration is a step between two remeshes, timed after one remesh. The remesh \
             interval of eq. 15 is 2 t_bg v_iter, with t_bg the time of a remesh and v_iter the \
             steps per second of the same runs: a background that begins at half the interval is \
             then ready at its end, if both had the machine to themselves. The Cundall number is \
             particles times steps per second. The last column is the run of Figure 5, all of its \
             time over all of its steps.\n\n";
    text += &Part { file: "fig-8a", title: "Time per iteration", unit: "Time (ms)" }.write(
        measured,
        folder,
        |t| 1e3 * t.step(),
        Some(|t| 1e3 * t.wall_per_step()),
    )?;
    text += &Part { file: "fig-8b", title: "Remesh interval of eq. 15", unit: "Steps" }
        .write(measured, folder, interval, None)?;
    text += &Part { file: "fig-8c", title: "Cundall number", unit: "Particle steps per second" }
        .write(
            measured,
            folder,
            |t| cundall(t, t.step()),
            Some(|t| cundall(t, t.wall_per_step())),
        )?;
    Ok(text)
}

fn cundall(timing: &Timing, step: f64) -> f64 {
    timing.number("particles") / step
}

/// A part of Figure 8.
struct Part {
    file: &'static str,
    title: &'static str,
    unit: &'static str,
}

impl Part {
    /// Picture and table of a value by device, and of another of the accelerated run.
    fn write(
        &self,
        measured: &Measured,
        folder: &Path,
        value: fn(&Timing) -> f64,
        accelerated: Option<fn(&Timing) -> f64>,
    ) -> Result<String, Error> {
        let name = "all but the GPU, with remeshes";
        let mut curves = by_device(measured, value);
        if let Some(value) = accelerated {
            let of = move |row: &Row| row.timing(Mode::Accelerated).map(value);
            curves.push(Curve::new(name, measured.over_unknowns(of)));
        }
        let (x, y) = (Axis::log(UNKNOWNS), Axis::log(self.unit));
        let picture = draw::draw(self.title, "", x, y, &curves);
        let mut text = draw::save(folder, self.file, self.title, &picture)?;
        let further = |row: &Row| {
            cell(row.timing(Mode::Accelerated).zip(accelerated), |(t, value)| show(value(t)))
        };
        let further = accelerated.map(|_| (name, &further as &dyn Fn(&Row) -> String));
        text += &format!("{} ({}):\n\n", self.title, self.unit.to_lowercase());
        text += &device_table(measured, |t| show(value(t)), further);
        Ok(text)
    }
}

/// Three digits; thousands apart where there are more before the point.
pub fn show(value: f64) -> String {
    if value < 1e3 { three_digits(value) } else { count(value as u64) }
}
