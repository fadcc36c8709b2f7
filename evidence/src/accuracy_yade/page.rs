//! What was found: table, words and picture.

use std::fmt::Write as _;

use dempfv_report::format::{count, three_digits};
use dempfv_report::machine;
use dempfv_report::markdown::table;
use dempfv_report::plot::{Axis, Mark, Panel, Picture, SERIES, Series, row};

use super::Report;
use super::curve::{Cost, Point, Quantity, cost};
use super::runs::{SOLVER, Way};

/// Errors that are paid for.
const ERRORS: [f64; 3] = [1e-3, 1e-2, 5e-2];

const HEAD: &str = "# What accuracy costs in time: YADE beside dempfv

The same packing, settled at 1 kPa, is loaded by the same servo wall to 10 kPa in both programs, with the same
steps, and drains through that wall. What is swept is the number of steps from one remesh to the next. Errors
are relative: the root of the sum of squares of the differences to a reference, over 32 moments evenly spread,
over that of the reference itself; of the pore pressure at 45 fixed points (that of the pore around each), and
of the settlement of the loaded wall. Each program is beside **its own reference**, a network at each step and
the same time step: what the programs differ by is no error here, and neither is what the time step does. YADE's
reference leaves out the networks of the 32 steps at whose ends one looks, since it shows the pressures of a new
network before it has solved them; the step after each has the network of the step before.

Times are wall time per model time of all steps but the first, which makes the first network, without what
looking takes; medians of the turns, with their range. The programs run by turns.

";

impl Report {
    fn points(&self, way: Way) -> Vec<&Point> {
        self.points.iter().filter(|point| point.way == way).collect()
    }
}

/// The page.
pub fn markdown(report: &Report, picture: &str) -> String {
    format!(
        "{HEAD}![Error against time]({picture}.png)\n\n{}\n{}{}",
        words(report),
        points_table(report),
        about(report)
    )
}

/// What was run, with what.
fn about(report: &Report) -> String {
    let busy = report.busy_cores;
    format!(
        "{} spheres, {} pores, {} threads for both programs: the background of dempfv is one of them. YADE {} \
         solves by `useSolver = {SOLVER}`, its default (CHOLMOD through Eigen, which keeps the factor from one \
         remesh to the next), with one thread of the BLAS, with which its steps are faster; it remeshes by \
         `meshUpdateInterval` alone (`defTolerance = -1`), for the reference by `updateTriangulation`. dempfv \
         has its default solver and tolerance. {}. Measured on {}{}.\n",
        count(report.spheres as u64),
        count(report.pores),
        report.threads,
        report.yade,
        machine::description(),
        machine::today(),
        busy.map_or(String::new(), |busy| format!("; others kept {busy:.1} cores busy")),
    )
}

fn shown(error: f64) -> String {
    if error == 0.0 { "reference".to_owned() } else { format!("{error:.1e}") }
}

/// All points, a line for each interval.
fn points_table(report: &Report) -> String {
    let mut header = vec!["interval (steps)".to_owned()];
    for way in Way::ALL {
        let name = way.name();
        header.extend([format!("{name}: s per s"), "pressure".into(), "settlement".into()]);
    }
    header.extend(
        [Way::AtOnce, Way::Background].map(|way| format!("{}: of YADE's time", way.name())),
    );
    let [yade, once, background] = Way::ALL.map(|way| report.points(way));
    let rows = yade.iter().zip(&once).zip(&background).map(|((yade, once), background)| {
        let mut cells = vec![yade.interval.to_string()];
        for point in [yade, once, background] {
            cells.push(point.seconds.show(1.0));
            cells.extend(Quantity::ALL.map(|quantity| shown(point.error(quantity))));
        }
        cells.extend(
            [once, background].map(|ours| share(ours.seconds.median(), yade.seconds.median())),
        );
        cells
    });
    table(&header.iter().map(String::as_str).collect::<Vec<_>>(), rows)
}

fn share(ours: f64, theirs: f64) -> String {
    format!("{} %", three_digits(100.0 * ours / theirs))
}

/// The same error in which share of the time, in words.
pub fn words(report: &Report) -> String {
    let mut text = String::new();
    let [yade, once, background] = Way::ALL.map(|way| report.points(way));
    for quantity in Quantity::ALL {
        for error in ERRORS {
            let theirs = cost(&yade, quantity, error);
            // Writing to a string cannot fail.
            let _ = write!(text, "- {}, error {error}: YADE {}", quantity.name(), said(theirs));
            for (name, points) in [("dempfv", &once), ("in the background", &background)] {
                let ours = cost(points, quantity, error);
                let _ = write!(text, "; {name} {}", said(ours));
                if let (Some(ours), Some(theirs)) = (ours.seconds(), theirs.seconds()) {
                    let _ = write!(text, ", {} of YADE's time", share(ours, theirs));
                }
            }
            text += ".\n";
        }
    }
    let apart = &report.references_apart;
    let _ = writeln!(
        text,
        "- The two references are apart by {:.1e} in pressure and {:.1e} in settlement: what the programs \
         differ by.",
        apart.pressure, apart.settlement
    );
    text
}

fn said(cost: Cost) -> String {
    match cost {
        Cost::Between(seconds) => format!("{} s per s", three_digits(seconds)),
        Cost::Any(seconds) => format!("{} s per s (no interval is worse)", three_digits(seconds)),
        Cost::NotReached => "not reached".to_owned(),
    }
}

/// Error against time, a line for each way.
pub fn picture(report: &Report) -> Picture {
    let curves = Way::ALL.map(|way| {
        let points = report.points(way);
        let seconds: Vec<f64> = points.iter().map(|p| p.seconds.median()).collect();
        let errors = Quantity::ALL
            .map(|quantity| -> Vec<f64> { points.iter().map(|p| p.error(quantity)).collect() });
        (way, seconds, errors)
    });
    let series = |at: usize| -> Vec<Series> {
        let mut all = vec![];
        for ((way, seconds, errors), color) in curves.iter().zip([SERIES[1], SERIES[0], SERIES[2]])
        {
            let of = |name, mark| Series { name, x: seconds, y: &errors[at], color, mark };
            // One legend serves both panels.
            let name = (at == 0).then(|| way.name().to_owned());
            all.push(of(name, Mark::Line { width: 1.4, dash: None }));
            all.push(of(None, Mark::Dots { radius: 2.8, apart: 0.0 }));
        }
        all
    };
    let (pressure, settlement) = (series(0), series(1));
    let x = Axis::log("Wall time per model time (1)");
    row(
        "What accuracy costs in time",
        &format!(
            "{} spheres, {} threads; each point is a remesh interval, its error beside the program's own \
             network at each step",
            count(report.spheres as u64),
            report.threads
        ),
        &[
            Panel {
                title: "",
                x,
                y: Axis::log("Error of the pore pressure (1)"),
                series: &pressure,
            },
            Panel {
                title: "",
                x,
                y: Axis::log("Error of the settlement (1)"),
                series: &settlement,
            },
        ],
    )
}

/// One row for each point.
pub fn csv(report: &Report) -> String {
    let mut text =
        "program,remesh_interval,seconds_per_second,least,most,turns,error_pressure,error_settlement\n"
            .to_owned();
    for point in &report.points {
        let [least, most] = point.seconds.range();
        let _ = writeln!(
            text,
            "{},{},{:e},{least:e},{most:e},{},{:e},{:e}",
            point.way.key(),
            point.interval,
            point.seconds.median(),
            point.seconds.0.len(),
            point.error_pressure,
            point.error_settlement,
        );
    }
    text
}
