//! Figure 2: pressures against the remesh interval, their cost, and replicates.

use std::path::Path;

use dempfv_report::format::{duration, si};
use dempfv_report::markdown;
use dempfv_report::plot::Axis;

use crate::Error;
use crate::paper::draw::{self, Curve};
use crate::paper::measured::Measured;
use crate::paper::remesh::{LOAD, Remesh, SPECIMEN, STEPS};
use crate::paper::specimens::STRESS;
use crate::paper::timing::INTERVAL;

const INTERVAL_LABEL: &str = "Remesh interval (steps)";

pub fn section(measured: &Measured, folder: &Path) -> Result<String, Error> {
    let mut text = "## Figure 2: the remesh interval, and replicates\n\n".to_owned();
    let Some(remesh) = &measured.remesh else {
        return Ok(text + "Not measured yet.\n\n");
    };
    text += &format!(
        "{}, settled at {}, loaded at once with {} on its drained wall; {STEPS} steps of 1 µs. \
         Every interval divides {STEPS}: each network is at its oldest when the pressures are \
         compared. The pressure at a sphere is the mean of the pores around it, by volume. The \
         error is that of all spheres' pressures together (root of the sum of squares), relative \
         to a run that remeshes at every step; that one took {}.\n\n",
        SPECIMEN.origin(),
        si(STRESS, "Pa"),
        si(LOAD, "Pa"),
        remesh.reference().map_or(String::new(), |end| duration(end.wall_s)),
    );
    text += &pictures(remesh, folder)?;
    text += &table(remesh);
    text += &replicates(remesh, folder)?;
    Ok(text)
}

fn pictures(remesh: &Remesh, folder: &Path) -> Result<String, Error> {
    let ends = || remesh.intervals.iter();
    let pressure = Curve::new("", ends().map(|e| Some((e.interval as f64, e.at_bottom))));
    let title = "Pressure against the remesh interval";
    let caption = "At the middle of the sealed bottom, after 1200 steps";
    let (x, y) = (Axis::log(INTERVAL_LABEL), Axis::linear("Pressure (Pa)"));
    let picture = draw::draw(title, caption, x, y, &[pressure]);
    let mut text = draw::save(folder, "fig-2a", title, &picture)?;

    let cost = ends().filter(|e| e.interval > 1);
    let cost = Curve::new("", cost.map(|e| Some((e.wall_s, remesh.error(e)))));
    let title = "What an accurate pressure costs";
    let caption = "Nine remesh intervals, from 1200 steps (left) to 2 (right)";
    let (x, y) = (Axis::log("Wall time (s)"), Axis::log("Error of the pressures (1)"));
    let picture = draw::draw(title, caption, x, y, &[cost]);
    text += &draw::save(folder, "fig-2a-cost", title, &picture)?;
    Ok(text)
}

fn table(remesh: &Remesh) -> String {
    let rows = remesh.intervals.iter().map(|end| {
        let error =
            if end.interval == 1 { "0".to_owned() } else { format!("{:.1e}", remesh.error(end)) };
        vec![
            end.interval.to_string(),
            format!("{:.2}", end.at_bottom),
            error,
            format!("{:.2}", end.wall_s),
        ]
    });
    let header =
        ["remesh interval (steps)", "pressure (Pa)", "error of the field", "wall time (s)"];
    markdown::table(&header, rows)
}

fn replicates(remesh: &Remesh, folder: &Path) -> Result<String, Error> {
    let runs = remesh.replicates.iter().enumerate();
    let points = runs.map(|(k, end)| Some(((k + 1) as f64, end.at_bottom)));
    let title = "Replicates of one run";
    let caption = format!("Remesh every {INTERVAL} steps; odd ones on all cores, even ones on one");
    let (x, y) = (Axis::linear("Replicate"), Axis::linear("Pressure (Pa)"));
    let picture = draw::draw(title, &caption, x, y, &[Curve::new("", points)]);
    let mut text = draw::save(folder, "fig-2b", title, &picture)?;
    let first = remesh.replicates.first();
    let hash = first.map_or("", |end| &end.state_hash);
    text += &match remesh.is_reproducible() {
        true => format!(
            "The paper's Figure 2b shows how far replicates of one simulation spread. Ours do not \
             spread: {} replicates, on one core and on {} in turn, end in the same bits of every \
             position, velocity and pressure (`{hash}`). The paper's spread is its own and was not \
             measured here.\n\n",
            remesh.replicates.len(),
            measured_threads(remesh),
        ),
        false => {
            "Our replicates end in different bits, which they must not: see the raw points.\n\n"
                .to_owned()
        }
    };
    Ok(text)
}

fn measured_threads(remesh: &Remesh) -> usize {
    remesh.replicates.iter().map(|end| end.threads).max().unwrap_or(1)
}
