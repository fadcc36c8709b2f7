//! The complementary error function.

use std::f64::consts::PI;

/// Complementary error function for x ≥ 0, to about 1e-15: the Maclaurin
/// series of erf below 2, Lentz's continued fraction above.
pub(super) fn erfc(x: f64) -> f64 {
    let scale = (-x * x).exp();
    if x < 2.0 {
        // erf(x) = 2/√π exp(−x²) Σ 2ⁿ x^(2n+1) / (2n+1)!!: no cancellation.
        let (mut term, mut sum, mut n) = (x, x, 0.0);
        while term > 1e-17 * sum {
            n += 1.0;
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
        }
        return 1.0 - 2.0 / PI.sqrt() * scale * sum;
    }
    // erfc(x) = exp(−x²)/√π · 1/(x + ½/(x + 1/(x + 3/2/(x + …)))), from the
    // inside out; 60 levels suffice from x = 2.
    let fraction = (1..=60).rev().fold(x, |tail, k| x + 0.5 * f64::from(k) / tail);
    scale / (PI.sqrt() * fraction)
}
