//! One-dimensional consolidation of a packing whose first pores at both walls are layers of their own.

use std::f64::consts::PI;

use super::erfc::erfc;

/// Below this time no pressure has come from one end to the other: what the far end adds is
/// exp(-1 / 4 τ), 3e-16.
const SHORT_TIME: f64 = 0.007;
/// Terms of the series above it: the first one left out is below 1e-30.
const TERMS: usize = 32;

/// Terzaghi's consolidation with what the pores that touch a wall do to it.
///
/// A pore at a drained wall has the wall's pressure: this layer drains with the load and settles by a
/// share s of the final settlement at once. In the pores at a sealed wall the pressure is the same all
/// over: this layer swallows a share b of the settlement and resists no flow. A static flow from wall to
/// wall meets the resistance between both layers, so with the T_v of the whole specimen the rest has
/// τ = T_v / (1 − s − b), however thick the layers are. Its far end has a storage of
/// r = b / (1 − s − b) times its own:
///
/// U = s + (1−s) \[1 − Σ exp(−β² τ) / (β² N (1+r))\], p/p₀ = Σ sin(β x) exp(−β² τ) / (β N),
/// β tan β = 1/r, N = ½ \[1 + r / (1 + r² β²)\], x from 0 at the drained layer to 1 at the sealed one.
///
/// Where both ends drain, s is that of both layers, b is 0, and T_v is that of half the height. Without
/// layers U is [`degree_of_consolidation`](super::degree_of_consolidation). The error is below 1e-13.
/// Shares below 0, or of 1 and more together, give no number.
///
/// Source: the slab that touches a perfect conductor, Carslaw and Jaeger (1959), chapter 3; the layers'
/// part in it is derived in `docs/oedometer.md`.
///
/// ```
/// use dempfv::theory::WallLayers;
/// let layers = WallLayers::new(0.1, 0.1);
/// assert_eq!(layers.degree(0.0), 0.1);
/// assert!((layers.degree(10.0) - 1.0).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLayers {
    drained: f64,
    /// Share of the settlement between both layers.
    between: f64,
    /// Storage of the sealed layer over that of what lies between.
    ratio: f64,
    beta: [f64; TERMS],
}

impl WallLayers {
    /// Layers with these shares of the final settlement, at drained walls and at a sealed one.
    pub fn new(drained: f64, sealed: f64) -> WallLayers {
        let between = 1.0 - drained - sealed;
        let valid = drained >= 0.0 && sealed >= 0.0 && between > 0.0;
        let between = if valid { between } else { f64::NAN };
        let ratio = sealed / between;
        WallLayers { drained, between, ratio, beta: std::array::from_fn(|k| root(k, ratio)) }
    }

    /// Degree of consolidation, 0 to 1. T_v below 0 count as 0.
    pub fn degree(&self, time_factor: f64) -> f64 {
        let tau = self.tau(time_factor);
        if tau < SHORT_TIME {
            return self.drained + self.between * 2.0 * (tau / PI).sqrt();
        }
        let left: f64 = (self.modes(tau))
            .map(|(beta, amplitude)| amplitude / (beta * beta * (1.0 + self.ratio)))
            .sum();
        1.0 - (1.0 - self.drained) * left
    }

    /// Excess pressure p / p₀ at a depth from 0, the end of the drained layer, to 1, the sealed
    /// one. Depths beyond these are in the layers.
    pub fn excess_pressure(&self, depth: f64, time_factor: f64) -> f64 {
        let tau = self.tau(time_factor);
        if depth.is_nan() || tau.is_nan() {
            return f64::NAN;
        }
        let x = depth.clamp(0.0, 1.0);
        match (x == 0.0, tau < SHORT_TIME) {
            (true, _) => 0.0,
            (_, true) => 1.0 - erfc(x / (2.0 * tau.sqrt())),
            (_, false) => self.modes(tau).map(|(beta, a)| a / beta * (beta * x).sin()).sum(),
        }
    }

    fn tau(&self, time_factor: f64) -> f64 {
        if time_factor.is_nan() { f64::NAN } else { time_factor.max(0.0) / self.between }
    }

    /// β and exp(−β² τ) / N, the smallest term first: no rounding is carried along.
    fn modes(&self, tau: f64) -> impl Iterator<Item = (f64, f64)> {
        let r = self.ratio;
        self.beta.into_iter().rev().map(move |beta| {
            let norm = 0.5 * (1.0 + r / (1.0 + (r * beta).powi(2)));
            (beta, (-beta * beta * tau).exp() / norm)
        })
    }
}

/// The root of cos β = r β sin β between kπ and (k + ½)π.
fn root(k: usize, ratio: f64) -> f64 {
    let (mut low, mut high) = (k as f64 * PI, (k as f64 + 0.5) * PI);
    let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    // Halving cannot fail, and so many leave nothing but rounding.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if sign * (middle.cos() - ratio * middle * middle.sin()) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
