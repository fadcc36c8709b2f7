//! What seeds have in common and what separates them.

use serde::Serialize;

use super::specimen::Specimen;
use crate::bench::sample::Sample;

/// A quantity of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Mean of the three axes over the square of Sauter's diameter (1).
    Permeability,
    /// The same along the load alone (1).
    PermeabilityAlongLoad,
    /// The mean of the three axes again, without what is near walls (1).
    CorePermeability,
    /// Pa.
    #[serde(rename = "modulus_pa")]
    Modulus,
    /// 1.
    Porosity,
}

impl Quantity {
    pub const ALL: [Quantity; 5] = [
        Quantity::Permeability,
        Quantity::PermeabilityAlongLoad,
        Quantity::CorePermeability,
        Quantity::Modulus,
        Quantity::Porosity,
    ];

    pub fn key(self) -> &'static str {
        match self {
            Quantity::Permeability => "permeability",
            Quantity::PermeabilityAlongLoad => "permeability_along_load",
            Quantity::CorePermeability => "core_permeability",
            Quantity::Modulus => "modulus_pa",
            Quantity::Porosity => "porosity",
        }
    }

    /// Its value; not a number where the specimen has none.
    pub fn of(self, specimen: &Specimen) -> f64 {
        let square = specimen.sauter_diameter_m.powi(2);
        let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0 / square;
        match self {
            Quantity::Permeability => mean(specimen.permeability_m2),
            Quantity::PermeabilityAlongLoad => specimen.permeability_m2[1] / square,
            Quantity::CorePermeability => {
                mean(specimen.core_permeability_m2.map(|k| k.unwrap_or(f64::NAN)))
            }
            Quantity::Modulus => specimen.modulus_pa,
            Quantity::Porosity => specimen.porosity,
        }
    }
}

/// A quantity of all specimens of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Statistic {
    pub quantity: Quantity,
    pub mean: f64,
    /// Of one specimen, from the specimens themselves (n − 1).
    pub standard_deviation: f64,
    /// Of the mean.
    pub standard_error: f64,
}

impl Statistic {
    fn of(quantity: Quantity, values: Sample) -> Statistic {
        let (mean, count) = (values.mean(), values.0.len() as f64);
        let squares: f64 = values.0.iter().map(|v| (v - mean).powi(2)).sum();
        let standard_deviation = (squares / (count - 1.0)).sqrt();
        Statistic {
            quantity,
            mean,
            standard_deviation,
            standard_error: standard_deviation / count.sqrt(),
        }
    }

    /// Standard deviation over the mean (1).
    pub fn spread(&self) -> f64 {
        self.standard_deviation / self.mean
    }
}

/// All specimens of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Size {
    pub spheres: u32,
    /// Edge of the box over Sauter's diameter (1), mean.
    pub edge: f64,
    pub statistics: Vec<Statistic>,
    pub specimens: Vec<Specimen>,
}

impl Size {
    pub fn of(spheres: u32, specimens: Vec<Specimen>) -> Size {
        let of = |quantity: Quantity| {
            Statistic::of(quantity, specimens.iter().map(|s| quantity.of(s)).collect())
        };
        let edge: Sample = specimens.iter().map(|s| 1.0 / s.sauter_diameter_m).collect();
        let statistics = Quantity::ALL.map(of).to_vec();
        Size { spheres, edge: edge.mean(), statistics, specimens }
    }

    pub fn of_quantity(&self, quantity: Quantity) -> &Statistic {
        let at = Quantity::ALL.iter().position(|q| *q == quantity).unwrap_or_default();
        &self.statistics[at]
    }
}

/// A power law through spreads over numbers of spheres, by least squares over the logarithms.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Law {
    pub quantity: Quantity,
    pub exponent: f64,
    /// Spread of a single sphere's worth (1).
    pub factor: f64,
}

impl Law {
    /// `None` below three sizes that have a spread.
    pub fn fit(quantity: Quantity, sizes: &[Size]) -> Option<Law> {
        let spread = |size: &Size| size.of_quantity(quantity).spread();
        let logs: Vec<(f64, f64)> = sizes
            .iter()
            .filter(|size| spread(size) > 0.0)
            .map(|size| (f64::from(size.spheres).ln(), spread(size).ln()))
            .collect();
        if logs.len() < 3 {
            return None;
        }
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).collect::<Sample>().mean();
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let exponent = covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
        Some(Law { quantity, exponent, factor: (y - exponent * x).exp() })
    }

    pub fn at(&self, spheres: f64) -> f64 {
        self.factor * spheres.powf(self.exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(spheres: u32, moduli: &[f64]) -> Size {
        let specimen = |(i, &modulus_pa): (usize, &f64)| Specimen {
            spheres,
            seed: i as u64,
            porosity: 0.4,
            sauter_diameter_m: 0.1,
            permeability_m2: [1e-5, 2e-5, 3e-5],
            core_permeability_m2: [Some(1e-5), None, None],
            modulus_pa,
            steps: 1,
            seconds: 1.0,
        };
        Size::of(spheres, moduli.iter().enumerate().map(specimen).collect())
    }

    /// By hand: 9, 10 and 11 have the standard deviation 1, and their mean one of 1/√3.
    #[test]
    fn deviations_and_errors() {
        let size = size(100, &[9.0, 10.0, 11.0]);
        let modulus = size.of_quantity(Quantity::Modulus);
        assert_eq!((modulus.mean, modulus.standard_deviation), (10.0, 1.0));
        assert!((modulus.standard_error - 1.0 / 3f64.sqrt()).abs() < 1e-15);
        let mean = |quantity| size.of_quantity(quantity).mean;
        assert!((mean(Quantity::Permeability) - 2e-3).abs() < 1e-15);
        assert!((mean(Quantity::PermeabilityAlongLoad) - 2e-3).abs() < 1e-15);
        assert!(mean(Quantity::CorePermeability).is_nan());
        assert!((size.edge - 10.0).abs() < 1e-12);
    }

    /// Spreads of 10, 5 and 2.5 % of 100, 400 and 1,600 spheres fall with the root.
    #[test]
    fn independent_pores_have_the_exponent_of_a_half() {
        let at = |spheres, off: f64| size(spheres, &[100.0 - off, 100.0, 100.0 + off]);
        let sizes = [at(100, 10.0), at(400, 5.0), at(1600, 2.5)];
        let law = Law::fit(Quantity::Modulus, &sizes).unwrap();
        assert!((law.exponent + 0.5).abs() < 1e-12, "{law:?}");
        assert!((law.at(400.0) - 0.05).abs() < 1e-12, "{law:?}");
        assert!(Law::fit(Quantity::Modulus, &sizes[..2]).is_none());
        assert!(Law::fit(Quantity::CorePermeability, &sizes).is_none());
    }
}
