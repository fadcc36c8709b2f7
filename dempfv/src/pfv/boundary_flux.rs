//! Where the flux through the walls is taken.

use super::{NONE, Network};

/// Throats this much wider than the median one do not resolve what flows
/// through them: the pressures on both sides are equal to the last digits.
const WIDE: f64 = 1e4;

/// Surfaces around the pores with imposed pressure, one for each wall: what
/// passes them, with what the pores within them swallow, is what the wall
/// lets through.
///
/// A surface encloses its wall's pores, and the free ones that wide throats
/// join to these. In lattices, whose pores coincide in clusters, a free pore
/// may have a wall's pore for a twin.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundaryFlux {
    /// Pores within a surface, and its wall.
    pores: Vec<(u32, u8)>,
    /// Throats across a surface: the pore within, the one outside, the wall.
    throats: Vec<([u32; 2], u8)>,
    /// Their numbers, and their conductances (m³/(Pa·s)).
    numbers: Vec<u32>,
    conductance: Vec<f64>,
}

impl BoundaryFlux {
    /// `imposed_by` has the index of the wall that imposes a pore's pressure,
    /// 6 for none.
    pub fn new(network: &Network, imposed_by: &[u8]) -> BoundaryFlux {
        let within = grow(network, imposed_by);
        let mut boundary_flux = BoundaryFlux::default();
        for (i, &wall) in within.iter().enumerate().filter(|(_, wall)| **wall < 6) {
            boundary_flux.pores.push((i as u32, wall));
            let around = network.tessellation.neighbors[i];
            for (j, number) in around.into_iter().zip(network.throat_of[i]) {
                if j != NONE && within[j as usize] != wall {
                    boundary_flux.throats.push(([i as u32, j], wall));
                    boundary_flux.numbers.push(number);
                }
            }
        }
        boundary_flux.conductance = vec![0.0; boundary_flux.numbers.len()];
        boundary_flux.follow(&network.throats.conductance);
        boundary_flux
    }

    /// Takes other conductances of the same throats (m³/(Pa·s)).
    pub fn follow(&mut self, conductance: &[f64]) {
        for (g, &number) in self.conductance.iter_mut().zip(&self.numbers) {
            *g = conductance[number as usize];
        }
    }

    /// Flux through each wall, positive into the box (m³/s).
    pub fn flux(&self, pressure: &[f64], volume_rate: &[f64]) -> [f64; 6] {
        let mut flux = [0.0; 6];
        for &(pore, wall) in &self.pores {
            flux[wall as usize] += volume_rate[pore as usize];
        }
        for (&([i, j], wall), g) in self.throats.iter().zip(&self.conductance) {
            flux[wall as usize] += g * (pressure[i as usize] - pressure[j as usize]);
        }
        flux
    }
}

/// The wall whose surface encloses each pore; 6 for none.
fn grow(network: &Network, imposed_by: &[u8]) -> Vec<u8> {
    let wide = WIDE * median(&network.throats.conductance);
    let mut within = imposed_by.to_vec();
    let mut todo: Vec<u32> = (0..within.len() as u32).filter(|&i| within[i as usize] < 6).collect();
    while let Some(i) = todo.pop() {
        let around = network.tessellation.neighbors[i as usize];
        for (j, g) in around.into_iter().zip(network.conductances_of(i as usize)) {
            if j != NONE && g > wide && within[j as usize] == 6 {
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
