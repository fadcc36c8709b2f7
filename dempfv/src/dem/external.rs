//! Forces and torques that a user of the library adds to those of contacts,
//! gravity and fluid.

use crate::Vec3;

/// What a user adds in the next step, in storage order. Takes no memory and
/// costs nothing until something is added.
#[derive(Debug, Default)]
pub(super) struct ExternalLoads {
    /// Force on each sphere (N).
    pub force: Vec<Vec3>,
    /// Torque on each sphere (N m).
    pub torque: Vec<Vec3>,
    /// Something has been added since the last step.
    added: bool,
    turns: bool,
}

impl ExternalLoads {
    /// Adds to the force (N) and the torque (N m) on the sphere `k` of `n`.
    pub fn add(&mut self, k: usize, n: usize, force: Vec3, torque: Vec3) {
        let (forces, torques) = self.all(n);
        forces[k] += force;
        torques[k] += torque;
        self.turn(torque != Vec3::zeros());
    }

    /// Forces and torques on all of `n` spheres, to be added to; say with [`ExternalLoads::turn`]
    /// whether a torque is.
    pub fn all(&mut self, n: usize) -> (&mut [Vec3], &mut [Vec3]) {
        if !self.added {
            for list in [&mut self.force, &mut self.torque] {
                list.clear();
                list.resize(n, Vec3::zeros());
            }
            (self.added, self.turns) = (true, false);
        }
        (&mut self.force, &mut self.torque)
    }

    /// Says whether a torque has been added.
    pub fn turn(&mut self, turns: bool) {
        self.turns |= turns;
    }

    /// What has been added, if anything.
    pub fn get(&self) -> Option<&ExternalLoads> {
        self.added.then_some(self)
    }

    /// Whether torques are among it.
    pub fn turns(&self) -> bool {
        self.added && self.turns
    }

    /// Forgets what has been added; keeps the memory.
    pub fn clear(&mut self) {
        self.added = false;
    }
}
