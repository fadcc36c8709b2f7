//! Conditions of a flow, and what changes of them while its network is in use.

use super::{Flow, NetworkConditions, PfvError};
use crate::WallId;

impl Flow {
    /// Changes the pressure (Pa) that a wall imposes, from the next solve on. The matrix stays: only
    /// the right-hand side knows it.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a pressure that is not finite, and for a wall that imposes none.
    pub fn set_wall_pressure(&mut self, wall: WallId, pressure: f64) -> Result<(), PfvError> {
        let wrong = |problem: &str| Err(PfvError::invalid("pressure", wall.index(), problem));
        if !pressure.is_finite() {
            return wrong("is not finite");
        }
        if !self.operators.conditions_mut().set_wall_pressure(wall, pressure) {
            return wrong("is for a wall that imposes none; build the flow with one");
        }
        self.fluid.boundary.pressure[wall] = Some(pressure);
        self.stale_imposed = true;
        Ok(())
    }

    /// Changes the pressure (Pa) of one of [`Flow::imposed_pressures`], from the next solve on, as
    /// [`Flow::set_wall_pressure`] does.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a pressure that is not finite, and for a number that none of
    /// them has.
    pub fn set_imposed_pressure(&mut self, number: usize, pressure: f64) -> Result<(), PfvError> {
        let wrong = |problem: &str| Err(PfvError::invalid("imposed pressure", number, problem));
        if !pressure.is_finite() {
            return wrong("is not finite");
        }
        if !self.operators.conditions_mut().set_imposed_pressure(number, pressure) {
            return wrong("is not there; build the flow with one");
        }
        self.conditions.imposed[number].pressure = pressure;
        self.stale_imposed = true;
        Ok(())
    }

    /// Changes the rate (m³/s) of one of the sources that [`Flow::set_sources`] has set, from the next
    /// solve on.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a rate that is not finite, and for a number that no source has.
    pub fn set_source_rate(&mut self, number: usize, rate: f64) -> Result<(), PfvError> {
        let wrong = |problem: &str| Err(PfvError::invalid("source", number, problem));
        if !rate.is_finite() {
            return wrong("has a rate that is not finite");
        }
        match self.terms.sources_mut().is_some_and(|sources| sources.set_rate(number, rate)) {
            true => Ok(()),
            false => wrong("is not there; set it first"),
        }
    }

    /// What was asked of the network beside the constant pressures of walls.
    pub fn conditions(&self) -> &NetworkConditions {
        &self.conditions
    }

    /// Pores that do not grow: `V̇ = 0`. Returns whether they did not before.
    pub(crate) fn rest(&mut self) -> bool {
        let rested = self.volume_rate.iter().all(|v| *v == 0.0);
        self.volume_rate.fill(0.0);
        rested
    }

    /// Whether the pressures are the solution for the volume rates of the moment, the conditions not
    /// having changed since.
    pub(crate) fn is_solved(&self) -> bool {
        self.solver.statistics.solved && !self.stale_imposed
    }
}
