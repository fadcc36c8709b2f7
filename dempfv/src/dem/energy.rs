//! Energy by cause: what spheres have, what was done to them, and what was dissipated.
//!
//! The leapfrog scheme has velocities half a step away from positions, and the change of their
//! kinetic energy in a step is exactly the work of the forces over the mean of the two velocities.
//! Each cause books that work; elastic energy and that of gravity are taken at the same half step,
//! from the positions before and after it. Work is the mean force over half the way of the step
//! before and half that of the step after: also where their lengths differ. Three things that time
//! integration makes or loses have names of their own, and a formula each that knows nothing of the sum:
//! steps across which bodies begin or cease to touch, in which contacts turn, and that are not as long as
//! the one before. What is left over it has made or lost in other ways: [`EnergyBalance::residual`].

use serde::Serialize;

use super::cell_pass::CellPass;
use super::compiled::Touch;
use super::contacts::{Other, Place};
use super::law::Losses;
use super::ledger::{FilmLosses, Ledger, MotionWork};
use super::system::Dem;
use super::touch_change::slip;
use crate::parallel::{block_count, sum_of};
use crate::{Effect, EffectKey, Family};
use crate::{PerWall, Tensor, Vec3, WallId};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "energy by cause",
    family: Family::Numerics,
    equation: "ΔK + ΔU = works − losses + residual, each at the half step of the leapfrog",
    source: "dempfv/src/dem/energy.rs",
    keys: &[
        EffectKey { key: "energy in [output]", unit: "", default: "true" },
        EffectKey { key: "energy_turning in [output]", unit: "", default: "false" },
    ],
    needs: "",
    test: "dempfv/tests/dem_energy.rs",
};

/// Energy of the spheres by cause (J), since [`Dem::track_energy`].
///
/// What was there, and what walls, fluid and added forces did, is what is there now, what was
/// dissipated, and the [`EnergyBalance::residual`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// Kinetic energy of translation now.
    pub translation: f64,
    /// Kinetic energy of rotation now.
    pub rotation: f64,
    /// Elastic energy of contacts now.
    pub elastic: f64,
    /// Energy of position under gravity now; 0 at the origin.
    pub gravity: f64,
    /// Dissipated by slip against friction.
    pub friction: f64,
    /// Dissipated by viscous forces in contacts.
    pub contact_damping: f64,
    /// Dissipated by rolling and twisting.
    pub rolling: f64,
    /// Lost with bonds that broke.
    pub breakage: f64,
    /// Lost (made, where negative) by time steps across which bodies begin or cease to touch. It
    /// shrinks with the square of the time step.
    pub touch_change: f64,
    /// Lost (made, where negative) by time steps in which contacts turn: forces act along the directions
    /// of before and after, springs follow those of after. It shrinks with the time step.
    pub turning: f64,
    /// Lost (made, where negative) by changes of the time step: a velocity takes the whole of each step,
    /// of which the half before the forces had the length of the last one.
    pub step_change: f64,
    /// Dissipated by local damping.
    pub local_damping: f64,
    /// Dissipated between neighbours by viscous shear of the fluid.
    pub viscous_shear: f64,
    /// Dissipated by films that are squeezed out.
    pub normal_lubrication: f64,
    /// Dissipated by films that are sheared.
    pub shear_lubrication: f64,
    /// Dissipated by spheres that roll on each other in a fluid.
    pub pump_torque: f64,
    /// Dissipated by spheres that twist against each other in a fluid.
    pub twist_torque: f64,
    /// Elastic energy of surfaces that films press, less what there was when tracking began.
    pub film_elastic: f64,
    /// Work of the fluid's pressures on the spheres.
    pub fluid_work: f64,
    /// Work of the walls on the spheres.
    pub wall_work: f64,
    /// Work of the periodic cell on the spheres: of its deformation against the stress of contacts
    /// and motion, −V σ:L in a second.
    pub cell_work: f64,
    /// Work of forces and torques that were added.
    pub external_work: f64,
    /// Work of what gives spheres a motion ([`Dem::prescribe`]).
    pub motion_work: f64,
    /// Energy that appeared without a cause: made (or, where negative, lost) by time integration.
    pub residual: f64,
}

