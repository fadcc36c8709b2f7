//! The same packing in other units of length: a permeability over the square of a length
//! must not change.

use dempfv::WallId;
use dempfv::pfv::{Clamp, Fluid};
use serde::{Deserialize, Serialize};

use super::case::{Case, Packing, VISCOSITY};
use super::theirs::Theirs;
use crate::Error;

/// k/L² in one unit of length, L being the box's height.
#[derive(Clone, Serialize, Deserialize)]
pub struct Scale {
    /// Height of the box in this unit.
    pub height: f64,
    /// YADE's, without its clamp.
    pub their_free: f64,
    /// YADE's, with its clamp.
    pub their_clamped: f64,
    /// Ours, for each of [`Clamp::ALL`].
    pub ours: [f64; 3],
}

/// Lengths over those in metres: metres, millimetres, heights of the box.
pub fn wanted(packing: &Packing) -> Vec<f64> {
    vec![1.0, 1000.0, 1.0 / packing.bounds.size().y]
}

/// Our permeabilities beside YADE's.
///
/// # Errors
/// Those of the network and the solver.
pub fn measure(packing: &Packing, theirs: &Theirs) -> Result<Vec<Scale>, Error> {
    let scale_of = |scale: f64| {
        let packing = packing.scaled(scale);
        let size = packing.bounds.size();
        // k/L² = Q μ / (A L Δp), with 1 Pa.
        let relative = |flux: f64| flux * VISCOSITY / (size.x * size.z * size.y);
        let their = |clamp| {
            let found = theirs.scaled.iter().find(|s| s.scale == scale && s.clamp == clamp);
            found.map_or(f64::MAX, |s| relative(-s.flux[WallId::YMin.index()]))
        };
        let mut ours = [0.0; 3];
        for (k, clamp) in ours.iter_mut().zip(Clamp::ALL) {
            let fluid = Fluid { clamp, ..Case::ALL[0].fluid() };
            *k = relative(packing.flow(&fluid)?.flux()[WallId::YMin.index()]);
        }
        Ok(Scale { height: size.y, their_free: their(false), their_clamped: their(true), ours })
    };
    wanted(packing).into_iter().map(scale_of).collect()
}
