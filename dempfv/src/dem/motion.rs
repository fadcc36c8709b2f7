//! Spheres whose motion is given, whatever acts on them: held fast, driven along, turned about an axis.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::integrate::{Loads, Step};
use super::ledger::MotionWork;
use super::material::finite;
use super::particles::Particles;
use super::tumble::Turn;
use crate::TimeFunction;
use crate::Vec3;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "prescribed motion",
    family: Family::Bodies,
    equation: "dx/dt = v(t) + ω(t) × (x − c), dc/dt = v(t), by rigid turns at the rates of the middle of each step; \
               work = ΔK less that of all other forces",
    source: "",
    keys: &[
        EffectKey {
            key: "numbers in [[motion]], or a ball, a box or radii",
            unit: "",
            default: "required",
        },
        EffectKey { key: "velocity in [[motion]]", unit: "m/s", default: "0" },
        EffectKey { key: "spin in [[motion]]", unit: "rad/s", default: "0" },
        EffectKey { key: "about in [[motion]]", unit: "m", default: "the centre of each body" },
        EffectKey { key: "from in [[motion]]", unit: "", default: "the first stage" },
    ],
    needs: "",
    test: "dempfv/tests/dem_motion.rs",
};

/// A motion that spheres are given.
///
/// ```
/// use dempfv::TimeFunction;
/// use dempfv::dem::{Dem, DemOptions, Material, Motion, Particles, WallMaterial};
/// use dempfv::{Aabb, Vec3};
///
/// let material = Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
/// let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
/// let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
/// let spheres = Particles::new(vec![Vec3::new(0.2, 0.5, 0.5)], vec![0.1], material.density);
/// let mut dem = Dem::new(spheres, unit, material, walls, DemOptions::default())?;
/// let ramp = TimeFunction::Ramp(vec![[0.0, 0.0], [0.5, 1.0]]);
/// dem.prescribe(&[0], Motion { velocity: [ramp, 0.0.into(), 0.0.into()], ..Motion::default() })?;
/// for _ in 0..500 {
///     dem.step(1e-3)?;
/// }
/// assert!((dem.position(0).x - 0.45).abs() < 1e-12);
/// # Ok::<(), dempfv::dem::DemError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Velocity (m/s).
    pub velocity: [TimeFunction; 3],
    /// Angular velocity (rad/s).
    pub spin: [TimeFunction; 3],
    /// A point of the axis about which all turn together (m), which goes along with the velocity;
    /// `None`: each sphere, or clump, about its own centre.
    pub about: Option<Vec3>,
}

impl Default for Motion {
    /// At rest.
    fn default() -> Motion {
        let zero = || [0.0; 3].map(TimeFunction::Constant);
        Motion { velocity: zero(), spin: zero(), about: None }
    }
}

impl Motion {
    /// Checks that it is a motion.
    pub(super) fn check(&self) -> Result<(), DemError> {
        let wrong = |what, function: &TimeFunction| match function.problem() {
            Some((problem, remedy)) => Err(DemError::Motion { what, problem, remedy }),
            None => Ok(()),
        };
        self.velocity.iter().try_for_each(|f| wrong("velocity", f))?;
        self.spin.iter().try_for_each(|f| wrong("spin", f))?;
        if self.about.is_some_and(|c| !c.iter().all(|x| x.is_finite())) {
            let (problem, remedy) = ("is not finite", "give a point in m");
            return Err(DemError::Motion { what: "axis", problem, remedy });
        }
        Ok(())
    }
}

/// What a motion does in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    /// How far it goes (m).
    shift: Vec3,
    /// How bodies turn.
    pub turn: Turn,
    /// Angular velocity (rad/s).
    pub spin: Vec3,
    /// The point of the axis before the step (m).
    about: Option<Vec3>,
}

impl Stroke {
    /// How far a body goes that is at `x` (m).
    pub fn way(&self, x: &Vec3) -> Vec3 {
        self.shift + self.about.map_or(Vec3::zeros(), |c| self.turn.shift(&(x - c)))
    }
}

/// Which spheres are given which motion. What a checkpoint holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Motions {
    /// The motions, with their axes where they have come to.
    each: Vec<Motion>,
    /// The user's numbers of the spheres with the indices of their motions, by number.
    of: Vec<(u32, u32)>,
    /// Model time (s).
    pub time: f64,
}

impl Motions {
    /// What a state holds of them: nothing where there are none, not even the time.
    pub fn kept(&self) -> Motions {
        if self.is_empty() { Motions::default() } else { self.clone() }
    }

    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// Refuses what no `Dem` has written.
    pub fn check(&self, spheres: usize) -> Result<(), DemError> {
        self.each.iter().try_for_each(Motion::check)?;
        finite("time of the motions", self.time)?;
        let rising = self.of.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let known = |&(number, motion): &(u32, u32)| {
            (number as usize) < spheres && (motion as usize) < self.each.len()
        };
        if rising && self.of.iter().all(known) {
            return Ok(());
        }
        let what = "motions (numbers of spheres and motions)";
        Err(DemError::Length { what, found: self.of.len(), expected: spheres })
    }

    /// Index of the motion of a sphere.
    pub fn of(&self, number: u32) -> Option<u32> {
        let found = self.of.binary_search_by_key(&number, |&(number, _)| number).ok()?;
        Some(self.of[found].1)
    }

