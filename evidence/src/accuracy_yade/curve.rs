//! Errors over times: what a program pays for an error.

use serde::Serialize;

use super::runs::{Course, Way};
use crate::bench::sample::Sample;

/// What errors are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    Pressure,
    Settlement,
}

impl Quantity {
    pub const ALL: [Quantity; 2] = [Quantity::Pressure, Quantity::Settlement];

    pub fn name(self) -> &'static str {
        match self {
            Quantity::Pressure => "pore pressure",
            Quantity::Settlement => "settlement",
        }
    }

    /// How far a course is from another, over that other: roots of sums of squares over all looks (1).
    pub fn error(self, course: &Course, reference: &Course) -> f64 {
        let all = |course: &Course| match self {
            Quantity::Pressure => course.pressure.concat(),
            Quantity::Settlement => course.displacement.clone(),
        };
        let (ours, theirs) = (all(course), all(reference));
        let off: f64 = ours.iter().zip(&theirs).map(|(a, b)| (a - b).powi(2)).sum();
        (off / theirs.iter().map(|b| b * b).sum::<f64>()).sqrt()
    }
}

/// One interval of one program.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    pub way: Way,
    /// Steps from one remesh to the next.
    pub interval: u64,
    /// Wall seconds per second of model time, of each turn.
    pub seconds: Sample,
    pub error_pressure: f64,
    pub error_settlement: f64,
}

impl Point {
    pub fn error(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Pressure => self.error_pressure,
            Quantity::Settlement => self.error_settlement,
        }
    }
}

/// What an error costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cost {
    /// Seconds per second of model time, between two intervals.
    Between(f64),
    /// The error is larger than that of any interval: the time of the fastest.
    Any(f64),
    /// The error is smaller than that of any interval.
    NotReached,
}

impl Cost {
    pub fn seconds(self) -> Option<f64> {
        match self {
            Cost::Between(seconds) | Cost::Any(seconds) => Some(seconds),
            Cost::NotReached => None,
        }
    }
}

/// What an error costs, along the line through the points of one program from the longest interval on, in
/// logarithms.
pub fn cost(points: &[&Point], quantity: Quantity, error: f64) -> Cost {
    let of = |point: &Point| (point.error(quantity), point.seconds.median());
    let mut coarser: Option<(f64, f64)> = None;
    for (e, seconds) in points.iter().rev().map(|point| of(point)) {
        // That of the reference itself has no logarithm.
        if e == 0.0 {
            break;
        }
        if e <= error {
            return match coarser {
                None => Cost::Any(points.iter().map(|p| of(p).1).fold(f64::INFINITY, f64::min)),
                Some((above, there)) => {
                    let share = (error / above).ln() / (e / above).ln();
                    Cost::Between(there * (seconds / there).powf(share))
                }
            };
        }
        coarser = Some((e, seconds));
    }
    Cost::NotReached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(interval: u64, error: f64, seconds: f64) -> Point {
        Point {
            way: Way::Yade,
            interval,
            seconds: Sample(vec![seconds]),
            error_pressure: error,
            error_settlement: 2.0 * error,
        }
    }

    /// By hand: half way between 1e-1 and 1e-3 in logarithms is 1e-2, and half way between 1 s and 100 s 10 s.
    #[test]
    fn costs_are_found_in_logarithms() {
        let all = [point(1, 0.0, 900.0), point(10, 1e-3, 100.0), point(100, 1e-1, 1.0)];
        let points: Vec<&Point> = all.iter().collect();
        let of = |error| cost(&points, Quantity::Pressure, error);
        let Cost::Between(seconds) = of(1e-2) else { panic!("{:?}", of(1e-2)) };
        assert!((seconds - 10.0).abs() < 1e-9, "{seconds}");
        assert_eq!((of(0.2), of(1e-4)), (Cost::Any(1.0), Cost::NotReached));
        assert_eq!(of(1e-4).seconds(), None);
        // The error of the settlement is twice as large.
        let Cost::Between(twice) = cost(&points, Quantity::Settlement, 2e-2) else { panic!() };
        assert!((twice - 10.0).abs() < 1e-9, "{twice}");
    }

    /// By hand: off by 0.1 of 1 and 0.2 of 2 is off by a tenth.
    #[test]
    fn errors_are_relative() {
        let course = |p: f64, u: f64| Course {
            displacement: vec![u, 2.0 * u],
            pressure: vec![vec![p], vec![2.0 * p]],
            pores: 1,
            seconds: 1.0,
        };
        let error = |quantity: Quantity| quantity.error(&course(1.1, -3.0), &course(1.0, -2.0));
        assert!((error(Quantity::Pressure) - 0.1).abs() < 1e-12);
        assert!((error(Quantity::Settlement) - 0.5).abs() < 1e-12);
    }
}
