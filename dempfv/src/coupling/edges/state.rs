//! What must be kept of the edges of a network, and what goes over to the next one.

use serde::{Deserialize, Serialize};

use super::forces::EdgeForces;
use crate::Vec3;
use crate::coupling::error::{CouplingError, Result};

/// The edges of a network as its last step left them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeState {
    /// Force of each film (N), in the order of the edges; empty without normal lubrication.
    film: Vec<f64>,
    /// Force of the edges on each sphere and each wall (N).
    force: Vec<Vec3>,
    wall_force: [Vec3; 6],
}

/// Edges and the forces of their films (N).
pub struct Films {
    pairs: Vec<[u32; 2]>,
    between_spheres: usize,
    force: Vec<f64>,
    stiffness: Vec<f64>,
    dropped: f64,
}

impl EdgeForces {
    /// What a checkpoint needs.
    pub fn state(&self) -> EdgeState {
        let film = match self.effects.normal_lubrication {
            true => self.films.iter().map(|film| film.force).collect(),
            false => vec![],
        };
        EdgeState { film, force: self.force.clone(), wall_force: self.wall_force }
    }

    /// Goes on from a state of the same network; `fluid` has the pores' forces on spheres (N). Where
    /// other effects were on, and so other films, these begin without force.
    ///
    /// # Errors
    /// [`CouplingError::Parameter`] for a state with numbers that are none.
    pub fn resume(&mut self, state: &EdgeState, fluid: &[Vec3]) -> Result<()> {
        let EdgeState { film, force, wall_force } = state;
        let vectors = force.iter().chain(wall_force).flat_map(|f| f.iter());
        if let Some(&value) = film.iter().chain(vectors).find(|f| !f.is_finite()) {
            let (name, expected) = ("force between neighbours", "finite");
            return Err(CouplingError::Parameter { name, value, expected });
        }
        if self.effects.normal_lubrication && film.len() == self.films.len() {
            self.films.iter_mut().zip(film).for_each(|(own, f)| own.force = *f);
        }
        if force.len() == self.force.len() {
            self.force.clone_from(force);
            self.wall_force = *wall_force;
        }
        self.join(fluid);
        Ok(())
    }

    /// What is left of the edges of a network that makes room.
    pub fn retire(self) -> Films {
        let kept = self.effects.normal_lubrication;
        let films = self.films.iter().filter(|_| kept);
        Films {
            force: films.clone().map(|film| film.force).collect(),
            stiffness: films.map(|film| film.stiffness).collect(),
            pairs: self.pairs,
            between_spheres: self.between_spheres,
            dropped: self.dropped,
        }
    }

    /// Goes on with the films of those edges that the network before had too; what the others held is
    /// lost.
    pub fn take_over(&mut self, before: &Films) {
        self.dropped += before.dropped;
        let energy = |f: f64, stiffness: f64| 0.5 * f * f / stiffness;
        // Both lists are sorted, edges between spheres first.
        let key = |pair: [u32; 2], between: bool| (!between, pair);
        let mut k = 0;
        for (e, (&force, &stiffness)) in before.force.iter().zip(&before.stiffness).enumerate() {
            let wanted = key(before.pairs[e], e < before.between_spheres);
            while k < self.pairs.len() && key(self.pairs[k], k < self.between_spheres) < wanted {
                k += 1;
            }
            let found =
                self.pairs.get(k).is_some_and(|p| key(*p, k < self.between_spheres) == wanted);
            if found && self.effects.normal_lubrication {
                self.films[k].force = force;
            } else {
                self.dropped += energy(force, stiffness);
            }
        }
    }
}
