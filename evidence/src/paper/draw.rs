//! Curves over the size of the specimen, and tables of the same numbers.

use std::path::Path;

use dempfv_report::plot::{Axis, Mark, Picture, SERIES, Series, xy};

use crate::Error;

/// Folder of the figures below that of the page, and beginning of their links in it.
pub const FOLDER: &str = "paper";

const LINE: Mark = Mark::Line { width: 1.6, dash: None };
const DOTS: Mark = Mark::Dots { radius: 3.2, apart: 0.0 };

/// Measured points, joined in their order.
pub struct Curve {
    /// Name in the legend; without one it is in none.
    pub name: String,
    /// Where each point lies.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// A curve through these points; those that were not measured are left out.
    pub fn new(
        name: impl Into<String>,
        points: impl IntoIterator<Item = Option<(f64, f64)>>,
    ) -> Curve {
        Curve { name: name.into(), points: points.into_iter().flatten().collect() }
    }
}

/// Draws curves over one pair of axes.
pub fn draw(title: &str, caption: &str, x: Axis, y: Axis, curves: &[Curve]) -> Picture {
    let columns: Vec<(Vec<f64>, Vec<f64>)> =
        curves.iter().map(|c| c.points.iter().copied().unzip()).collect();
    let series: Vec<Series> = (curves.iter().zip(&columns).enumerate())
        .filter(|(_, (curve, _))| !curve.points.is_empty())
        .flat_map(|(i, (curve, (x, y)))| {
            let color = SERIES[i % SERIES.len()];
            let name = Some(curve.name.clone()).filter(|name| !name.is_empty());
            let line = Series { name, x, y, color, mark: LINE };
            let dots = Series { name: None, mark: DOTS, ..line.clone() };
            [line, dots]
        })
        .collect();
    xy(title, caption, x, y, &series)
}

/// Saves a figure; returns what shows it on the page.
///
/// # Errors
/// When it cannot be written.
pub fn save(folder: &Path, name: &str, title: &str, picture: &Picture) -> Result<String, Error> {
    picture.save(&folder.join(FOLDER), name)?;
    Ok(format!("![{title}]({FOLDER}/{name}.png)\n\n"))
}
