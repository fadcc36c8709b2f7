//! Which adhesion a contact has.

use serde::Serialize;

use crate::dem::error::DemError;
use crate::dem::material::positive;

/// What holds surfaces together that touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Adhesion {
    /// A constant force (N).
    Constant(f64),
    /// The theory of Derjaguin, Muller and Toporov, for a work of adhesion (J/m²).
    Dmt(f64),
    /// The theory of Johnson, Kendall and Roberts, for a work of adhesion (J/m²).
    Jkr(f64),
}

impl Adhesion {
    pub(super) fn check(&self) -> Result<(), DemError> {
        match *self {
            Adhesion::Constant(force) => positive("adhesion force", force),
            Adhesion::Dmt(work) | Adhesion::Jkr(work) => positive("work of adhesion", work),
        }
    }
}
