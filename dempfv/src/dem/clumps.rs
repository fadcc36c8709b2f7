//! The clumps of a [`Dem`](super::Dem) on their way through a step.

use super::clump::Clump;
use super::integrate::{Loads, Step};
use super::ledger::MotionWork;
use super::motion::{Stroke, on_sphere};
use super::particles::Particles;
use super::tumble::{Turn, free_turn};
use crate::Vec3;
use crate::parallel::in_tasks;

/// How a body went in a step.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    turn: Turn,
    /// Angular velocity of the step (rad/s), as a sphere has it that turns alike.
    spin: Vec3,
    work: MotionWork,
}

/// A body with what a step needs of it beside its state.
#[derive(Clone, Debug)]
struct Rigid {
    body: Clump,
    /// Places of the members in storage.
    places: Vec<usize>,
    /// Index of its motion, where it is given one.
    motion: Option<u32>,
    course: Course,
}

/// All clumps.
#[derive(Clone, Debug, Default)]
pub(super) struct Clumps {
    rigid: Vec<Rigid>,
    /// Index of each sphere's clump by place in storage, `NO_CLUMP` for a single one; empty without clumps.
    of: Vec<u32>,
}

/// The index of the clump of a single sphere.
pub(super) const NO_CLUMP: u32 = u32::MAX;
/// Bodies that one task takes, and from which number on it is worth it.
const TASK: usize = 256;
const SERIAL: usize = 1024;

impl Clumps {
    /// `place` leads from the user's numbers to storage; `motion` tells which motion a sphere is given.
    pub fn new(bodies: Vec<Clump>, place: &[u32], motion: impl Fn(u32) -> Option<u32>) -> Clumps {
        if bodies.is_empty() {
            return Clumps::default();
        }
        let mut of = vec![NO_CLUMP; place.len()];
        let mut rigid = Vec::with_capacity(bodies.len());
        for (index, body) in (0u32..).zip(bodies) {
            let places: Vec<usize> =
                body.members.iter().map(|&number| place[number as usize] as usize).collect();
            places.iter().for_each(|&k| of[k] = index);
            let motion = body.members.first().and_then(|&number| motion(number));
            rigid.push(Rigid { body, places, motion, course: Course::default() });
        }
        Clumps { rigid, of }
    }

    pub fn is_empty(&self) -> bool {
        self.rigid.is_empty()
    }

    pub fn each(&self) -> impl Iterator<Item = &Clump> {
        self.rigid.iter().map(|rigid| &rigid.body)
    }

    pub fn get(&self, index: usize) -> Option<&Clump> {
        self.rigid.get(index).map(|rigid| &rigid.body)
    }

    /// The bodies alone.
    pub fn into_bodies(self) -> Vec<Clump> {
        self.rigid.into_iter().map(|rigid| rigid.body).collect()
    }

    pub fn get_mut(&mut self, index: usize) -> Option<&mut Clump> {
        self.rigid.get_mut(index).map(|rigid| &mut rigid.body)
    }

    /// Index of the clump of the sphere at a place in storage.
    pub fn of(&self, place: usize) -> Option<u32> {
        self.of.get(place).copied().filter(|&index| index != NO_CLUMP)
    }

    /// The index of each sphere's clump, `NO_CLUMP` for a single one; empty without clumps.
    pub fn indices(&self) -> &[u32] {
        &self.of
    }

    /// Volume of the clumps less that of their members as spheres (m³).
    pub fn excess_volume(&self, radius: &[f64]) -> f64 {
        let sphere = |&k: &usize| 4.0 / 3.0 * std::f64::consts::PI * radius[k].powi(3);
        let excess = |r: &Rigid| r.body.volume - r.places.iter().map(sphere).sum::<f64>();
        self.rigid.iter().map(excess).sum()
    }

    /// Force of the contacts, the fluid and gravity on each clump that moves freely (N).
    pub fn net_forces<'a>(
        &'a self,
        on_sphere: impl Fn(usize) -> Vec3 + 'a,
        gravity: Vec3,
    ) -> impl Iterator<Item = Vec3> + 'a {
        let free = self.rigid.iter().filter(|rigid| rigid.motion.is_none());
        free.map(move |r| {
            r.places.iter().map(|&k| on_sphere(k)).sum::<Vec3>() + r.body.mass * gravity
        })
    }

    /// Makes all clumps larger by `factor`, with the radii of their members.
    pub fn scale(&mut self, factor: f64, particles: &mut Particles, centre: &mut [[f64; 4]]) {
        self.rigid.iter_mut().for_each(|rigid| rigid.body.scale(factor));
        self.put_members(particles, centre);
    }

    /// Puts the centres of all clumps elsewhere, and their members with them.
    pub fn put(
        &mut self,
        place: impl Fn(&Vec3) -> Vec3,
        particles: &mut Particles,
        centre: &mut [[f64; 4]],
    ) {
        self.rigid.iter_mut().for_each(|rigid| rigid.body.centre = place(&rigid.body.centre));
        self.put_members(particles, centre);
    }

    /// Puts members where their clumps are.
    fn put_members(&self, particles: &mut Particles, centre: &mut [[f64; 4]]) {
        for Rigid { body, places, .. } in &self.rigid {
            for (&k, at) in places.iter().zip(&body.places) {
                let x = body.centre + body.orientation.transform_vector(at);
                particles.position[k] = x;
                [centre[k][0], centre[k][1], centre[k][2]] = x.into();
            }
        }
    }

    /// Moves all clumps by one time step, and their members with them. Returns the farthest way that a
    /// member went (m), not a number where one went nowhere finite.
    pub fn advance(
        &mut self,
        particles: &mut Particles,
        centre: &mut [[f64; 4]],
        (loads, step): (Loads<'_>, &Step),
        strokes: &[Stroke],
        work: Option<&mut MotionWork>,
    ) -> f64 {
        let tracks = work.is_some();
        let p = &*particles;
        in_tasks(&mut self.rigid, SERIAL, TASK, &|_, rigid| {
            rigid.advance(p, (loads, step), strokes, tracks);
        });
        if let Some(work) = work {
            self.rigid.iter().for_each(|rigid| work.join(&rigid.course.work));
        }
        let (mut farthest2, mut sum) = (0.0f64, 0.0);
        for Rigid { body, places, course, .. } in &self.rigid {
            let rotation = body.orientation.to_rotation_matrix();
            for (&k, at) in places.iter().zip(&body.places) {
                let after = rotation * at;
                // The way of the step from its end: what turns on is as long on either side.
                let velocity = body.velocity + course.turn.way_to(&after) / step.dt;
                let x = body.centre + after;
                particles.position[k] = x;
                particles.velocity[k] = velocity;
                particles.spin[k] = course.spin;
                [centre[k][0], centre[k][1], centre[k][2]] = x.into();
                farthest2 = farthest2.max(velocity.norm_squared());
                sum += velocity.norm_squared() + x.norm_squared() + course.spin.norm_squared();
            }
        }
        if sum.is_finite() { step.dt * farthest2.sqrt() } else { f64::NAN }
    }
}

