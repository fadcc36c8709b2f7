//! What was found: table, words and pictures.

use std::fmt::Write as _;

use dempfv_report::format::{count, three_digits};
use dempfv_report::markdown::{cell, table};
use dempfv_report::plot::color::{Color, MUTED};
use dempfv_report::plot::{Axis, Mark, Panel, Picture, SERIES, Series, row, xy};

use super::statistics::{Law, Quantity, Size};
use crate::bench::sample::Sample;

/// What an estimate of a standard deviation from so many specimens is itself good for (1).
fn own_error(specimens: usize) -> f64 {
    (2.0 * (specimens as f64 - 1.0)).sqrt().recip()
}

fn percent(share: f64) -> String {
    format!("{} %", three_digits(100.0 * share))
}

/// A share with its sign.
fn signed(share: f64) -> String {
    format!("{}{}", if share > 0.0 { "+" } else { "−" }, percent(share.abs()))
}

fn power(law: &Law) -> String {
    format!("{:.2}", law.exponent).replace('-', "−")
}

fn spheres(size: &Size) -> String {
    count(u64::from(size.spheres))
}

/// How far the mean of a size is from that of the largest (1).
fn off(sizes: &[Size], size: &Size, quantity: Quantity) -> f64 {
    let largest = sizes.last().unwrap_or(size);
    size.of_quantity(quantity).mean / largest.of_quantity(quantity).mean - 1.0
}

const HEAD: &str = "# Representative volume

How far do the permeability and the stiffness of one packing stand for those of all packings that are made in
the same way? The specimens are those of `scenes/oedometer.toml` (radii within a third of their mean, E = 1 MPa,
smooth walls in a cube of 1 m): a cloud grows to 10 kPa at 3° of friction, two cycles between 10 and 11 kPa at
30° measure the oedometric modulus *E* (secant of the second loading), and a static flow along each axis,
between slip walls, the permeability *k*. Packings differ by the seed of their cloud alone. The larger a
packing, the smaller its spheres, so *k* is over the square of their Sauter diameter *d*.

*Spread* is the standard deviation of one specimen over the mean, ± that of the mean (standard error). *Core* is
the part that is a Sauter diameter away from all walls. Walls have a smaller share of a larger specimen, so the
means drift with its size; nothing is fitted to that.

";

/// The page.
pub fn markdown(sizes: &[Size], words: &str, [values, spreads]: [&str; 2]) -> String {
    format!(
        "{HEAD}![Values over the number of spheres]({values}.png)\n\n![Spread]({spreads}.png)\n\n\
         {words}\n{}{}",
        values_table(sizes),
        seconds(sizes)
    )
}

fn values_table(sizes: &[Size]) -> String {
    let header = [
        "spheres",
        "seeds",
        "box (*d*)",
        "porosity",
        "1000 *k*/*d*², three axes",
        "spread",
        "along the load",
        "spread",
        "core",
        "*E* (kPa)",
        "spread",
    ];
    let rows = sizes.iter().map(|size| {
        let value = |quantity, unit: f64| {
            let statistic = size.of_quantity(quantity);
            cell(Some(statistic.mean / unit).filter(|mean| mean.is_finite()), |mean| {
                // Differences between sizes are some per cent.
                let digits = (3.0 - mean.abs().log10().floor()).clamp(0.0, 6.0) as usize;
                format!("{mean:.digits$} ± {:.digits$}", statistic.standard_error / unit)
            })
        };
        let spread = |quantity| percent(size.of_quantity(quantity).spread());
        vec![
            spheres(size),
            size.specimens.len().to_string(),
            three_digits(size.edge),
            value(Quantity::Porosity, 1.0),
            value(Quantity::Permeability, 1e-3),
            spread(Quantity::Permeability),
            value(Quantity::PermeabilityAlongLoad, 1e-3),
            spread(Quantity::PermeabilityAlongLoad),
            value(Quantity::CorePermeability, 1e-3),
            value(Quantity::Modulus, 1e3),
            spread(Quantity::Modulus),
        ]
    });
    table(&header, rows)
}

/// What a specimen takes.
fn seconds(sizes: &[Size]) -> String {
    let each = sizes.iter().map(|size| {
        let times: Sample = size.specimens.iter().map(|s| s.seconds).collect();
        format!("{} s at {}", three_digits(times.median()), spheres(size))
    });
    format!("A specimen took {} spheres. ", each.collect::<Vec<_>>().join(", "))
}

