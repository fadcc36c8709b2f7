//! Repeated measurements of one quantity.

use dempfv_report::format::three_digits;
use serde::{Deserialize, Serialize};

/// Measurements, of which the median counts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Sample(pub Vec<f64>);

impl Sample {
    /// The one in the middle; NaN if there is none.
    pub fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        match sorted.len() {
            0 => f64::NAN,
            n if n % 2 == 1 => sorted[n / 2],
            n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
        }
    }

    /// The values a quarter and three quarters up in order, between neighbours where none is there;
    /// NaN if there is none.
    pub fn quartiles(&self) -> [f64; 2] {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else { return [f64::NAN; 2] };
        [0.25, 0.75].map(|share| {
            let at = share * last as f64;
            let below = at as usize;
            let above = sorted[(below + 1).min(last)];
            sorted[below] + (at - below as f64) * (above - sorted[below])
        })
    }

    /// The mean; NaN if there is none.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Smallest and largest.
    pub fn range(&self) -> [f64; 2] {
        let both = |[low, high]: [f64; 2], &v: &f64| [low.min(v), high.max(v)];
        self.0.iter().fold([f64::INFINITY, f64::NEG_INFINITY], both)
    }

    /// The median, and where there are several the range, in units of `unit`.
    pub fn show(&self, unit: f64) -> String {
        let text = |v: f64| three_digits(v / unit);
        match self.0.len() {
            0 => "–".to_owned(),
            1 => text(self.median()),
            _ => {
                let [low, high] = self.range();
                format!("{} ({} to {})", text(self.median()), text(low), text(high))
            }
        }
    }
}

impl FromIterator<f64> for Sample {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Sample {
        Sample(values.into_iter().collect())
    }
}

/// The largest size of all; NaN if any is none or there is none.
pub fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    // Not f64::max, which drops what is no number.
    let larger = |m: f64, v: f64| if m.is_nan() || v <= m { m } else { v };
    values.into_iter().map(f64::abs).reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_is_what_is_no_number() {
        assert_eq!(worst([1.0, -3.0, 2.0]), 3.0);
        assert!(worst([1.0, f64::NAN, 0.5]).is_nan() && worst([f64::NAN, 2.0]).is_nan());
        assert!(worst([]).is_nan());
    }

    #[test]
    fn the_median_stands_in_the_middle() {
        assert_eq!(Sample(vec![3.0, 1.0, 2.0]).median(), 2.0);
        assert_eq!(Sample(vec![4.0, 1.0, 2.0, 3.0]).median(), 2.5);
        assert!(Sample::default().median().is_nan());
        assert_eq!(Sample(vec![6.0, 1.0, 2.0]).mean(), 3.0);
        assert!(Sample::default().mean().is_nan());
        assert_eq!(Sample(vec![5.0, 2.0, 1.0, 4.0, 3.0]).quartiles(), [2.0, 4.0]);
        assert_eq!(Sample(vec![2.0, 1.0]).quartiles(), [1.25, 1.75]);
        assert_eq!(Sample(vec![2.0]).quartiles(), [2.0; 2]);
        assert!(Sample::default().quartiles()[0].is_nan());
        assert_eq!(Sample(vec![3.0, 1.0]).range(), [1.0, 3.0]);
        assert_eq!(Sample(vec![0.003, 0.001, 0.002]).show(1e-3), "2 (1 to 3)");
    }
}
