//! Pressures of one network for the pores of another of the same spheres.

use super::operators::Incidence;
use super::periodic::nearest as nearest_copy;
use super::pore_pressures::PorePressures;
use super::{Network, Operators};
use crate::parallel::for_each;
use crate::{Cell, Vec3};

/// The pressures of a network that has been replaced.
///
/// A pore of the new network that has the same four vertices as an old one has
/// its pressure; another has that of the old pore whose centre is nearest to
/// its own, among those that share a sphere with it.
#[derive(Debug)]
pub struct TransferSource {
    spheres: usize,
    cells: Vec<[u32; 4]>,
    center: Vec<Vec3>,
    /// Where there is one: any copies of two pores are as near as the nearest two.
    cell: Option<Cell>,
    pressures: PorePressures,
    around: Incidence,
    /// What the pores stored above the reference (m³), and would per unit of pressure (m³/Pa), where
    /// they do.
    content: Option<(f64, f64)>,
}

impl TransferSource {
    pub(super) fn new(
        network: Network,
        around: Incidence,
        pressures: PorePressures,
        content: Option<(f64, f64)>,
    ) -> TransferSource {
        let Network { tessellation, center, periodic, .. } = network;
        TransferSource {
            spheres: tessellation.spheres,
            cells: tessellation.cells,
            center,
            cell: periodic.map(|periodic| periodic.cell),
            pressures,
            around,
            content,
        }
    }

    /// What the pores stored above a reference (Pa), for another network of the same spheres (m³).
    pub(super) fn content_for(&self, network: &Network, reference: f64) -> Option<f64> {
        let shift = self.pressures.reference - reference;
        let content = self.content.map(|(above, capacity)| above + capacity * shift);
        content.filter(|_| network.tessellation.spheres == self.spheres)
    }

    /// Writes the pressures (Pa, above the reference) of another network's unknowns. Leaves them
    /// as they are where that network has another number of spheres.
    pub(super) fn write(
        &self,
        network: &Network,
        operators: &Operators,
        reference: f64,
        solution: &mut [f64],
    ) {
        if network.tessellation.spheres != self.spheres {
            return;
        }
        let shift = self.pressures.reference - reference;
        for_each(solution, &|u, p| {
            let pore = operators.pore_of[u] as usize;
            let old = self.counterpart(&network.tessellation.cells[pore], &network.center[pore]);
            *p = self.pressures.relative[old] + shift;
        });
    }

    /// The old pore with these vertices, or the nearest.
    fn counterpart(&self, cell: &[u32; 4], center: &Vec3) -> usize {
        let spheres = || cell.iter().filter(|&&v| (v as usize) < self.spheres);
        let around = |&v: &u32| self.around.of(v as usize).iter().map(|&p| p as usize);
        // A cell of three walls and a sphere lies around one sphere only.
        if let Some(same) = spheres()
            .take(1)
            .flat_map(around)
            .find(|&old| cell.iter().all(|v| self.cells[old].contains(v)))
        {
            return same;
        }
        let nearest = |pores: &mut dyn Iterator<Item = usize>| {
            pores.fold(None, |best: Option<(usize, f64)>, old| {
                let mut way = self.center[old] - center;
                if let Some(cell) = &self.cell {
                    way = nearest_copy(&way, cell);
                }
                let d2 = way.norm_squared();
                if best.is_none_or(|(_, least)| d2 < least) { Some((old, d2)) } else { best }
            })
        };
        // Spheres that were all hidden before have no old pore around them.
        nearest(&mut spheres().flat_map(around))
            .or_else(|| nearest(&mut (0..self.cells.len())))
            .map_or(0, |(old, _)| old)
    }
}