/// What a larger specimen buys, size by size.
pub fn words(sizes: &[Size], laws: &[Law]) -> String {
    let Some(largest) = sizes.last() else { return String::new() };
    let mut text = String::new();
    for size in sizes {
        let spread = |quantity| percent(size.of_quantity(quantity).spread());
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "- One specimen of {} spheres: its permeability stands for those of its size to {} ({} along \
             one axis), its modulus to {}",
            spheres(size),
            spread(Quantity::Permeability),
            spread(Quantity::PermeabilityAlongLoad),
            spread(Quantity::Modulus),
        );
        if size.spheres != largest.spheres {
            let apart = |quantity| signed(off(sizes, size, quantity));
            let _ = write!(
                text,
                "; the means of its size are {} and {} off those of {} spheres",
                apart(Quantity::Permeability),
                apart(Quantity::Modulus),
                spheres(largest),
            );
        }
        text += ".\n";
    }
    for (name, quantity) in
        [("permeability", Quantity::Permeability), ("modulus", Quantity::Modulus)]
    {
        let small =
            |size: &&Size| off(sizes, size, quantity).abs() <= size.of_quantity(quantity).spread();
        let _ = match sizes.iter().rev().skip(1).take_while(small).last() {
            Some(size) => writeln!(
                text,
                "- The {name}: from {} spheres on one specimen scatters by more than the mean is off that of \
                 {} spheres: more seeds of that size buy more than a larger specimen.",
                spheres(size),
                spheres(largest)
            ),
            None => writeln!(
                text,
                "- The {name}: below {} spheres the mean is off that of these by more than one specimen \
                 scatters: a larger specimen buys what more seeds cannot.",
                spheres(largest)
            ),
        };
    }
    let core = |size: &Size| off(sizes, size, Quantity::CorePermeability);
    if let Some(smallest) = sizes.iter().find(|size| core(size).is_finite())
        && smallest.spheres != largest.spheres
    {
        let _ = writeln!(
            text,
            "- Of the core alone, the mean permeability of {} spheres is {} off that of {} spheres, where \
             that of the box is {}: the difference is what the walls do.",
            spheres(smallest),
            signed(core(smallest)),
            spheres(largest),
            signed(off(sizes, smallest, Quantity::Permeability)),
        );
    }
    for law in laws {
        let name = match law.quantity {
            Quantity::Modulus => "modulus",
            _ => "permeability",
        };
        let _ = writeln!(
            text,
            "- The spread of the {name} goes with the number of spheres to the power {}; independent pores \
             would give −0.5.",
            power(law)
        );
    }
    let seeds = largest.specimens.len();
    let _ = writeln!(
        text,
        "- A spread from {seeds} seeds is itself good to {} of itself.",
        percent(own_error(seeds))
    );
    text
}

/// One row for each quantity of each size.
pub fn csv(sizes: &[Size]) -> String {
    let mut text = "spheres,seeds,quantity,mean,standard_deviation,standard_error\n".to_owned();
    let number = |v: f64| if v.is_finite() { format!("{v:e}") } else { String::new() };
    for size in sizes {
        for statistic in &size.statistics {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{}",
                size.spheres,
                size.specimens.len(),
                statistic.quantity.key(),
                number(statistic.mean),
                number(statistic.standard_deviation),
                number(statistic.standard_error),
            );
        }
    }
    text
}

/// Values of one quantity over the number of spheres.
struct Curve {
    spheres: Vec<f64>,
    mean: Vec<f64>,
    /// A standard deviation to both sides, one stroke after the other.
    bars: [Vec<f64>; 2],
    each: [Vec<f64>; 2],
}

impl Curve {
    fn of(sizes: &[Size], quantity: Quantity, unit: f64) -> Curve {
        let mut curve =
            Curve { spheres: vec![], mean: vec![], bars: [vec![], vec![]], each: [vec![], vec![]] };
        for size in sizes {
            let (at, statistic) = (f64::from(size.spheres), size.of_quantity(quantity));
            let (mean, deviation) = (statistic.mean / unit, statistic.standard_deviation / unit);
            curve.spheres.push(at);
            curve.mean.push(mean);
            // What is no number ends a stroke.
            curve.bars[0].extend([at, at, f64::NAN]);
            curve.bars[1].extend([mean - deviation, mean + deviation, f64::NAN]);
            curve.each[0].extend(size.specimens.iter().map(|_| at));
            curve.each[1].extend(size.specimens.iter().map(|s| quantity.of(s) / unit));
        }
        curve
    }

