//! Pressures of walls that change while a network is in use.

use super::{Flow, PfvError};
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
}
