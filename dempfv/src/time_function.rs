//! Values that change with time: what a wall or a region is told.

use serde::{Deserialize, Serialize};

/// A value as a function of the model time.
///
/// ```
/// use dempfv::TimeFunction;
/// let ramp = TimeFunction::Ramp(vec![[0.0, 1.0], [2.0, 5.0]]);
/// assert_eq!([-1.0, 0.5, 2.0, 9.0].map(|t| ramp.value(t)), [1.0, 2.0, 5.0, 5.0]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeFunction {
    /// Always this.
    Constant(f64),
    /// Straight lines through points of time (s) and value, which stays at the first value before
    /// them and at the last one after them.
    Ramp(Vec<[f64; 2]>),
    /// `mean + amplitude sin(2π frequency t)`.
    Sine {
        /// What it swings about.
        mean: f64,
        /// How far it swings.
        amplitude: f64,
        /// How often (Hz).
        frequency: f64,
    },
}

impl From<f64> for TimeFunction {
    fn from(value: f64) -> TimeFunction {
        TimeFunction::Constant(value)
    }
}

impl TimeFunction {
    /// The value at a time (s). Not a number for a ramp without points; see
    /// [`TimeFunction::problem`].
    pub fn value(&self, time: f64) -> f64 {
        match self {
            TimeFunction::Constant(value) => *value,
            TimeFunction::Ramp(points) => {
                let after = points.partition_point(|[t, _]| *t <= time);
                match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
                    (Some([t, v]), Some([u, w])) => v + (w - v) * ((time - t) / (u - t)),
                    (Some([_, v]), None) | (None, Some(&[_, v])) => v,
                    (None, None) => f64::NAN,
                }
            }
            TimeFunction::Sine { mean, amplitude, frequency } => {
                mean + amplitude * (std::f64::consts::TAU * frequency * time).sin()
            }
        }
    }

    /// What is wrong with it, and what would be right; `None` where nothing is.
    pub fn problem(&self) -> Option<(&'static str, &'static str)> {
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        match self {
            TimeFunction::Constant(value) if finite(&[*value]) => None,
            TimeFunction::Sine { mean, amplitude, frequency }
                if finite(&[*mean, *amplitude, *frequency]) && *frequency > 0.0 =>
            {
                None
            }
            TimeFunction::Sine { .. } => Some((
                "has a sine with a number that cannot be right",
                "give a finite mean and amplitude, and a frequency above 0 in Hz",
            )),
            TimeFunction::Ramp(points)
                if !points.is_empty()
                    && points.iter().all(|point| finite(point))
                    && points.windows(2).all(|pair| pair[0][0] < pair[1][0]) =>
            {
                None
            }
            TimeFunction::Ramp(_) => Some((
                "has a ramp that is no function of time",
                "give one or more points [time, value] in finite numbers, each later than the one before",
            )),
            TimeFunction::Constant(_) => Some(("is not finite", "give a finite number")),
        }
    }
}