    fn series(&self, name: &str, color: Color) -> [Series<'_>; 3] {
        let series = |name: Option<String>, x, y, mark| Series { name, x, y, color, mark };
        let line = |width| Mark::Line { width, dash: None };
        [
            series(Some(name.to_owned()), &self.spheres[..], &self.mean[..], line(1.6)),
            series(None, &self.bars[0][..], &self.bars[1][..], line(1.0)),
            series(
                None,
                &self.each[0][..],
                &self.each[1][..],
                Mark::Dots { radius: 1.8, apart: 0.0 },
            ),
        ]
    }
}

const SPHERES: &str = "Spheres";

/// Means with a standard deviation to both sides, and each specimen.
pub fn values(sizes: &[Size]) -> Picture {
    let of = |quantity, unit| Curve::of(sizes, quantity, unit);
    let (box_, core) = (of(Quantity::Permeability, 1e-3), of(Quantity::CorePermeability, 1e-3));
    let modulus = of(Quantity::Modulus, 1e3);
    let mut flow = box_.series("permeability of the box", SERIES[0]).to_vec();
    flow.extend(core.series("of its core", SERIES[2]));
    let stiff = modulus.series("oedometric modulus", SERIES[1]);
    let x = Axis::log(SPHERES);
    row(
        "Representative volume",
        "Lines: mean over seeds, with one standard deviation to both sides; dots: each specimen",
        &[
            Panel { title: "", x, y: Axis::linear("1000 *k* / *d*² (1)"), series: &flow },
            Panel { title: "", x, y: Axis::linear("*E* (kPa)"), series: &stiff },
        ],
    )
}

/// Spreads, their power laws, and that of independent pores.
pub fn spreads(sizes: &[Size], laws: &[Law]) -> Picture {
    let at: Vec<f64> = sizes.iter().map(|size| f64::from(size.spheres)).collect();
    let spread = |quantity| -> Vec<f64> {
        sizes.iter().map(|size| 100.0 * size.of_quantity(quantity).spread()).collect()
    };
    let shown = [
        ("permeability", Quantity::Permeability, SERIES[0]),
        ("oedometric modulus", Quantity::Modulus, SERIES[1]),
    ];
    let spreads = shown.map(|(_, quantity, _)| spread(quantity));
    let fits: Vec<Vec<f64>> = shown
        .iter()
        .filter_map(|(_, quantity, _)| laws.iter().find(|law| law.quantity == *quantity))
        .map(|law| at.iter().map(|&n| 100.0 * law.at(n)).collect())
        .collect();
    let independent: Vec<f64> = match (at.first(), spreads[0].first()) {
        (Some(&first), Some(&spread)) => at.iter().map(|n| spread * (first / n).sqrt()).collect(),
        _ => vec![],
    };
    let mut series = vec![];
    for ((name, quantity, color), y) in shown.iter().zip(&spreads) {
        let name = match laws.iter().find(|law| law.quantity == *quantity) {
            Some(law) => format!("{name}, fitted power {}", power(law)),
            None => (*name).to_owned(),
        };
        let mark = Mark::Dots { radius: 3.2, apart: 0.0 };
        series.push(Series { name: Some(name), x: &at, y, color: *color, mark });
    }
    for ((.., color), y) in shown.iter().zip(&fits) {
        let mark = Mark::Line { width: 1.4, dash: None };
        series.push(Series { name: None, x: &at, y, color: *color, mark });
    }
    let mark = Mark::Line { width: 1.2, dash: Some([5.0, 3.0]) };
    let name = Some("independent pores, power −0.5".to_owned());
    series.push(Series { name, x: &at, y: &independent, color: MUTED, mark });
    xy(
        "What separates packings",
        "Standard deviation of one specimen over the mean",
        Axis::log(SPHERES),
        Axis::log("Spread (%)"),
        &series,
    )
}
