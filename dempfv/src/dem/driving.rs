//! What drives spheres: motions that are given to them, and forces of a user's own.

use super::body_force::BodyForce;
use super::error::DemError;
use super::held::Held;
use super::integrate::{FluidLoads, Loads, Step, first_not_finite};
use super::material::finite;
use super::motion::Motion;
use super::system::Dem;

impl Dem {
    /// Gives the spheres with these numbers a motion from now on, whatever acts on them; a clump moves
    /// as a whole where one of its members is named. A motion that they had before is replaced.
    ///
    /// # Errors
    /// [`DemError::Motion`] for a motion that none is, [`DemError::NoSuchSphere`];
    /// [`DemError::InCell`] in a periodic cell.
    pub fn prescribe(&mut self, numbers: &[u32], motion: Motion) -> Result<(), DemError> {
        motion.check()?;
        if self.cell.is_some() {
            let remedy = "its spheres move with it; put walls around";
            return Err(DemError::InCell { what: "a prescribed motion", remedy });
        }
        let all = self.with_their_clumps(numbers)?;
        self.change_held(|held| held.motions.add(&all, motion));
        Ok(())
    }

    /// Lets the spheres with these numbers, and their clumps, move freely again, from the velocities
    /// that they have.
    ///
    /// # Errors
    /// [`DemError::NoSuchSphere`].
    pub fn release(&mut self, numbers: &[u32]) -> Result<(), DemError> {
        let all = self.with_their_clumps(numbers)?;
        self.change_held(|held| held.motions.remove(&all));
        Ok(())
    }

    /// The user's numbers of the spheres that are given a motion, in rising order.
    pub fn prescribed(&self) -> impl Iterator<Item = u32> + '_ {
        self.held.motions.numbers()
    }

    /// Says what the model time is (s), for motions that depend on it: without, it begins at 0 and goes
    /// on with each step. A [`Coupled`](crate::coupling::Coupled) says it in each step.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), DemError> {
        finite("time", time)?;
        self.held.motions.time = time;
        Ok(())
    }

    /// These numbers and those of all members of their clumps, each once, in rising order.
    fn with_their_clumps(&self, numbers: &[u32]) -> Result<Vec<u32>, DemError> {
        self.check_numbers(numbers)?;
        let mut all = numbers.to_vec();
        let clumps = numbers.iter().filter_map(|&number| self.clump_of(number as usize));
        let mut clumps: Vec<usize> = clumps.collect();
        clumps.sort_unstable();
        clumps.dedup();
        let members = clumps.into_iter().filter_map(|index| self.held.clumps.get(index));
        all.extend(members.flat_map(|clump| &clump.members));
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    /// Refuses numbers that no sphere has.
    pub(super) fn check_numbers(&self, numbers: &[u32]) -> Result<(), DemError> {
        let count = self.len();
        match numbers.iter().find(|&&number| number as usize >= count) {
            Some(&number) => Err(DemError::NoSuchSphere { number, count }),
            None => Ok(()),
        }
    }

    /// Moves clumps and spheres whose motion is given by one time step. Returns the farthest way that one
    /// went (m).
    pub(super) fn move_held(&mut self, step: Step, fluid: FluidLoads<'_>) -> Result<f64, DemError> {
        let Dem { held, particles, centre, forces, external, motion_work, .. } = self;
        let (force, torque) = (&forces.force[..], &forces.torque[..]);
        let external = external.get();
        let (fluid, fluid_torque) = (fluid.force, fluid.torque);
        let loads = Loads { force, torque, fluid, fluid_torque, external, held: &[] };
        let work = motion_work.first_mut();
        let way = held.advance(particles, centre, (loads, &step), work);
        if way.is_nan() { Err(first_not_finite(particles, loads)) } else { Ok(way) }
    }

    /// Changes what is held.
    pub(super) fn change_held(&mut self, change: impl FnOnce(&mut Held)) {
        change(&mut self.held);
        let Held { motions, clumps, .. } = std::mem::take(&mut self.held);
        self.held = Held::new(motions, clumps.into_bodies(), &self.place);
    }

    /// Lets a force of the caller's own act on the spheres from the next step on, beside those that do
    /// so already. It is no part of [`Dem::state`]: give it to a `Dem` again that goes on from one, and
    /// say what the time is ([`Dem::set_time`]) where the force depends on it.
    pub fn add_body_force(&mut self, body_force: Box<dyn BodyForce>) {
        self.body_forces.each.push(body_force);
    }

    /// Ends all body forces, and gives them back.
    pub fn take_body_forces(&mut self) -> Vec<Box<dyn BodyForce>> {
        std::mem::take(&mut self.body_forces.each)
    }

    /// Counts the time of body forces on, where no motion does so.
    pub(super) fn count_time(&mut self, dt: f64) {
        if !self.body_forces.is_empty() && self.held.mask().is_empty() {
            self.held.motions.time += dt;
        }
    }

    /// Adds what body forces do in a step.
    pub(super) fn act_body_forces(&mut self) -> Result<(), DemError> {
        if self.body_forces.is_empty() {
            return Ok(());
        }
        let time = self.held.motions.time;
        let acted = self.body_forces.act(&self.particles, time, &mut self.external);
        // A step that fails leaves nothing for the next one.
        acted.inspect_err(|_| self.external.clear())
    }
}
