//! Estimated errors of the pore pressures, gathered over a run.

use serde::{Deserialize, Serialize};

/// Squares of pressures and of their errors at the spheres, over model time (Pa²·s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gathered {
    /// Of the pressures.
    pressure: f64,
    /// Of what the age of networks makes wrong.
    network: f64,
    /// Of what the length of the steps does.
    time_step: f64,
    /// Of what solves leave.
    solver: f64,
    /// Of the pressures since the network in use came, and how long that is (s).
    interval: f64,
    /// Model time (s).
    time: f64,
}

/// Relative errors of the moment (1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rates {
    /// Of pressures by the time step.
    pub time_step: f64,
    /// Of pressures by what solves leave.
    pub solver: f64,
    /// Of pressures by a network of the largest age.
    pub network: f64,
}

/// An estimate of the error of the pore pressures of a run (1): the root of the mean square over the spheres
/// and over model time, beside that of the pressures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// All together: the root of the sum of squares.
    pub total: f64,
    /// By the age of networks.
    pub network: f64,
    /// By the time step.
    pub time_step: f64,
    /// By the solver's tolerance.
    pub solver: f64,
}

impl Gathered {
    /// Adds a time (s) with pressures of this mean square (Pa²).
    pub fn add(&mut self, time: f64, pressure_squared: f64, rates: &Rates) {
        let weight = time * pressure_squared;
        self.time += time;
        self.pressure += weight;
        self.interval += weight;
        self.time_step += rates.time_step.powi(2) * weight;
        self.solver += rates.solver.powi(2) * weight;
    }

    /// A network is replaced that came to this relative error (1); `shape` is the mean square of the error
    /// over its time over that at the end.
    pub fn replaced(&mut self, relative: f64, shape: f64) {
        self.network += shape * relative.powi(2) * std::mem::take(&mut self.interval);
    }

    /// Root of the mean square of all pressures so far (Pa).
    pub fn mean_pressure(&self) -> f64 {
        if self.time > 0.0 { (self.pressure / self.time).sqrt() } else { 0.0 }
    }

    /// The estimate; `open` is the mean square of the relative error of the network in use. `None` before
    /// there was a pressure.
    pub fn estimate(&self, open: f64) -> Option<ErrorEstimate> {
        let relative = |square: f64| (square / self.pressure).sqrt();
        let network = self.network + open * self.interval;
        (self.pressure > 0.0).then(|| ErrorEstimate {
            total: relative(network + self.time_step + self.solver),
            network: relative(network),
            time_step: relative(self.time_step),
            solver: relative(self.solver),
        })
    }
}
