//! From single knobs to settings that go together.

use serde::Serialize;

use super::setting::Setting;
use super::study::Study;
use super::sweep::{Point, Runs, Sweep};

/// How often what was chosen may be made finer.
const TRIES: u32 = 5;

/// Knobs of which one setting is chosen each. Their errors add up as squares.
const GROUPS: [&[&str]; 4] = [
    &["remesh interval", "remesh strain", "tolerance, every step"],
    &["tolerance"],
    &["clamp"],
    &["time step"],
];

/// Settings for a target.
#[derive(Clone, Debug, Serialize)]
pub struct Choice {
    /// Error that was asked for (1).
    pub target: f64,
    /// The run with them.
    pub point: Point,
    /// Whether its error is within the target.
    pub met: bool,
    /// Error of the same settings in a study that was not used for choosing.
    pub elsewhere: Option<f64>,
    /// Why that is not known, where it was looked for.
    pub not_elsewhere: Option<String>,
    /// How many times faster it is than the reference, and than the scene as it is.
    pub faster_than_reference: f64,
    pub faster_than_scene: f64,
}

/// The fastest setting of each group whose own error leaves room for those of the others, tried
/// together; finer ones until the target is met.
pub fn choose(study: &Study, runs: &mut Runs<'_>, sweep: &Sweep, target: f64) -> Choice {
    let mut share = target / (GROUPS.len() as f64).sqrt();
    let mut best: Option<Point> = None;
    for _ in 0..TRIES {
        let mut settings: Vec<Setting> =
            GROUPS.iter().filter_map(|group| fastest(&sweep.points, group, share)).collect();
        // It has a tolerance of its own.
        if settings.iter().any(|s| matches!(s, Setting::IteratedTolerance(_))) {
            settings.retain(|s| !matches!(s, Setting::Tolerance(_)));
        }
        let floor = sweep.floor.main();
        let (point, _) = runs.point("chosen", &settings, (&sweep.reference, None), floor);
        let better = best.as_ref().is_none_or(|b| b.error.is_nan() || point.error < b.error);
        if better {
            best = Some(point.clone());
        }
        if point.error <= target {
            best = Some(point);
            break;
        }
        share *= 0.5;
    }
    let point = best.unwrap_or_else(|| sweep.scene.clone());
    let reference = sweep.reference_seconds(study.window);
    Choice {
        target,
        met: point.error <= target,
        elsewhere: None,
        not_elsewhere: None,
        faster_than_reference: reference / point.seconds,
        faster_than_scene: sweep.scene.seconds / point.seconds,
        point,
    }
}

/// Knobs that cost no time: the most exact setting is taken.
const FREE: [&str; 1] = ["clamp"];
/// A setting is taken for a faster one from this share of the time on.
const FASTER: f64 = 0.9;

/// The fastest setting of some knobs with at most this error of its own; the most exact where there is
/// none, or where none is faster.
fn fastest(points: &[Point], group: &[&str], error: f64) -> Option<Setting> {
    let of_group = || {
        let among = points.iter().filter(|p| group.contains(&p.knob) && p.failed.is_none());
        among.map(|p| (p, own(p))).filter(|(_, own)| !own.is_nan())
    };
    let good = of_group().filter(|(_, own)| *own <= error);
    let fastest = good.min_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds));
    let exact = of_group().min_by(|a, b| a.1.total_cmp(&b.1));
    let gains = |(exact, fastest): (&Point, &Point)| {
        fastest.seconds < FASTER * exact.seconds && !FREE.contains(&fastest.knob)
    };
    let (exact, fastest) = (exact?.0, fastest.map(|(point, _)| point));
    let chosen = fastest.filter(|&fastest| gains((exact, fastest))).unwrap_or(exact);
    chosen.settings.first().copied()
}

/// A point's own error; not a number where it is not known.
fn own(point: &Point) -> f64 {
    if point.is_finest { 0.0 } else { point.own.main() }
}

/// Points that none beats in both error and time, from the fastest on.
pub fn pareto(points: &[Point]) -> Vec<&Point> {
    let mut sorted: Vec<&Point> = points.iter().filter(|p| p.error.is_finite()).collect();
    sorted.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let mut least = f64::INFINITY;
    sorted.retain(|point| {
        let better = point.error < least;
        least = least.min(point.error);
        better
    });
    sorted
}

/// Exponent of a power law through the own errors of a knob over what it sets; `None` below three that
/// are above the floor.
pub fn order(
    points: &[Point],
    knob: &str,
    floor: f64,
    value: fn(&Setting) -> Option<f64>,
) -> Option<f64> {
    // Without fluid there is no other solver to compare with.
    let floor = if floor.is_nan() { 0.0 } else { 3.0 * floor };
    let of_knob = points.iter().filter(|p| p.knob == knob && p.own.main() > floor);
    let logs: Vec<(f64, f64)> = of_knob
        .filter_map(|p| Some((value(p.settings.first()?)?.ln(), p.own.main().ln())))
        .filter(|(_, y)| y.is_finite())
        .collect();
    if logs.len() < 3 {
        return None;
    }
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    Some(covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::super::errors::Errors;
    use super::*;
    use crate::bench::sample::Sample;

    fn point(steps: u64, own: f64, error: f64, seconds: f64) -> Point {
        let errors = |e| Errors { pressure: Some(e), ..Errors::default() };
        Point {
            knob: "remesh interval",
            setting: String::new(),
            errors: errors(error),
            own: errors(own),
            error,
            seconds_per_second: Sample::default(),
            seconds,
            is_finest: own == 0.0,
            under_floor: false,
            steps: 1,
            networks: 1,
            theory: None,
            estimate: None,
            energy: None,
            failed: None,
            settings: vec![Setting::Interval(steps)],
        }
    }

    /// The fastest that is exact enough; the front has what none beats; errors that grow as the interval
    /// have order 1.
    #[test]
    fn the_fastest_that_is_exact_enough() {
        let points = [
            point(1, 0.0, 0.001, 9.0),
            point(10, 0.01, 0.01, 5.0),
            point(20, 0.02, 0.02, 6.0),
            point(40, 0.04, 0.04, 2.0),
        ];
        let chosen = |error| fastest(&points, GROUPS[0], error);
        assert_eq!(chosen(0.03), Some(Setting::Interval(10)));
        assert_eq!(chosen(1.0), Some(Setting::Interval(40)));
        assert_eq!(chosen(1e-9), Some(Setting::Interval(1)));
        assert_eq!(pareto(&points).len(), 3);
        let interval =
            |s: &Setting| if let Setting::Interval(n) = s { Some(*n as f64) } else { None };
        let order = order(&points, "remesh interval", 1e-9, interval).unwrap();
        assert!((order - 1.0).abs() < 1e-9, "{order}");
    }
}