impl EnergyBalance {
    /// The sum of what moved (J): the magnitudes of all works and losses, to measure the residual by.
    pub fn moved(&self) -> f64 {
        let around = [self.wall_work, self.cell_work];
        let works = [self.fluid_work, self.external_work, self.motion_work];
        let all = works.into_iter().chain(around);
        all.map(f64::abs).sum::<f64>() + self.dissipated().abs()
    }

    /// What was dissipated by all causes (J).
    pub fn dissipated(&self) -> f64 {
        self.friction
            + self.contact_damping
            + self.rolling
            + self.breakage
            + self.touch_change
            + self.turning
            + self.step_change
            + self.local_damping
            + self.viscous_shear
            + self.normal_lubrication
            + self.shear_lubrication
            + self.pump_torque
            + self.twist_torque
    }
}

impl Dem {
    /// Begins to track energy by cause, or ends it. Costs nothing when off. Beginning anew forgets
    /// what was tracked before.
    pub fn track_energy(&mut self, on: bool) {
        self.ledger = None;
        let spheres = if on { self.particles.len() } else { 0 };
        self.forces.losses = vec![Losses::default(); block_count(spheres)];
        self.motion_work = vec![MotionWork::default(); spheres];
        if on {
            // What dashpots do in the second half of the last step is booked in the next.
            let began_with = self.energy_now().iter().sum::<f64>() + self.damping_half_way();
            let (losses, work, films) = Default::default();
            let ledger = Ledger {
                began_with,
                losses,
                work,
                films,
                walls: 0.0,
                cell: 0.0,
                last_dt: self.pending_dt,
            };
            self.ledger = Some(ledger);
        }
    }

    /// Whether energy that is tracked has what turning contacts lose for a cause
    /// ([`EnergyBalance::turning`]); it is in the residual otherwise. On unless told. It takes two more
    /// forces of each contact in each step: a dry one takes two and a half times as long.
    pub fn track_turning(&mut self, on: bool) {
        self.tracks_turning = on;
    }

    /// Whether energy is tracked.
    pub fn tracks_energy(&self) -> bool {
        self.ledger.is_some()
    }

    /// Energy by cause since [`Dem::track_energy`]; `None` where it is not tracked.
    pub fn energy_balance(&self) -> Option<EnergyBalance> {
        let Ledger { began_with, losses, work, films, walls, cell, .. } = self.ledger.as_ref()?;
        let [translation, rotation, elastic, gravity] = self.energy_now();
        let mut balance = EnergyBalance {
            translation,
            rotation,
            elastic,
            gravity,
            friction: losses.friction,
            contact_damping: losses.contact_damping + self.damping_half_way(),
            rolling: losses.rolling,
            breakage: losses.breakage,
            touch_change: losses.touch_change,
            turning: losses.turning,
            step_change: work.step_change,
            local_damping: work.damping,
            viscous_shear: films.viscous_shear,
            normal_lubrication: films.normal_lubrication,
            shear_lubrication: films.shear_lubrication,
            pump_torque: films.pump_torque,
            twist_torque: films.twist_torque,
            film_elastic: films.elastic,
            fluid_work: work.fluid,
            wall_work: *walls,
            cell_work: *cell,
            external_work: work.external,
            motion_work: work.motion,
            residual: 0.0,
        };
        let now = translation + rotation + elastic + gravity + films.elastic;
        let around = balance.wall_work + balance.cell_work;
        let done = balance.fluid_work + around + (balance.external_work + balance.motion_work);
        balance.residual = (now - began_with) + (balance.dissipated() - done);
        Some(balance)
    }

