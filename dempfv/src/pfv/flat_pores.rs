//! Where the centres of flat pores are.
//!
//! Four spheres in a plane and on a circle have equal power on a whole line across the plane. The
//! pores on both sides have their centres on that line, too, in the order of their facets, though
//! not always each on its own side of the plane. A flat pore's centre is between these two:
//! anywhere, as round-off or the least motion wants it. But hydraulic radii do not add up along a
//! way that is cut in two, so that the place of the cut, and whether there is one, would count.
//! Therefore a flat pore has the centre of a pore beside it: the two are joined as pores of
//! coinciding centres are, and across the plane stands one throat, as it does where the
//! triangulation has no flat pore there.

use rayon::prelude::*;

use super::frame::{FACETS, Frame};
use super::pore::flat_axis;
use super::throat::area_vector;
use super::{NONE, Tessellation};
use crate::Vec3;
use crate::parallel::TASK;

/// Flat pores may lie one upon another: a polygon of spheres split in several ways. So many are
/// looked through.
const MOST_STACKED: usize = 16;

/// A smaller share of a pore's largest facet is round-off.
const NO_AREA: f64 = 1e-9;

/// One component of a direction is larger than this; no lattice has it for a component.
const CLEAR_COMPONENT: f64 = 0.5687;

/// The flat pores of a tessellation, in the order of their numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct FlatPores {
    pores: Vec<FlatPore>,
}

#[derive(Clone, Copy, Debug)]
struct FlatPore {
    number: u32,
    /// For each facet 1 where it looks along the axis across the pore, -1 where it looks against
    /// it, 0 where it has no area; all 0 where motion has made the pore an ordinary one.
    side: [f64; 4],
}

impl FlatPores {
    /// Finds them.
    pub fn of(frame: &Frame, t: &Tessellation) -> FlatPores {
        let cells = t.cells.par_iter().enumerate().with_min_len(TASK);
        let pores = cells.filter_map(|(i, &cell)| {
            Some(FlatPore { number: i as u32, side: sides(frame, cell)? })
        });
        FlatPores { pores: pores.collect() }
    }

    /// Gives each the centre of a pore beside it, for vertices that have moved.
    pub fn place(&mut self, frame: &Frame, t: &Tessellation, center: &mut [Vec3]) {
        self.place_across(frame, t, center, |_, _| Vec3::zeros());
    }

    /// The same in a periodic cell, where `shift` leads to the copy of the neighbour (m) that lies
    /// across a facet of a pore.
    pub fn place_across(
        &mut self,
        frame: &Frame,
        t: &Tessellation,
        center: &mut [Vec3],
        shift: impl Fn(u32, usize) -> Vec3,
    ) {
        for pore in &mut self.pores {
            pore.side = sides(frame, t.cells[pore.number as usize]).unwrap_or_default();
        }
        for pore in self.pores.iter().filter(|pore| pore.side != [0.0; 4]) {
            let beside =
                [-1.0, 1.0].into_iter().find_map(|side| self.beside(pore, side, t, &shift));
            if let Some((beside, shift)) = beside {
                center[pore.number as usize] = center[beside as usize] + shift;
            }
        }
    }

    /// Their numbers.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        self.pores.iter().map(|pore| pore.number as usize)
    }

    /// The first pore on one side that is not flat, and the way to the copy that is meant (m).
    fn beside(
        &self,
        pore: &FlatPore,
        side: f64,
        t: &Tessellation,
        shift: &impl Fn(u32, usize) -> Vec3,
    ) -> Option<(u32, Vec3)> {
        let (mut pore, mut way) = (pore, Vec3::zeros());
        for _ in 0..MOST_STACKED {
            let neighbors = t.neighbors[pore.number as usize];
            let mut around = (0..4).filter(|&k| neighbors[k] != NONE && pore.side[k] == side);
            let first = around.next()?;
            let mut all = std::iter::once(first).chain(around);
            if let Some(k) = all.find(|&k| self.flat(neighbors[k]).is_none()) {
                return Some((neighbors[k], way + shift(pore.number, k)));
            }
            way += shift(pore.number, first);
            pore = self.flat(neighbors[first])?;
        }
        None
    }

    fn flat(&self, number: u32) -> Option<&FlatPore> {
        let at = self.pores.binary_search_by_key(&number, |pore| pore.number).ok()?;
        self.pores.get(at).filter(|pore| pore.side != [0.0; 4])
    }
}

/// The sides of a flat pore's facets; `None` for other pores.
fn sides(frame: &Frame, cell: [u32; 4]) -> Option<[f64; 4]> {
    let axis = flat_axis(frame, cell)?;
    // Pores in one plane have one axis: all of them are to tell its ends apart in the same way.
    let clear = axis.iter().find(|a| a.abs() > CLEAR_COMPONENT)?;
    let axis = axis * clear.signum();
    let outward = |facet: [usize; 3]| area_vector(frame, facet.map(|k| cell[k]));
    let area = FACETS.map(|facet| outward(facet).map_or(0.0, |s| s.dot(&axis)));
    let largest = area.iter().fold(0.0f64, |most, a| most.max(a.abs()));
    Some(area.map(|a| if a.abs() > NO_AREA * largest { a.signum() } else { 0.0 }))
}
