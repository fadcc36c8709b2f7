//! The figures of the report.

use std::path::Path;

use dempfv_report::plot::{Axis, Mark, Panel, SERIES, Series, row, xy};

use super::Results;
use super::linear::Side;
use crate::Error;

/// Draws them; returns their names and what they show.
///
/// # Errors
/// A file cannot be written.
pub fn all(results: &Results, folder: &Path) -> Result<Vec<(&'static str, &'static str)>, Error> {
    let mut drawn = vec![];
    if results.coupled.len() > 1 {
        coupled(results, folder)?;
        drawn.push(("coupled", "Time per coupled step against the number of spheres"));
    }
    if results.linear.len() > 1 {
        linear(results, folder)?;
        drawn.push(("linear", "Times and memory of the solvers against the number of unknowns"));
    }
    Ok(drawn)
}

/// Values over sizes under a name.
struct Curve {
    name: String,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// Lines with dots, each in its own colour.
fn series(curves: &[Curve], named: bool) -> Vec<Series<'_>> {
    let colored = curves.iter().zip(SERIES.iter().cycle());
    colored
        .flat_map(|(Curve { name, x, y }, &color)| {
            let line = Mark::Line { width: 1.6, dash: None };
            let dots = Mark::Dots { radius: 3.0, apart: 0.0 };
            let name = named.then(|| name.clone());
            [(name, line), (None, dots)].map(|(name, mark)| Series { name, x, y, color, mark })
        })
        .collect()
}

fn coupled(results: &Results, folder: &Path) -> Result<(), Error> {
    let cases = &results.coupled;
    let x: Vec<f64> = cases.iter().map(|c| c.spheres as f64).collect();
    let curve = |name: &str, y: Vec<f64>| Curve { name: name.to_owned(), x: x.clone(), y };
    let ours = |i: usize| {
        let whole = |c: &super::coupled::Case| {
            c.ours.get(i).map_or(f64::NAN, |side| 1e3 * side.whole_s.median())
        };
        cases.iter().map(whole).collect()
    };
    let curves = [
        curve("dempfv, remesh in turn", ours(0)),
        curve("YADE", cases.iter().map(|c| 1e3 * c.yade_s.median()).collect()),
        curve("dempfv, remesh in the background", ours(1)),
    ];
    xy(
        "Time per coupled step",
        "a step with its share of a remesh every 200 steps, two threads",
        Axis::log("Spheres"),
        Axis::log("Time per step (ms)"),
        &series(&curves, true),
    )
    .save(folder, "coupled")?;
    Ok(())
}

fn linear(results: &Results, folder: &Path) -> Result<(), Error> {
    let mut names: Vec<&str> =
        results.linear.iter().flat_map(|c| &c.sides).map(|s| s.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let curves = |value: fn(&Side, f64) -> f64| -> Vec<Curve> {
        let one = |name: &str| {
            let points = results.linear.iter().filter_map(|case| {
                let n = case.unknowns as f64;
                Some((n, value(case.side(name)?, n)))
            });
            let (x, y) = points.unzip();
            Curve { name: name.to_owned(), x, y }
        };
        names.iter().map(|name| one(name)).collect()
    };
    let panels = [
        ("Ordering, analysis (s)", curves(|s, _| s.analyze_s.median())),
        ("Factorization (s)", curves(|s, _| s.factor_s.median())),
        ("Solve (ms)", curves(|s, _| 1e3 * s.solve_s.median())),
        ("Memory for an unknown (B)", curves(|s, n| s.taken() / n)),
    ];
    let drawn: Vec<Vec<Series>> =
        panels.iter().enumerate().map(|(i, (_, curves))| series(curves, i == 0)).collect();
    let panels: Vec<Panel> = panels
        .iter()
        .zip(&drawn)
        .map(|((label, _), series)| Panel {
            title: "",
            x: Axis::log("Unknowns"),
            y: Axis::log(label),
            series,
        })
        .collect();
    row("The linear systems of real networks", "two threads", &panels).save(folder, "linear")?;
    Ok(())
}
