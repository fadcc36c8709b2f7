//! The picture of a grading: the share of the mass that is finer, over the diameter.

use std::path::Path;

use dempfv::Result;
use dempfv::scene::ParticleSource;
use dempfv::simulation::Simulation;
use dempfv_report::format::count;
use dempfv_report::plot::color::INK;
use dempfv_report::plot::{self, Mark, SERIES, Series};

/// Draws it where the scene asks for a grading by mass.
///
/// # Errors
/// When a file cannot be written.
pub fn draw(folder: &Path, simulation: &Simulation) -> Result<()> {
    let ParticleSource::Cloud(cloud) = &simulation.plan().particles.source else { return Ok(()) };
    let Some(asked) = cloud.sizes.grading_curve() else { return Ok(()) };
    let mut diameter: Vec<f64> =
        simulation.coupled().dem().storage().radius.iter().map(|r| 2e3 * r).collect();
    diameter.sort_by(f64::total_cmp);
    let total: f64 = diameter.iter().map(|d| d.powi(3)).sum();
    let mut sum = 0.0;
    let mut finer = |d: &f64| {
        sum += d.powi(3);
        100.0 * sum / total
    };
    let finer: Vec<f64> = diameter.iter().map(&mut finer).collect();
    let (x, y): (Vec<f64>, Vec<f64>) = asked.0.iter().map(|[d, p]| (1e3 * d, 100.0 * p)).unzip();
    let series = [
        Series {
            name: Some("asked for".to_owned()),
            x: &x,
            y: &y,
            color: INK,
            mark: Mark::Line { width: 1.2, dash: None },
        },
        Series {
            name: Some(format!("{} spheres", count(diameter.len() as u64))),
            x: &diameter,
            y: &finer,
            color: SERIES[0],
            mark: Mark::Dots { radius: 2.4, apart: 9.0 },
        },
    ];
    let caption = "As they are at the end.";
    let (x_axis, y_axis) = (
        plot::Axis::log("Diameter (mm)"),
        plot::Axis::linear("Share of the mass that is finer (%)").spanning(0.0, 100.0),
    );
    plot::xy(&simulation.plan().title, caption, x_axis, y_axis, &series).save(folder, "grading")
}
