//! Figures with both programs on one pair of axes.

use dempfv::WallId;
use dempfv_report::plot::{Axis, Mark, Panel, Picture, SERIES, Series, row};

use super::loading::Course;

/// A quantity in both programs, at the same places along the horizontal axis.
pub struct Curve<'a> {
    /// Its name in the legend (markup).
    pub name: &'a str,
    /// YADE's values.
    pub yade: Vec<f64>,
    /// Ours.
    pub ours: Vec<f64>,
}

const LINE: Mark = Mark::Line { width: 1.4, dash: None };
const DOTS: Mark = Mark::Dots { radius: 2.6, apart: 14.0 };

/// Panels beside each other over the same horizontal axis, each with a vertical axis and
/// the curves over it. Lines are YADE's, dots ours.
pub fn beside(
    title: &str,
    caption: &str,
    (x, at): (Axis, &[f64]),
    panels: &[(Axis, &[Curve])],
) -> Picture {
    let mut color = SERIES.iter().cycle();
    let series: Vec<Vec<Series>> = panels
        .iter()
        .map(|(_, curves)| {
            curves.iter().flat_map(|c| both(c, at, *color.next().unwrap_or(&SERIES[0]))).collect()
        })
        .collect();
    let panels: Vec<Panel> = panels
        .iter()
        .zip(&series)
        .map(|((y, _), series)| Panel { title: "", x, y: *y, series })
        .collect();
    row(title, caption, &panels)
}

fn both<'a>(
    curve: &'a Curve,
    x: &'a [f64],
    color: dempfv_report::plot::color::Color,
) -> [Series<'a>; 2] {
    let name = Some(curve.name.to_owned());
    [
        Series { name, x, y: &curve.yade, color, mark: LINE },
        Series { name: None, x, y: &curve.ours, color, mark: DOTS },
    ]
}

/// The course of a coupled loading: pore pressures at heights (shares of the box), stress
/// on the loaded wall and the one opposite, and the settlement in a unit of its own.
pub fn course(
    title: &str,
    caption: &str,
    (x, at): (&str, &[f64]),
    [yade, ours]: [&Course; 2],
    (heights, unit, settlement): (&[f64], f64, &str),
) -> Picture {
    let scaled = |values: Vec<f64>, by: f64| values.into_iter().map(|v| v * by).collect();
    let names: Vec<String> = heights.iter().map(|h| format!("pressure at {h} *H*")).collect();
    let pressure: Vec<Curve> = names
        .iter()
        .enumerate()
        .map(|(i, name)| Curve { name, yade: yade.pressure_at(i), ours: ours.pressure_at(i) })
        .collect();
    let walls = [(WallId::YMax, "loaded wall"), (WallId::YMin, "opposite wall")];
    let stress: Vec<Curve> = walls
        .iter()
        .map(|(wall, name)| Curve {
            name,
            yade: scaled(yade.stress_on(*wall), 1e-3),
            ours: scaled(ours.stress_on(*wall), 1e-3),
        })
        .collect();
    let settled = [Curve {
        name: "settlement",
        yade: scaled(yade.settlement(), unit),
        ours: scaled(ours.settlement(), unit),
    }];
    beside(
        title,
        caption,
        (Axis::linear(x), at),
        &[
            (Axis::linear("Pore pressure (Pa)"), &pressure[..]),
            (Axis::linear("Wall stress, spheres and fluid (kPa)"), &stress[..]),
            (Axis::linear(settlement), &settled[..]),
        ],
    )
}
