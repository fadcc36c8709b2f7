//! The forces of the last contact pass, so that what is observed after a restart
//! is what was observed before.

use serde::{Deserialize, Serialize};

use super::cell_pass::CellSum;
use super::error::{DemError, require_length};
use super::system::Dem;
use super::wall_pairs::WallSum;
use crate::{PerWall, Vec3};

/// What the last [`Dem::compute_contacts`] found. The next one does without.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactForces {
    /// Force on each sphere (N).
    force: Vec<Vec3>,
    /// Torque on each sphere (N m).
    torque: Vec<Vec3>,
    /// Force on each wall (N), normal stiffness of its contacts (N/m) and their dashpots (N s/m).
    walls: PerWall<(Vec3, f64, f64)>,
    /// Sums in a periodic cell (N m): of the moments, and of the stiffnesses.
    cell: ([f64; 9], [f64; 9]),
}

impl Dem {
    /// The forces of the last [`Dem::compute_contacts`].
    pub(crate) fn contact_forces(&self) -> ContactForces {
        ContactForces {
            force: self.forces.force.clone(),
            torque: self.forces.torque.clone(),
            walls: self.wall_sums.map(|sum| (sum.force, sum.stiffness, sum.dashpot)),
            cell: (self.cell_sum.moment, self.cell_sum.stiffness),
        }
    }

    /// Takes these forces for those of the last [`Dem::compute_contacts`].
    ///
    /// # Errors
    /// [`DemError::Length`] for forces of another number of spheres.
    pub(crate) fn set_contact_forces(&mut self, forces: ContactForces) -> Result<(), DemError> {
        let ContactForces { force, torque, walls, cell } = forces;
        let expected = self.particles.len();
        for (what, found) in [("contact force", force.len()), ("contact torque", torque.len())] {
            require_length(what, found, expected)?;
        }
        self.forces.force.copy_from_slice(&force);
        self.forces.torque.copy_from_slice(&torque);
        self.wall_sums =
            walls.map(|&(force, stiffness, dashpot)| WallSum { force, stiffness, dashpot });
        let (moment, stiffness) = cell;
        self.cell_sum = CellSum { moment, stiffness };
        Ok(())
    }
}
