//! How large the entries of a vector are.

/// Entries side by side.
const LANES: usize = 8;

/// Largest size of an entry; not a number if any entry is not finite.
#[inline]
pub fn max_norm(x: &[f64]) -> f64 {
    let (mut most, mut odd) = ([0.0f64; LANES], [0.0f64; LANES]);
    let (chunks, rest) = x.as_chunks::<LANES>();
    let mut take = |x: &[f64]| {
        for ((most, odd), x) in most.iter_mut().zip(&mut odd).zip(x) {
            let size = x.abs();
            *most = if size > *most { size } else { *most };
            // Zero, or no number from here on.
            *odd += 0.0 * x;
        }
    };
    chunks.iter().for_each(|chunk| take(chunk));
    take(rest);
    let sum: f64 = odd.iter().sum();
    if sum == 0.0 { most.into_iter().fold(0.0, f64::max) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last entry, the largest by its sign, one in the middle; and one that is no number
    /// or infinite anywhere.
    #[test]
    fn the_largest_is_found() {
        assert_eq!(max_norm(&[]), 0.0);
        for n in [1, 7, 8, 9, 40, 43] {
            for at in 0..n {
                let mut x: Vec<f64> = (0..n).map(|k| k as f64 / 100.0).collect();
                x[at] = -3.0;
                assert_eq!(max_norm(&x), 3.0);
                for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    x[at] = odd;
                    assert!(max_norm(&x).is_nan());
                }
            }
        }
    }
}
