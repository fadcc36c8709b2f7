//! What pores store, in the matrix of a network and in its solves.
//!
//! Where pores have no path to an imposed pressure, only what they store determines their mean
//! pressure. The stiffer the fluid, the nearer their part of the matrix is to a singular one, so the
//! factor is that of pores that store a little more, and their mean is found from their balance as a
//! whole, in which all throats cancel.

use super::Operators;
use super::storage::Storage;

/// What a pore without a path to an imposed pressure stores in the factor at least, relative to the
/// conductances of its throats: enough for a factor with few digits, and so little that but the mean
/// of such pores feels it.
const LEAST_IN_FACTOR: f64 = 1e-9;

impl Operators {
    /// What the pores store, where a term stores fluid.
    pub(super) fn storage(&self) -> Option<&Storage> {
        self.storage.as_deref()
    }

    /// A step begins at these pressures (Pa, above the reference), where a term stores fluid.
    pub(super) fn begin_storing(&mut self, reference: f64, pressure: &[f64]) {
        if self.storage.is_some() {
            let level = self.conditions().mean_pressure() - reference;
            self.storage.iter_mut().for_each(|storage| storage.begin(pressure, level));
        }
    }

    /// Takes the storage up into the matrix whose diagonal has the conductances alone.
    pub(super) fn write_diagonal(&mut self) {
        let Operators { matrix, pore_of, storage: Some(storage), .. } = self else { return };
        let conductances = |u: usize| self.stencil[u].conductance.iter().sum::<f64>();
        for (u, &pore) in pore_of.iter().enumerate() {
            matrix.values[matrix.col_ptr[u] as usize] =
                conductances(u) + storage.rate(pore as usize);
        }
        for &u in storage.closed.iter().flatten() {
            let (u, pore) = (u as usize, pore_of[u as usize] as usize);
            let stored = storage.rate(pore).max(LEAST_IN_FACTOR * conductances(u));
            matrix.values[matrix.col_ptr[u] as usize] = conductances(u) + stored;
        }
    }

    /// Changes the mean pressure of each closed group so that the group takes up no more than it
    /// is given: `residual` (m³/s, by unknowns) is that of the new pressures afterwards.
    /// `shift` is told each unknown and the change (Pa).
    pub(super) fn level_closed(&self, residual: &mut [f64], mut shift: impl FnMut(usize, f64)) {
        let Some(storage) = self.storage() else { return };
        for group in &storage.closed {
            let rate = |u: u32| storage.rate(self.pore_of[u as usize] as usize);
            let (given, taken) =
                group.iter().fold((0.0, 0.0), |(r, c), &u| (r + residual[u as usize], c + rate(u)));
            let change = given / taken;
            for &u in group {
                residual[u as usize] -= rate(u) * change;
                shift(u as usize, change);
            }
        }
    }

    /// Whether there are closed groups.
    pub(super) fn has_closed(&self) -> bool {
        self.storage().is_some_and(|storage| !storage.closed.is_empty())
    }
}
