//! Figure 10: solve, volumes, forces.

use std::path::Path;

use dempfv_report::format::three_digits;
use dempfv_report::plot::Axis;

use super::build::device_table;
use super::{UNKNOWNS, by_device};
use crate::Error;
use crate::paper::draw;
use crate::paper::measured::Measured;
use crate::paper::timing::Timing;

pub fn section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let mut text = "## Figure 10: solve, volumes, forces\n\n".to_owned();
    text += "Means over the steps after one remesh. The first steps after a remesh solve \
             twice, and the first of all once more for the wall's resistance. CHOLMOD solves on \
             one core.\n\n";
    for (phase, file, title) in [
        ("solve", "fig-10a", "Solve"),
        ("volume_rates", "fig-10b", "Volumes"),
        ("fluid_forces", "fig-10c", "Fluid forces"),
    ] {
        let milliseconds = |t: &Timing| 1e3 * t.per_step(phase);
        let curves = by_device(measured, milliseconds);
        let picture = draw::draw(title, "", Axis::log(UNKNOWNS), Axis::log("Time (ms)"), &curves);
        text += &draw::save(folder, file, title, &picture)?;
        text += &format!(
            "{title} (ms):\n\n{}",
            device_table(measured, |t| three_digits(milliseconds(t)), None)
        );
    }
    Ok(text)
}