    /// The user's numbers of all that is given a motion.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        self.of.iter().map(|&(number, _)| number)
    }

    pub fn add(&mut self, numbers: &[u32], motion: Motion) {
        let index = self.each.len() as u32;
        self.each.push(motion);
        for &number in numbers {
            match self.of.binary_search_by_key(&number, |&(number, _)| number) {
                Ok(found) => self.of[found].1 = index,
                Err(place) => self.of.insert(place, (number, index)),
            }
        }
        self.forget_unused();
    }

    pub fn remove(&mut self, numbers: &[u32]) {
        self.of.retain(|(number, _)| !numbers.contains(number));
        self.forget_unused();
    }

    /// Motions that no sphere has any more would be carried along for ever.
    fn forget_unused(&mut self) {
        let used: Vec<bool> = (0..self.each.len() as u32)
            .map(|index| self.of.iter().any(|&(_, motion)| motion == index))
            .collect();
        let new = |index: u32| used[..index as usize].iter().filter(|used| **used).count() as u32;
        self.of.iter_mut().for_each(|(_, motion)| *motion = new(*motion));
        let mut used = used.into_iter();
        self.each.retain(|_| used.next() == Some(true));
    }

    /// What each motion does in a step of `dt` (s), into `strokes`. The axes and the time go along.
    pub fn advance(&mut self, dt: f64, strokes: &mut Vec<Stroke>) {
        let middle = self.time + 0.5 * dt;
        strokes.clear();
        strokes.extend(self.each.iter_mut().map(|motion| {
            let at =
                |functions: &[TimeFunction; 3]| Vec3::from_fn(|k, _| functions[k].value(middle));
            let (shift, spin) = (dt * at(&motion.velocity), at(&motion.spin));
            let about = motion.about;
            if let Some(c) = &mut motion.about {
                *c += shift;
            }
            Stroke { shift, turn: Turn::by(&(dt * spin)), spin, about }
        }));
        self.time += dt;
    }
}

/// A single sphere that is moved: its place in storage and the index of its motion.
pub(super) type Driven = (u32, u32);

/// Moves single spheres by their strokes. Returns the farthest way that one went (m), not a
/// number where one went nowhere finite.
pub(super) fn drive(
    driven: &[Driven],
    strokes: &[Stroke],
    particles: &mut Particles,
    centre: &mut [[f64; 4]],
    (loads, step): (Loads<'_>, &Step),
    mut work: Option<&mut MotionWork>,
) -> f64 {
    let (mut farthest, mut sum) = (0.0f64, 0.0);
    for &(place, motion) in driven {
        let (k, stroke) = (place as usize, &strokes[motion as usize]);
        let [x, y, z, radius] = centre[k];
        let before = Vec3::new(x, y, z);
        let all_the_way = stroke.way(&before);
        let (after, velocity) = (before + all_the_way, all_the_way / step.dt);
        let (mass, old) = (particles.mass[k], (particles.velocity[k], particles.spin[k]));
        if let Some(work) = &mut work {
            let way = 0.5 * (step.last_dt * old.0 + step.dt * velocity);
            let turn = 0.5 * (step.last_dt * old.1 + step.dt * stroke.spin);
            let on = on_sphere(loads, k);
            let inertia = 0.4 * mass * radius * radius;
            let kinetic = 0.5 * mass * (velocity.norm_squared() - old.0.norm_squared())
                + 0.5 * inertia * (stroke.spin.norm_squared() - old.1.norm_squared());
            let by_fluid = on.fluid.dot(&way) + on.fluid_torque.dot(&turn);
            let by_external = on.added.dot(&way) + on.added_torque.dot(&turn);
            let by_contacts = loads.force[k].dot(&way) + loads.torque[k].dot(&turn);
            let by_gravity = mass * step.gravity.dot(&way);
            work.fluid += by_fluid;
            work.external += by_external;
            work.motion += kinetic - (by_fluid + by_external + by_contacts + by_gravity);
        }
        particles.position[k] = after;
        particles.velocity[k] = velocity;
        particles.spin[k] = stroke.spin;
        centre[k] = [after.x, after.y, after.z, radius];
        farthest = farthest.max(all_the_way.norm());
        sum += all_the_way.norm_squared() + after.norm_squared();
    }
    if sum.is_finite() { farthest } else { f64::NAN }
}

/// Force of the fluid, and force and torque that were added, on the sphere at place `k` (N, N m).
pub(super) fn on_sphere(loads: Loads<'_>, k: usize) -> OnSphere {
    let of = |loads: Option<&[Vec3]>| loads.map_or(Vec3::zeros(), |loads| loads[k]);
    OnSphere {
        fluid: of(loads.fluid),
        fluid_torque: of(loads.fluid_torque),
        added: of(loads.external.map(|e| &e.force[..])),
        added_torque: of(loads.external.map(|e| &e.torque[..])),
    }
}

/// What is put on a sphere beside contacts: forces (N) and torques (N m).
pub(super) struct OnSphere {
    pub fluid: Vec3,
    pub fluid_torque: Vec3,
    pub added: Vec3,
    pub added_torque: Vec3,
}
