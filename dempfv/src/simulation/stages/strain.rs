//! Strain of the box or the periodic cell.

use serde::{Deserialize, Serialize};

use crate::coupling::Coupled;
use crate::{Aabb, Tensor};

/// What strains are counted from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Reference {
    bounds: Aabb,
    /// ∫ L dt of the periodic cell; 0 between walls.
    cell: Tensor,
}

impl Reference {
    /// As it is now.
    pub fn new(coupled: &Coupled) -> Reference {
        Reference { bounds: coupled.dem().box_(), cell: cell_strain(coupled).unwrap_or_default() }
    }

    /// Logarithmic strain along each axis since then, compression positive.
    pub fn strain(&self, coupled: &Coupled) -> [f64; 3] {
        match self.cell_strain(coupled) {
            None => logarithmic_strain(&self.bounds, &coupled.dem().box_()),
            Some(strain) => (-strain.diagonal()).into(),
        }
    }

    /// ∫ L dt of the periodic cell since then; `None` between walls.
    pub fn cell_strain(&self, coupled: &Coupled) -> Option<Tensor> {
        cell_strain(coupled).map(|strain| strain - self.cell)
    }
}

fn cell_strain(coupled: &Coupled) -> Option<Tensor> {
    coupled.dem().cell().map(|cell| *cell.strain())
}

/// Logarithmic strain along each axis, compression positive.
pub(super) fn logarithmic_strain(from: &Aabb, to: &Aabb) -> [f64; 3] {
    from.size().zip_map(&to.size(), |a, b| (a / b).ln()).into()
}
