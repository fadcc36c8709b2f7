//! Gradings by mass, as sieves give them: the share of the mass that is finer than a diameter.

use serde::Serialize;

use super::kind::{Kind, Number, inline, number};
use super::schema::Schema;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

pub(super) static LOG_NORMAL: Schema = Schema::table("`log_normal`", &["median", "deviation"]);

const DIAMETER: Number = number("m", Bound::Positive);
const PASSING: Number = number("(share of the mass that is finer)", Bound::NotNegative);
const DEVIATION: Number = number("(standard deviation of ln d)", Bound::Positive);

/// A grading curve by mass: straight between its points over the logarithm of the diameter, as
/// grading curves are drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GradingCurve(
    /// Diameter (m) and share of the mass that is finer (1), both ascending, the shares from 0 to 1.
    pub Vec<[f64; 2]>,
);

/// Diameters by mass whose logarithms are normally distributed, cut at 2.5 standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogNormal {
    /// Diameter that half of the mass is finer than (m).
    pub median: f64,
    /// Standard deviation of ln d (1).
    pub deviation: f64,
}

/// A piece of a curve: p rises by `slope` for each unit of ln d.
#[derive(Clone, Copy)]
struct Piece {
    from: f64,
    to: f64,
    slope: f64,
}

impl Piece {
    /// ∫ d^k dp over the piece, for k ≠ 0.
    fn moment(&self, k: i32) -> f64 {
        self.slope * (self.to.powi(k) - self.from.powi(k)) / f64::from(k)
    }

    /// Number of spheres, in units of one with d = 1 for all of the mass.
    fn number(&self) -> f64 {
        self.moment(-3)
    }

    /// Share of the mass from the piece's beginning up to where this number of its spheres is finer.
    fn mass_of(&self, number: f64) -> f64 {
        let d =
            (self.from.powi(-3) - 3.0 * number / self.slope).max(self.to.powi(-3)).powf(-1.0 / 3.0);
        self.slope * (d / self.from).ln()
    }
}

impl GradingCurve {
    fn pieces(&self) -> impl Iterator<Item = Piece> + '_ {
        self.0.windows(2).filter(|pair| pair[1][1] > pair[0][1]).map(|pair| {
            let ([from, p], [to, q]) = (pair[0], pair[1]);
            Piece { from, to, slope: (q - p) / (to / from).ln() }
        })
    }

    /// ∫ d^k dp, the mean of d^k by mass, for k ≠ 0.
    pub(super) fn moment(&self, k: i32) -> f64 {
        self.pieces().map(|piece| piece.moment(k)).sum()
    }

    /// Smallest and largest diameter (m).
    pub(super) fn ends(&self) -> [f64; 2] {
        let ends = self.pieces().map(|piece| [piece.from, piece.to]);
        ends.fold([f64::INFINITY, 0.0], |[a, b], [from, to]| [a.min(from), b.max(to)])
    }

    /// Radii of so many spheres, ascending (m). Each stands for an equal number of the curve's
    /// spheres and has their mean volume: the masses of the first k are those of the curve exactly.
    /// `None` where there is no memory for so many.
    pub fn radii(&self, count: usize) -> Option<Vec<f64>> {
        let mut radii = vec![];
        radii.try_reserve_exact(count).ok()?;
        let pieces: Vec<Piece> = self.pieces().collect();
        let total: f64 = pieces.iter().map(Piece::number).sum();
        let (mut piece, mut number, mut mass) = (0, 0.0, 0.0);
        let mut finer = 0.0;
        radii.extend((1..=count).map(|k| {
            let until = total * k as f64 / count as f64;
            while piece + 1 < pieces.len() && number + pieces[piece].number() < until {
                number += pieces[piece].number();
                mass += pieces[piece].moment_of_mass();
                piece += 1;
            }
            let now = match k == count {
                true => 1.0,
                false => mass + pieces.get(piece).map_or(0.0, |p| p.mass_of(until - number)),
            };
            let share = now - finer;
            finer = now;
            0.5 * (share * count as f64 / total).cbrt()
        }));
        Some(radii)
    }
}

impl Piece {
    /// Share of the mass of the whole piece.
    fn moment_of_mass(&self) -> f64 {
        self.slope * (self.to / self.from).ln()
    }
}

/// Standard deviations at which a log-normal grading is cut, and pieces of its curve.
const CUT: f64 = 2.5;
const PIECES: usize = 100;

impl LogNormal {
    /// The same as a curve.
    pub fn curve(&self) -> GradingCurve {
        let at = |k: usize| -CUT + 2.0 * CUT * k as f64 / PIECES as f64;
        let bell = |x: f64| (-0.5 * x * x).exp();
        let mut sums = vec![0.0];
        for k in 0..PIECES {
            let (a, b) = (at(k), at(k + 1));
            let simpson = (b - a) / 6.0 * (bell(a) + 4.0 * bell(0.5 * (a + b)) + bell(b));
            sums.push(sums[k] + simpson);
        }
        let total = sums[PIECES];
        let point = |(k, sum): (usize, &f64)| {
            [
                self.median * (self.deviation * at(k)).exp(),
                if k == PIECES { 1.0 } else { sum / total },
            ]
        };
        GradingCurve(sums.iter().enumerate().map(point).collect())
    }
}

/// Points of diameter and share that is finer.
pub(super) struct Curve;

