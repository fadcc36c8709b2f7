//! Where the flux from pores with an imposed pressure is taken.

use super::{NONE, Network, PoreConditions};

/// Throats that conduct so many times what the median one does do not resolve the flow
/// through them: the pressures on both sides are equal to the last digits.
const UNRESOLVED_CONDUCTANCE_RATIO: f64 = 1e4;

/// Surfaces around the pores with imposed pressure, one for each set: what
/// passes them, with what the pores within them swallow, is what the set
/// lets through.
///
/// A surface encloses its set's pores, and the free ones that unresolved throats
/// join to these. In lattices, whose pores coincide in clusters, a free pore
/// may have a wall's pore for a twin.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundaryFlux {
    /// Pores within a surface, and its set.
    pores: Vec<(u32, u32)>,
    /// Throats across a surface: the pore within, the one outside, the set.
    throats: Vec<([u32; 2], u32)>,
    /// Their numbers, and their conductances (m³/(Pa·s)).
    numbers: Vec<u32>,
    conductance: Vec<f64>,
}

impl BoundaryFlux {
    /// The surfaces around the sets of these conditions.
    pub fn new(network: &Network, conditions: &PoreConditions) -> BoundaryFlux {
        let within = grow(network, conditions);
        let mut boundary_flux = BoundaryFlux::default();
        for (i, &set) in within.iter().enumerate().filter(|(_, set)| **set != NONE) {
            boundary_flux.pores.push((i as u32, set));
            let around = network.tessellation.neighbors[i];
            for (j, number) in around.into_iter().zip(network.throat_of[i]) {
                if j != NONE && within[j as usize] != set {
                    boundary_flux.throats.push(([i as u32, j], set));
                    boundary_flux.numbers.push(number);
                }
            }
        }
        boundary_flux.conductance = vec![0.0; boundary_flux.numbers.len()];
        boundary_flux.update(&network.throats.conductance);
        boundary_flux
    }

    /// Takes other conductances of the same throats (m³/(Pa·s)).
    pub fn update(&mut self, conductance: &[f64]) {
        for (g, &number) in self.conductance.iter_mut().zip(&self.numbers) {
            *g = conductance[number as usize];
        }
    }

    /// Writes the flux into the pores from each set (m³/s): as many as `flux` has room for,
    /// in their order.
    pub fn write(&self, pressure: &[f64], volume_rate: &[f64], flux: &mut [f64]) {
        flux.fill(0.0);
        for &(pore, set) in &self.pores {
            if let Some(flux) = flux.get_mut(set as usize) {
                *flux += volume_rate[pore as usize];
            }
        }
        for (&([i, j], set), g) in self.throats.iter().zip(&self.conductance) {
            if let Some(flux) = flux.get_mut(set as usize) {
                *flux += g * (pressure[i as usize] - pressure[j as usize]);
            }
        }
    }
}

/// The set whose surface encloses each pore; [`NONE`] for none.
fn grow(network: &Network, conditions: &PoreConditions) -> Vec<u32> {
    let unresolved = UNRESOLVED_CONDUCTANCE_RATIO * median(&network.throats.conductance);
    let set = |pore| conditions.set_of(pore).map_or(NONE, |set| set as u32);
    let mut within: Vec<u32> = (0..network.pores()).map(set).collect();
    let mut todo: Vec<u32> =
        (0..within.len() as u32).filter(|&i| within[i as usize] != NONE).collect();
    while let Some(i) = todo.pop() {
        let around = network.tessellation.neighbors[i as usize];
        for (j, g) in around.into_iter().zip(network.conductances_of(i as usize)) {
            if j != NONE && g > unresolved && within[j as usize] == NONE {
                within[j as usize] = within[i as usize];
                todo.push(j);
            }
        }
    }
    within
}

fn median(conductance: &[f64]) -> f64 {
    let mut open: Vec<f64> = conductance.iter().copied().filter(|g| *g > 0.0).collect();
    if open.is_empty() {
        return 0.0;
    }
    let middle = open.len() / 2;
    *open.select_nth_unstable_by(middle, f64::total_cmp).1
}