impl Rigid {
    fn advance(
        &mut self,
        particles: &Particles,
        (loads, step): (Loads<'_>, &Step),
        strokes: &[Stroke],
        tracks: bool,
    ) {
        let dt = step.dt;
        let before = (self.body.velocity, self.body.kinetic_energy());
        let (force, torque) = self.loads(loads);
        let body = &mut self.body;
        let mut damped = (Vec3::zeros(), Vec3::zeros());
        if let Some(stroke) = self.motion.map(|motion| &strokes[motion as usize]) {
            let way = stroke.way(&body.centre);
            body.velocity = way / dt;
            body.centre += way;
            self.course.turn = stroke.turn;
            self.course.spin = stroke.spin;
            body.orientation = self.course.turn.turned(&body.orientation);
            body.set_spin(&stroke.spin);
        } else {
            let mut a = force / body.mass + step.gravity;
            let undamped = a;
            step.damping.damp(&mut a, &body.velocity, dt);
            let mut turning = torque;
            let half_way = 0.5 * dt * body.per_moment(&torque);
            step.damping.damp_by(&mut turning, &(body.spin() + half_way));
            damped = (body.mass * (undamped - a), torque - turning);
            body.velocity += dt * a;
            body.centre += dt * body.velocity;
            body.angular_momentum += dt * turning;
            let (moments, momentum) = (&body.moments, &body.angular_momentum);
            self.course.turn = free_turn(moments, &body.orientation, momentum, dt);
            self.course.spin = self.course.turn.angles() / dt;
            body.orientation = self.course.turn.turned(&body.orientation);
        }
        if tracks {
            self.book(particles, (loads, step), before, (force, torque), damped);
        }
    }

    /// Books what was done to the body, which had this velocity (m/s) and these kinetic energies (J)
    /// before; `damped` is what local damping took off its force and torque (N, N m).
    fn book(
        &mut self,
        particles: &Particles,
        (loads, step): (Loads<'_>, &Step),
        (velocity, kinetic): (Vec3, [f64; 2]),
        (force, torque): (Vec3, Vec3),
        damped: (Vec3, Vec3),
    ) {
        let Rigid { body, places, course, motion } = self;
        let mut work = MotionWork::default();
        let half_ways = |before: &Vec3, now: &Vec3| 0.5 * (step.last_dt * before + step.dt * now);
        let turn = half_ways(&particles.spin[places[0]], &course.spin);
        let way = half_ways(&velocity, &body.velocity);
        let rotation = body.orientation.to_rotation_matrix();
        let mut by_contacts = 0.0;
        for (&k, at) in places.iter().zip(&body.places) {
            let now = body.velocity + course.turn.way_to(&(rotation * at)) / step.dt;
            let way = half_ways(&particles.velocity[k], &now);
            let on = on_sphere(loads, k);
            work.fluid += on.fluid.dot(&way) + on.fluid_torque.dot(&turn);
            work.external += on.added.dot(&way) + on.added_torque.dot(&turn);
            by_contacts += loads.force[k].dot(&way) + loads.torque[k].dot(&turn);
        }
        work.damping = damped.0.dot(&way) + damped.1.dot(&turn);
        if motion.is_some() {
            let gained = body.kinetic_energy().iter().sum::<f64>() - kinetic.iter().sum::<f64>();
            let by_gravity = body.mass * step.gravity.dot(&way);
            work.motion = gained - (work.fluid + work.external + by_contacts + by_gravity);
        } else {
            let push = force + body.mass * step.gravity - damped.0;
            let power = push.dot(&velocity) + (torque - damped.1).dot(&particles.spin[places[0]]);
            work.step_change = step.excess() * power;
        }
        course.work = work;
    }

    /// Sum of the forces on the members (N), and of the torques about the centre (N m).
    fn loads(&self, loads: Loads<'_>) -> (Vec3, Vec3) {
        let rotation = self.body.orientation.to_rotation_matrix();
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        for (&k, at) in self.places.iter().zip(&self.body.places) {
            let on = on_sphere(loads, k);
            let on_member = loads.force[k] + on.fluid + on.added;
            force += on_member;
            torque += loads.torque[k] + on.fluid_torque + on.added_torque;
            torque += (rotation * at).cross(&on_member);
        }
        (force, torque)
    }
}
