//! Work-precision diagrams.

use dempfv_report::plot::color::INK;
use dempfv_report::plot::{Axis, Mark, Picture, SERIES, Series, xy};

use super::choose::{Choice, pareto};
use super::sweep::{Point, Sweep};

const X: &str = "Wall time per model time (1)";

/// Error and time of some points.
type Curve = (Vec<f64>, Vec<f64>);

fn curve<'a>(points: impl Iterator<Item = &'a Point>, error: fn(&Point) -> f64) -> Curve {
    let known = points.map(|p| (p.seconds, error(p)));
    known.filter(|(seconds, error)| error.is_finite() && *error > 0.0 && *seconds > 0.0).unzip()
}

/// The knobs of a sweep, each with its points.
fn curves(sweep: &Sweep, error: fn(&Point) -> f64) -> Vec<(&'static str, Curve)> {
    let mut knobs: Vec<&str> = vec![];
    for point in &sweep.points {
        if !knobs.contains(&point.knob) {
            knobs.push(point.knob);
        }
    }
    let of = |knob| curve(sweep.points.iter().filter(|p| p.knob == knob), error);
    knobs.into_iter().map(|knob| (knob, of(knob))).collect()
}

const fn line(width: f64, dash: Option<[f64; 2]>) -> Mark {
    Mark::Line { width, dash }
}

const fn dots(radius: f64) -> Mark {
    Mark::Dots { radius, apart: 0.0 }
}

/// Knobs whose settings have no order: a line would join what does not belong together.
const CHOICES: [&str; 5] = ["remesh mode", "update", "solver", "clamp", "effects"];

/// A line with dots for each knob that has points.
fn lines<'a>(curves: &'a [(&'static str, Curve)]) -> Vec<Series<'a>> {
    let mut series = vec![];
    for (i, (knob, (x, y))) in curves.iter().enumerate().filter(|(_, (_, (x, _)))| !x.is_empty()) {
        let color = SERIES[i % SERIES.len()];
        let dash = (i >= SERIES.len()).then_some([5.0, 3.0]);
        let name = Some((*knob).to_owned());
        if CHOICES.contains(knob) {
            series.push(Series { name, x, y, color, mark: dots(3.4) });
            continue;
        }
        series.push(Series { name, x, y, color, mark: line(1.4, dash) });
        series.push(Series { name: None, x, y, color, mark: dots(2.6) });
    }
    series
}

/// Error against time, a line for each knob, all else as the scene has it.
pub fn together(title: &str, sweep: &Sweep, choices: &[Choice]) -> Picture {
    let curves = curves(sweep, |p| p.error);
    let mut series = lines(&curves);
    let front = curve(pareto(&sweep.points).into_iter(), |p| p.error);
    let chosen = curve(choices.iter().map(|choice| &choice.point), |p| p.error);
    let scene = curve(std::iter::once(&sweep.scene), |p| p.error);
    let name = Some("none is better in both".to_owned());
    let mark = line(1.0, Some([2.0, 3.0]));
    series.push(Series { name, x: &front.0, y: &front.1, color: INK, mark });
    for (name, (x, y), radius) in [("the scene", &scene, 4.5), ("chosen", &chosen, 6.0)] {
        let color = if name == "chosen" { SERIES[1] } else { INK };
        series.push(Series { name: Some(name.to_owned()), x, y, color, mark: dots(radius) });
    }
    let y = Axis::log("Error beside the reference (1)");
    xy(title, "Each line is one knob, all else as the scene has it", Axis::log(X), y, &series)
}

/// What each knob does alone: the error beside the same scene with the knob's finest setting.
pub fn alone(title: &str, sweep: &Sweep) -> Picture {
    let curves = curves(sweep, |p| if p.is_finest { f64::NAN } else { p.own.main() });
    let mut series = lines(&curves);
    let times = || curves.iter().flat_map(|(_, (x, _))| x.iter().copied());
    let ends =
        [times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)].map(|t| t.max(1e-9));
    let floor = [sweep.floor.main(); 2];
    if floor[0] > 0.0 && ends[0] < ends[1] {
        let name = Some("another solver".to_owned());
        let mark = line(1.0, Some([2.0, 3.0]));
        series.push(Series { name, x: &ends, y: &floor, color: INK, mark });
    }
    let subtitle =
        "Each line is one knob, beside the same scene with the finest setting of that knob";
    xy(title, subtitle, Axis::log(X), Axis::log("Own error (1)"), &series)
}