impl Kind<GradingCurve> for Curve {
    fn read(&self, value: &Value) -> Result<GradingCurve> {
        const WANTED: &str = "points of diameter (m) and share of the mass that is finer, as in \
                              [[2e-4, 0.0], [5e-4, 0.6], [1e-3, 1.0]]";
        let mut points = vec![];
        for point in value.items(WANTED)? {
            let items = point.items(WANTED)?;
            let [diameter, finer] = items.as_slice() else {
                return Err(point.error("has an item that is no pair", format!("give {WANTED}")));
            };
            points.push([DIAMETER.read(diameter)?, PASSING.read(finer)?]);
        }
        let curve = GradingCurve(points);
        self.wrong(&curve).map_or(Ok(curve), |wrong| Err(value.wrong(wrong)))
    }

    fn wrong(&self, GradingCurve(points): &GradingCurve) -> Option<Wrong> {
        let numbers =
            points.iter().find_map(|[d, p]| DIAMETER.wrong(d).or_else(|| PASSING.wrong(p)));
        if let Some(Wrong { problem, remedy }) = numbers {
            return Some(Wrong::new(format!("has a point that {problem}"), remedy));
        }
        let rises = |k: usize| {
            points
                .windows(2)
                .all(|pair| pair[0][k] < pair[1][k] || k == 1 && pair[0][1] == pair[1][1])
        };
        let whole =
            points.first().map(|p| p[1]) == Some(0.0) && points.last().map(|p| p[1]) == Some(1.0);
        let holds = points.len() > 1 && rises(0) && rises(1) && whole;
        (!holds).then(|| {
            Wrong::new(
                "is no grading curve",
                "give two points or more, diameters ascending, shares from 0.0 at the first to \
         1.0 at the last",
            )
        })
    }

    fn write(&self, GradingCurve(points): &GradingCurve) -> Option<String> {
        let points: Vec<String> = points.iter().map(|[d, p]| format!("[{d:?}, {p:?}]")).collect();
        Some(format!("[{}]", points.join(", ")))
    }
}

/// Median and standard deviation: a table.
pub(super) struct Normal;

impl Kind<LogNormal> for Normal {
    fn read(&self, value: &Value) -> Result<LogNormal> {
        let table = value.table(&LOG_NORMAL)?;
        let median =
            table.need("median", "the diameter that half of the mass is finer than (m)")?;
        let deviation = table.need("deviation", "the standard deviation of ln d")?;
        let grading =
            LogNormal { median: DIAMETER.read(&median)?, deviation: DEVIATION.read(&deviation)? };
        self.wrong(&grading).map_or(Ok(grading), |wrong| Err(value.wrong(wrong)))
    }

    fn wrong(&self, grading: &LogNormal) -> Option<Wrong> {
        let beyond = |deviation: f64| {
            let problem = format!("has a `deviation` of {deviation}");
            Wrong::new(problem, "give 0.001 to 1.0; for equal spheres a `radius`")
        };
        DIAMETER
            .wrong(&grading.median)
            .or_else(|| DEVIATION.wrong(&grading.deviation))
            .or_else(|| (grading.deviation > 1.0).then(|| beyond(grading.deviation)))
    }

    fn write(&self, grading: &LogNormal) -> Option<String> {
        let LogNormal { median, deviation } = grading;
        Some(inline(&[("median", format!("{median:?}")), ("deviation", format!("{deviation:?}"))]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mass(radii: &[f64]) -> f64 {
        radii.iter().map(|r| (2.0 * r).powi(3)).sum()
    }

    /// Of a curve from 0.1 to 1 mm with half of the mass below 0.2 mm, the spheres have half of
    /// theirs there, to that of one sphere; the mean volume is the curve's, 1 / ∫ d⁻³ dp.
    #[test]
    fn spheres_have_the_masses_of_their_curve() {
        let curve = GradingCurve(vec![[1e-4, 0.0], [2e-4, 0.5], [1e-3, 1.0]]);
        let radii = curve.radii(4000).unwrap();
        assert!(radii.windows(2).all(|pair| pair[0] <= pair[1]));
        let fine: Vec<f64> = radii.iter().copied().filter(|r| *r < 1e-4).collect();
        let one = (2e-4_f64).powi(3) / mass(&radii);
        assert!(
            (mass(&fine) / mass(&radii) - 0.5).abs() < 2.0 * one,
            "{}",
            mass(&fine) / mass(&radii)
        );
        let mean = mass(&radii) / 4000.0;
        assert!((mean * curve.moment(-3) - 1.0).abs() < 1e-12);
        assert!(radii[0] >= 0.5e-4 && radii[3999] <= 0.5e-3);
    }

    /// By mass, ln d of a log-normal grading has the standard deviation that it was given, less what
    /// the cut at 2.5 of them takes: 1 − 2·2.5 φ(2.5) / (2 Φ(2.5) − 1) of its square, 0.9113.
    #[test]
    fn a_log_normal_grading_has_its_moments() {
        let grading = LogNormal { median: 3e-4, deviation: 0.4 };
        let curve = grading.curve();
        let mean_log = |k: u32| {
            let part = |pair: &[[f64; 2]]| {
                let ([a, p], [b, q]) = (pair[0], pair[1]);
                let (x, y) = ((a / 3e-4).ln(), (b / 3e-4).ln());
                // The mean of x^k over a straight piece, for k = 1 and 2.
                let mean = if k == 1 { 0.5 * (x + y) } else { (x * x + x * y + y * y) / 3.0 };
                (q - p) * mean
            };
            curve.0.windows(2).map(part).sum::<f64>()
        };
        assert!(mean_log(1).abs() < 1e-12);
        assert!((mean_log(2) / (0.9113 * 0.16) - 1.0).abs() < 1e-3, "{}", mean_log(2) / 0.16);
    }
}
