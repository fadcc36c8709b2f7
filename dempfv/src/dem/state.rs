//! What a checkpoint holds.

use serde::{Deserialize, Serialize};

use super::cell::PeriodicCell;
use super::clump::Clump;
use super::error::DemError;
use super::ledger::Ledger;
use super::material::{finite, positive};
use super::motion::Motions;
use super::particles::Particles;
use super::walls::{Wall, box_of, check_box};
use crate::{Aabb, PerWall, WallId};

/// What contacts remember.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactHistory<T> {
    /// The two bodies of each contact, by their places in
    /// [`DemState::particles`]; of two spheres the smaller place first.
    pub bodies: Vec<T>,
    /// The histories, one after the other: as many numbers per contact as the
    /// law remembers.
    pub numbers: Vec<f64>,
}

/// Everything that the mechanics needs to go on as if it had not stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DemState {
    /// Name of the contact law whose histories these are.
    pub law: String,
    /// The spheres.
    pub particles: Particles,
    /// The walls; in a periodic cell the planes of the box around it, which nothing touches.
    pub walls: PerWall<Wall>,
    /// The periodic cell, where there is one.
    pub cell: Option<PeriodicCell>,
    /// Histories of contacts between spheres.
    pub sphere_history: ContactHistory<[u32; 2]>,
    /// Histories of contacts of spheres with walls.
    pub wall_history: ContactHistory<(u32, WallId)>,
    /// Length of the last step (s) if the histories have not yet followed its
    /// motion, else 0.
    pub pending_dt: f64,
    /// Bonds that have been made, intact and broken.
    pub bonds: u64,
    /// The clumps, by the user's numbers.
    pub clumps: Vec<Clump>,
    /// Which spheres are given which motion.
    pub(super) motions: Motions,
    /// Energy by cause, where it is tracked.
    pub(super) ledger: Option<Ledger>,
}

impl<T> Default for ContactHistory<T> {
    /// No contacts.
    fn default() -> ContactHistory<T> {
        ContactHistory { bodies: vec![], numbers: vec![] }
    }
}

impl<T: Copy + Ord> ContactHistory<T> {
    /// Refuses histories that have not `length` numbers each.
    pub(super) fn check(&self, length: usize) -> Result<(), DemError> {
        let (found, expected) = (self.numbers.len(), self.bodies.len() * length);
        if found == expected {
            Ok(())
        } else {
            Err(DemError::History { found, contacts: self.bodies.len(), length })
        }
    }

    /// Each contact with its history of `length` numbers, sorted by bodies.
    pub(super) fn sorted(&self, length: usize) -> Vec<(T, &[f64])> {
        let history = |k: usize| &self.numbers[k * length..][..length];
        let mut all: Vec<_> =
            self.bodies.iter().enumerate().map(|(k, &b)| (b, history(k))).collect();
        all.sort_by_key(|&(bodies, _)| bodies);
        all
    }
}

impl DemState {
    /// Checks all but the histories' lengths and bodies, which depend on the law.
    pub(super) fn check(&self) -> Result<(), DemError> {
        let box_ = box_of(&self.walls);
        check_box(&box_)?;
        self.walls.values().try_for_each(Wall::check)?;
        self.cell.iter().try_for_each(PeriodicCell::check)?;
        self.particles.check()?;
        self.particles.check_digits(&self.reach(box_))?;
        self.ledger.iter().try_for_each(Ledger::check)?;
        self.motions.check(self.particles.len())?;
        self.check_clumps()?;
        if self.pending_dt != 0.0 {
            positive("pending_dt", self.pending_dt)?;
        }
        let histories = self.sphere_history.numbers.iter().chain(&self.wall_history.numbers);
        histories.copied().try_for_each(|number| finite("contact history", number))
    }

    fn check_clumps(&self) -> Result<(), DemError> {
        let count = self.particles.len();
        let mut seen = vec![false; if self.clumps.is_empty() { 0 } else { count }];
        for (index, clump) in self.clumps.iter().enumerate() {
            clump.check()?;
            for &number in &clump.members {
                match seen.get_mut(number as usize) {
                    Some(seen) if !*seen => *seen = true,
                    Some(_) => {
                        let reason = "has a sphere that is in a clump already; name it once";
                        return Err(DemError::Clump { clump: index, reason });
                    }
                    None => return Err(DemError::NoSuchSphere { number, count }),
                }
            }
        }
        Ok(())
    }

    /// Gives the members of each clump the masses of their materials: `factor` tells by how much that of
    /// a sphere has changed, by the user's numbers.
    pub(crate) fn scale_clumps(&mut self, factor: impl Fn(usize) -> f64) {
        for clump in &mut self.clumps {
            let first = clump.members.first().map_or(1.0, |&number| factor(number as usize));
            clump.scale_mass(first);
        }
    }

    /// The box, or with a periodic cell, around which spheres may lie anywhere, the box of both.
    fn reach(&self, mut box_: Aabb) -> Aabb {
        if self.cell.is_some() {
            for x in &self.particles.position {
                (box_.min, box_.max) = (box_.min.inf(x), box_.max.sup(x));
            }
        }
        box_
    }

    /// Puts the spheres in spatial order and the histories of `length` numbers
    /// with them; `reverse` is the law's where two bodies change places.
    pub(super) fn sort_spatially(&mut self, length: usize, reverse: impl Fn(&mut [f64])) {
        let from = self.particles.put_in_order();
        let mut to = vec![0u32; from.len()];
        for (k, &i) in (0u32..).zip(&from) {
            to[i as usize] = k;
        }
        let ContactHistory { bodies, numbers } = &mut self.sphere_history;
        for (k, pair) in bodies.iter_mut().enumerate() {
            let [i, j] = pair.map(|i| to[i as usize]);
            *pair = [i.min(j), i.max(j)];
            if i > j {
                reverse(&mut numbers[k * length..][..length]);
            }
        }
        for (i, _) in &mut self.wall_history.bodies {
            *i = to[*i as usize];
        }
    }
}
