//! A flow whose pores store fluid: its time step, their growth, what outlives a network or a stop.

use super::flow::unknown_points;
use super::packing_check::check_time_step;
use super::pore_growth::Place;
use super::storage::Storage;
use super::{Flow, PfvError, TransferSource};
use crate::solver::Backend;

impl Flow {
    /// Shifts the free pressures until the pores store what those of another network did. Both above
    /// the mean of the imposed pressures: what a drained box stores at that leaves with the volume
    /// that it loses, and must not come back as pressure.
    pub(super) fn keep_content(&mut self, from: &TransferSource) {
        let Flow { network, operators, extrapolation, pressures, .. } = self;
        let level = operators.conditions().mean_pressure();
        let content = from.content_for(network, level);
        let Some((storage, content)) = operators.storage().zip(content) else { return };
        let free = storage.free_capacity(&operators.pore_of);
        if free > 0.0 {
            let below = storage.whole_capacity() * (pressures.reference - level);
            let change = (content - storage.content(&pressures.relative) - below) / free;
            extrapolation.now.iter_mut().for_each(|p| *p += change);
            self.spread_pressures();
        }
    }

    /// Length of the steps to come (s), where a term stores fluid: else it is of no account.
    pub fn time_step(&self) -> Option<f64> {
        self.operators.storage().map(Storage::time_step)
    }

    /// Says how long the steps to come are (s). Where a term stores fluid the matrix goes with it:
    /// another step than the one before, beyond round-off, takes another factorization. Where the
    /// geometry has been updated ([`Flow::update_geometry`]) the factor stays, and
    /// [`Flow::iterate`] takes the difference. Returns whether there is another factor.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a time step that is not positive and finite;
    /// [`PfvError::Solver`] when the factorization fails.
    pub fn set_time_step(&mut self, time_step: f64) -> Result<bool, PfvError> {
        check_time_step(time_step)?;
        let Some(storage) = &mut self.operators.storage else { return Ok(false) };
        let factored = self.geometry.is_some() || self.operators.pore_of.is_empty();
        if storage.is_step(time_step) && (factored || self.solver.factor().is_some()) {
            return Ok(false);
        }
        storage.set_time_step(time_step);
        self.operators.write_diagonal();
        if !factored {
            self.renew_factor()?;
        }
        Ok(!factored)
    }

    fn renew_factor(&mut self) -> Result<(), PfvError> {
        let Flow { network, operators, backend, solver, .. } = self;
        let fresh = || {
            let points = unknown_points(network, operators);
            backend.analyze(&operators.matrix, Some(&points))?.factor(&operators.matrix)
        };
        Ok(solver.renew_factor(operators, fresh)?)
    }

    /// What each pore took up in the last solve, growth included (m³/s); empty without terms.
    pub(crate) fn taken(&self) -> &[f64] {
        self.terms.taken()
    }

    /// Takes what each pore took up in the last solve of an earlier flow through the same network.
    pub(crate) fn restore_taken(&mut self, taken: &[f64]) {
        if taken.len() == self.network.pores() {
            self.terms.restore(taken);
        }
    }

    /// Says where spheres and walls were when the growth of the pores was last taken, by another
    /// network. Of no account where no term stores fluid.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for positions that are not one per sphere.
    pub(crate) fn set_grown_to(&mut self, place: Place) -> Result<(), PfvError> {
        let Flow { network, operators, radius, .. } = self;
        let Some(storage) = &mut operators.storage else { return Ok(()) };
        match storage.grown.measure(network, radius, place)? {
            true => storage.grown.settle(),
            false => storage.grown.forget(),
        }
        Ok(())
    }

    /// As [`Flow::update_volume_rate`] where a term stores fluid: the pores have grown to their volumes
    /// at this place since the last call, and are taken to do so in the step to come. What many steps
    /// take up is what the volumes have changed by, to round-off.
    ///
    /// Says whether they have: in a periodic cell that has changed too much since the network was built
    /// nobody knows which copies of its spheres a pore has, and rates have to do. `before` is where they
    /// were in the last call.
    ///
    /// # Errors
    /// As [`Flow::set_grown_to`].
    pub(crate) fn grow_to(
        &mut self,
        place: Place,
        before: Option<Place>,
    ) -> Result<bool, PfvError> {
        let Flow { network, operators, volume_rate, radius, .. } = self;
        let Some(storage) = &mut operators.storage else { return Ok(false) };
        let time_step = storage.time_step();
        if let Some(before) = before.filter(|_| storage.grown.is_forgotten())
            && storage.grown.measure(network, radius, before)?
        {
            storage.grown.settle();
        }
        if !storage.grown.measure(network, radius, place)? {
            storage.grown.forget();
        } else if storage.grown.is_forgotten() {
            storage.grown.settle();
        } else {
            storage.grown.take(time_step, volume_rate);
            return Ok(true);
        }
        Ok(false)
    }
}
