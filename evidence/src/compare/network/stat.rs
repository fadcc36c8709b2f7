//! How far many values are apart.

use serde::{Deserialize, Serialize};

/// Differences of one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stat {
    /// Number of values.
    pub count: usize,
    /// The largest; infinite where one is not finite.
    pub largest: f64,
    /// The median.
    pub median: f64,
}

impl Stat {
    /// Of differences without their signs. Zero where there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Stat {
        // JSON has no NaN, and none may pass for a small difference.
        let number = |v: f64| if v.is_finite() { v.abs() } else { f64::MAX };
        let mut values: Vec<f64> = values.into_iter().map(number).collect();
        values.sort_unstable_by(f64::total_cmp);
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        let count = values.len();
        Stat { count, largest: at(count.saturating_sub(1)), median: at(count / 2) }
    }

    /// Of the relative differences of two rows of positive values.
    pub fn relative(pairs: impl IntoIterator<Item = (f64, f64)>) -> Stat {
        Stat::of(pairs.into_iter().map(|(a, b)| a / b - 1.0))
    }

    /// Largest and median as a table cell.
    pub fn cell(&self) -> String {
        match self.count {
            0 => "–".to_owned(),
            _ => format!("{} / {}", number(self.largest), number(self.median)),
        }
    }
}

/// A difference as people read it.
pub fn number(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_is_no_number_passes_for_small() {
        let stat = Stat::of([1e-9, f64::NAN, -3e-9]);
        assert_eq!(stat, Stat { count: 3, largest: f64::MAX, median: 3e-9 });
        assert_eq!(Stat::of([]).largest, 0.0);
        assert_eq!(Stat::relative([(1.5, 1.0), (0.0, 0.0)]).largest, f64::MAX);
    }
}