    /// Kinetic energy of translation and rotation, elastic energy and that of gravity, half a step
    /// before the positions (J).
    pub(super) fn energy_now(&self) -> [f64; 4] {
        let p = &self.particles;
        let gravity = self.options.gravity.map_or(0.0, |g| {
            let half_way = |i: usize| p.position[i] - 0.5 * self.pending_dt * p.velocity[i];
            let single = |i: &usize| self.held.clumps.of(*i).is_none();
            let spheres = (0..p.len()).filter(single).map(|i| p.mass[i] * g.dot(&half_way(i)));
            let bodies = self.clumps().map(|clump| {
                let half_way = clump.centre - 0.5 * self.pending_dt * clump.velocity;
                clump.mass * g.dot(&half_way)
            });
            -(spheres.sum::<f64>() + bodies.sum::<f64>())
        });
        let elastic = self.elastic_energy_half_way();
        [self.translational_energy(), self.rotational_energy(), elastic, gravity]
    }

    /// Elastic energy of all contacts half a step before the positions (J).
    fn elastic_energy_half_way(&self) -> f64 {
        let (list, length) = (&self.list, self.law.history_length());
        let cell = self.cell.as_ref().map(CellPass::new);
        let spheres = sum_of(list.pairs.len(), |k| {
            if !list.touch[k] {
                return 0.0;
            }
            let history = &list.history[k * length..][..length];
            let shift = cell.map_or(Vec3::zeros(), |cell| cell.shift(list.image[k]));
            let place = self.sphere_place(list.pairs[k], shift, history);
            self.elastic_half_way(&place, cell.as_ref())
        });
        let walls = sum_of(list.wall_pairs.len(), |k| {
            let history = &list.wall_history[k * length..][..length];
            let place =
                || self.elastic_half_way(&self.wall_place(list.wall_pairs[k], history), None);
            if list.wall_touch[k] { place() } else { 0.0 }
        });
        // Sums of nothing are -0, which helps no reader.
        spheres + walls + 0.0
    }

