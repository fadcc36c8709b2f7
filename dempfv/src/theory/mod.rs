//! Closed forms that simulations are held against: one-dimensional
//! consolidation (Terzaghi) and the permeability of a bed of spheres (Kozeny
//! and Carman).

mod erfc;
mod wall_layers;

use std::f64::consts::PI;

use erfc::erfc;
pub use wall_layers::WallLayers;

/// Below this time factor the short-time series need fewer terms than the
/// long-time ones. At the switch both are exact to rounding.
const SHORT_TIME: f64 = 0.1;
/// Terms of either series: the first one left out is below 1e-17.
const TERMS: u32 = 12;

/// Degree of consolidation U(T_v), 0 to 1: the share of the final settlement
/// reached at time factor T_v = c_v t / H², for a layer of height H that drains
/// at one end and whose initial excess pressure is uniform.
///
/// U = 1 − Σ 2/M² exp(−M² T_v), M = π/2 (2k+1), k = 0, 1, … That series is
/// slow at small T_v; there its equal by reflection at the ends is summed,
/// U = 2 √(T_v/π) \[1 + 2 Σ (−1)ⁿ F(n/√T_v)\], n = 1, 2, …, with
/// F(a) = exp(−a²) − a √π erfc(a). The error is below 1e-14 for any T_v.
/// Negative T_v count as 0; not a number for one that is none.
///
/// Source: Terzaghi and Fröhlich (1936); Carslaw and Jaeger (1959), §3.4.
///
/// ```
/// use dempfv::theory::degree_of_consolidation;
/// assert!((degree_of_consolidation(0.197) - 0.50).abs() < 1e-3);
/// ```
pub fn degree_of_consolidation(time_factor: f64) -> f64 {
    if time_factor <= 0.0 {
        return 0.0;
    }
    if time_factor < SHORT_TIME {
        // F(a) falls faster than exp(−a²), so with a ≥ 1/√0.1 the first
        // reflection (4e-6 at the switch) and the next (1e-19) are all.
        let reflections: f64 = (1..=2)
            .map(|n| {
                let a = f64::from(n) / time_factor.sqrt();
                alternating(n) * ((-a * a).exp() - a * PI.sqrt() * erfc(a))
            })
            .sum();
        return 2.0 * (time_factor / PI).sqrt() * (1.0 + 2.0 * reflections);
    }
    // From the smallest term to the largest: no rounding is carried along.
    let left: f64 =
        (0..TERMS).rev().map(|k| 2.0 / m(k).powi(2) * (-m(k).powi(2) * time_factor).exp()).sum();
    1.0 - left
}

/// Excess pressure p(z, T_v) / p₀ in the layer of
/// [`degree_of_consolidation`], with z/H = 0 at the drained end and 1 at the
/// sealed one.
///
/// p/p₀ = Σ 2/M sin(M z/H) exp(−M² T_v), M = π/2 (2k+1); at small T_v
/// p/p₀ = 1 − Σ (−1)ⁿ \[erfc((2n + z/H) / 2√T_v) + erfc((2n + 2 − z/H) / 2√T_v)\],
/// n = 0, 1, … The error is below 1e-14 for any T_v; 1 inside for T_v ≤ 0. Depths beyond the ends
/// count as the ends; not a number where one of the two is none.
pub fn excess_pressure(depth: f64, time_factor: f64) -> f64 {
    if depth.is_nan() || time_factor.is_nan() {
        return f64::NAN;
    }
    let z = depth.clamp(0.0, 1.0);
    if z == 0.0 {
        return 0.0;
    }
    if time_factor <= 0.0 {
        return 1.0;
    }
    if time_factor < SHORT_TIME {
        let root = 2.0 * time_factor.sqrt();
        let reflections: f64 = (0..3)
            .map(|n| {
                let n2 = 2.0 * f64::from(n);
                alternating(n) * (erfc((n2 + z) / root) + erfc((n2 + 2.0 - z) / root))
            })
            .sum();
        return 1.0 - reflections;
    }
    (0..TERMS)
        .rev()
        .map(|k| 2.0 / m(k) * (m(k) * z).sin() * (-m(k).powi(2) * time_factor).exp())
        .sum()
}

/// Excess pressure p(z, T_v) / p₀ in a layer that drains at both ends, with
/// z/H from 0 at one to 1 at the other: that of two layers of half the height,
/// [`excess_pressure`], sealed where they meet. T_v = c_v t / (H/2)².
pub fn excess_pressure_both_ends(depth: f64, time_factor: f64) -> f64 {
    excess_pressure(1.0 - (1.0 - 2.0 * depth).abs(), time_factor)
}

/// The time factor at which a degree of consolidation (0 ≤ U < 1) is reached:
/// the inverse of [`degree_of_consolidation`], to rounding. 0 for U ≤ 0,
/// infinite for U ≥ 1, and not a number for one that is none.
///
/// ```
/// use dempfv::theory::time_factor;
/// assert!((time_factor(0.9) - 0.848).abs() < 1e-3);
/// ```
pub fn time_factor(degree: f64) -> f64 {
    if degree <= 0.0 {
        return 0.0;
    }
    if degree.is_nan() {
        return f64::NAN;
    }
    if degree >= 1.0 {
        return f64::INFINITY;
    }
    // Both ends of the curve bound it: U ≤ 2√(T/π), and 1 − U ≤ exp(−M₀² T).
    let (mut low, mut high) = (PI / 4.0 * degree * degree, -(1.0 - degree).ln() / m(0).powi(2));
    high = high.max(low);
    // Newton would do, but halving cannot fail and 64 evaluations are nothing.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if degree_of_consolidation(middle) < degree {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Constant of Kozeny and Carman: 36 for the surface of spheres, times 5 as Carman measured it.
pub const KOZENY_CARMAN: f64 = 180.0;

/// Kozeny-Carman permeability (m²) of spheres at porosity ε with a mean
/// diameter d (m): k = ε³ d² / (180 (1−ε)²). For spheres of unequal size the
/// diameter that keeps the specific surface is Sauter's, [`sauter_diameter`].
///
/// Infinite at a porosity of 1; not a number for one that is not from 0 to 1, and for a diameter
/// that is not positive.
///
/// Source: Carman (1937).
pub fn kozeny_carman(porosity: f64, diameter: f64) -> f64 {
    if !((0.0..=1.0).contains(&porosity) && diameter > 0.0) {
        return f64::NAN;
    }
    porosity.powi(3) * diameter * diameter / (KOZENY_CARMAN * (1.0 - porosity).powi(2))
}

/// Sauter mean diameter (m) of spheres, 2 Σ r³ / Σ r²: the diameter of equal
/// spheres with the same surface per volume. 0 without spheres; not a number where a radius is
/// not positive.
pub fn sauter_diameter(radius: &[f64]) -> f64 {
    if radius.iter().any(|r| r.is_nan() || *r <= 0.0) {
        return f64::NAN;
    }
    let sum = |power: i32| radius.iter().map(|r| r.powi(power)).sum::<f64>();
    if radius.is_empty() { 0.0 } else { 2.0 * sum(3) / sum(2) }
}

/// M_k = π/2 (2k+1).
fn m(k: u32) -> f64 {
    0.5 * PI * f64::from(2 * k + 1)
}

fn alternating(n: u32) -> f64 {
    if n.is_multiple_of(2) { 1.0 } else { -1.0 }
}
