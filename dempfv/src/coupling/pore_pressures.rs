//! Pore pressures of parts of the box, and with the fluid's weight.

use super::coupled::Coupled;
use crate::{Aabb, Vec3};

impl Coupled {
    /// Smallest pore pressure (Pa); 0 where the pores are empty.
    pub fn smallest_pressure(&self) -> f64 {
        let least = |p: &[f64]| p.iter().copied().fold(f64::INFINITY, f64::min);
        self.storage_flow().map_or(0.0, |flow| least(flow.pressure()))
    }

    /// Mean pressure by volume of the pores whose centroid lies in a region, where they are now (Pa). Not
    /// a number where there are none.
    pub fn mean_pressure_within(&self, region: &Aabb) -> f64 {
        let Some(flow) = self.storage_flow() else { return f64::NAN };
        let Some(centroids) = self.centroids() else { return f64::NAN };
        let pores = centroids.iter().zip(&flow.network().volume).zip(flow.pressure());
        let (weighted, volume) = pores
            .filter(|((x, _), _)| region.contains(x))
            .fold((0.0, 0.0), |(s, v), ((_, volume), p)| (s + volume * p, v + volume));
        weighted / volume
    }

    /// Whether the fluid in the pores has a weight: pressures are then those in excess of the
    /// hydrostatic one.
    pub fn fluid_has_weight(&self) -> bool {
        self.effects.density.is_some() && self.dem.options().gravity.is_some()
    }

    /// The pressure of each pore with the hydrostatic one at its centroid (Pa); `None` where the
    /// pores are empty.
    pub fn total_pressures(&self) -> Option<Vec<f64>> {
        let flow = self.storage_flow()?;
        let total = |(x, p): (&Vec3, &f64)| p + flow.hydrostatic_pressure(x);
        Some(self.centroids()?.iter().zip(flow.pressure()).map(total).collect())
    }

    /// As [`Coupled::probe_pressures`], with the hydrostatic pressure at each point (Pa).
    pub fn probe_total_pressures(&self) -> impl Iterator<Item = f64> + '_ {
        let flow = self.storage_flow();
        let hydrostatic = move |x: &Vec3| flow.map_or(f64::NAN, |f| f.hydrostatic_pressure(x));
        self.probe_pressures().zip(&self.probes).map(move |(p, x)| p + hydrostatic(x))
    }

    /// Of the pores between walls.
    fn centroids(&self) -> Option<Vec<Vec3>> {
        if self.dem.cell().is_some() {
            return None;
        }
        let network = self.storage_flow()?.network();
        network.centroids(&self.dem.storage().position, &self.dem.box_()).ok()
    }
}