    /// What the dashpots of all contacts dissipate in the second half of the last step (J), which the
    /// next pass books.
    fn damping_half_way(&self) -> f64 {
        let cell = self.cell.as_ref().map(CellPass::new);
        let way = |place: &Place<'_>| {
            let (velocity, rim) = self.relative_motion(place, cell.as_ref());
            slip(self.pending_dt, &velocity, &rim, &place.normal)
        };
        let lost = |place: Place<'_>| self.law.viscous_force(place.history).dot(&way(&place));
        -0.5 * self.places().map(lost).sum::<f64>() + 0.0
    }

    /// Velocity of the second body of a contact relative to the first, and the sum of their arms times
    /// spins (m/s).
    fn relative_motion(&self, place: &Place<'_>, cell: Option<&CellPass>) -> (Vec3, Vec3) {
        let (p, normal) = (&self.particles, place.normal);
        let arm = |k: usize| (p.radius[k] - 0.5 * place.touch.overlap) * p.spin[k];
        match place.other {
            Other::Sphere(j) => {
                let mut apart = p.velocity[j] - p.velocity[place.i];
                if let Some(cell) = cell {
                    let way = place.distance * normal;
                    apart = cell.with_mean_field(apart.into(), way.into()).into();
                }
                (apart, arm(place.i) + arm(j))
            }
            Other::Wall(wall) => {
                let moved = -wall.inward() * self.walls[wall].velocity;
                (moved * normal - p.velocity[place.i], arm(place.i))
            }
        }
    }

    /// Elastic energy (J) of a contact half a step before the positions: what is left of it at the
    /// overlap half way, and after half the slip of the step. The parts of second order make it
    /// ½ k δ₀ δ₁ of a linear spring, whose work then sums up to the last digit.
    fn elastic_half_way(&self, place: &Place<'_>, cell: Option<&CellPass>) -> f64 {
        let (dt, normal) = (self.pending_dt, place.normal);
        let Touch { surfaces, overlap } = place.touch;
        let (velocity, rim) = self.relative_motion(place, cell);
        let closing = match place.other {
            Other::Sphere(_) => {
                let apart = place.distance * normal;
                (apart - dt * velocity).norm() - place.distance
            }
            Other::Wall(_) => -dt * velocity.dot(&normal),
        };
        let slip = slip(dt, &velocity, &rim, &normal);
        if overlap < 0.0 && self.law.cut_off() == 0.0 {
            // It ends in this step: less the work of its last force over half the way.
            let last = Touch { surfaces, overlap: overlap - closing };
            let force = self.law.force(&last, place.history);
            let work = 0.5 * (force.shear.dot(&slip) - force.normal * closing);
            return self.law.elastic_energy(&last, place.history) - work;
        }
        let half_way = Touch { surfaces, overlap: overlap - 0.5 * closing };
        let stiffness = self.law.stiffness(&half_way).normal;
        let shear = self.law.force(&half_way, place.history).shear;
        let elastic = self.law.elastic_energy(&half_way, place.history);
        elastic - 0.125 * stiffness * closing.powi(2) - 0.5 * shear.dot(&slip)
    }

    /// Books the losses of the contact pass.
    pub(super) fn book_losses(&mut self) {
        if let Some(ledger) = &mut self.ledger {
            self.forces.losses.iter().for_each(|losses| ledger.losses.join(losses));
        }
    }

    /// Length of the step before one of `dt`, where energy is tracked (s).
    pub(crate) fn last_dt(&self, dt: f64) -> f64 {
        self.ledger.map_or(dt, |ledger| ledger.last_dt)
    }

    /// Books what the cell does against the contacts in a step of `dt` (s): over half the way of the
    /// step before, and half that of this one, with these velocity gradients (1/s).
    pub(super) fn book_cell(&mut self, dt: f64, [before, now]: [&Tensor; 2]) {
        let last_dt = self.last_dt(dt);
        let Some(ledger) = &mut self.ledger else { return };
        let sum = &self.cell_sum;
        ledger.cell -= 0.5 * (last_dt * sum.power(before) + dt * sum.power(now));
    }

    /// Books what the cell has made of the motion of the spheres, which had this energy (J).
    pub(super) fn book_cell_motion(&mut self, before: f64) {
        let now = self.translational_energy();
        if let Some(ledger) = &mut self.ledger {
            ledger.cell += now - before;
        }
    }

    /// Books what the films between neighbours took, of which the walls gave `by_walls` (J). It was part
    /// of the fluid's work.
    pub(crate) fn book_films(&mut self, losses: &FilmLosses, by_walls: f64) {
        let Some(ledger) = &mut self.ledger else { return };
        ledger.films.join(losses);
        ledger.walls += by_walls;
        ledger.work.fluid += losses.dissipated() + losses.elastic - by_walls;
    }

    /// Books what forces and walls did in the step; `before` has the walls' velocities before it.
    pub(super) fn book_work(&mut self, dt: f64, before: &PerWall<f64>) {
        let last_dt = self.last_dt(dt);
        let Some(ledger) = &mut self.ledger else { return };
        // Eight sums at once, in an order that no number of threads changes.
        let mut sums = [MotionWork::default(); 8];
        for works in self.motion_work.chunks(sums.len()) {
            sums.iter_mut().zip(works).for_each(|(sum, work)| sum.join(work));
        }
        sums.iter().for_each(|sum| ledger.work.join(sum));
        if last_dt == 0.0 {
            // Tracking began between pass and step, with velocities half a step older than contacts:
            // what the forces do until then was there.
            ledger.began_with -= std::mem::take(&mut ledger.work.step_change);
        }
        for wall in WallId::ALL {
            let way = 0.5 * (last_dt * before[wall] + dt * self.walls[wall].velocity);
            ledger.walls -= self.wall_sums[wall].force[wall.axis()] * way;
        }
        ledger.last_dt = dt;
    }
}
