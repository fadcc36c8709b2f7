//! Leapfrog with local damping.

use super::damping::LocalDamping;
use super::error::DemError;
use super::external::ExternalLoads;
use super::ledger::MotionWork;
use super::particles::Particles;
use crate::parallel::{BLOCK, Span, cut, cut_mut, for_blocks};
use crate::{Effect, EffectKey, Family};
use crate::{PerWall, Vec3};

/// What this effect says of itself.
pub const ROTATION: Effect = Effect {
    name: "rotation",
    family: Family::Bodies,
    equation: "I dω/dt = M, I = 2/5 m r²; leapfrog",
    source: "L. Verlet: Phys. Rev. 159 (1967), as leapfrog",
    keys: &[EffectKey { key: "rotation in [dem]", unit: "", default: "true" }],
    needs: "",
    test: "dempfv/tests/dem_conservation.rs",
};

/// What this effect says of itself.
pub const GRAVITY: Effect = Effect {
    name: "gravity",
    family: Family::Bodies,
    equation: "dv/dt = f/m + g",
    source: "",
    keys: &[EffectKey { key: "gravity in [dem]", unit: "m/s²", default: "none" }],
    needs: "",
    test: "dempfv/tests/dem_energy.rs, dempfv/tests/advice.rs",
};

/// What moves the spheres in a step.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// Time step (s).
    pub dt: f64,
    /// Length of the step before (s): work is done over half the way of each.
    pub last_dt: f64,
    /// Local damping.
    pub damping: LocalDamping,
    /// Gravity (m/s²).
    pub gravity: Vec3,
    /// Whether spins change.
    pub rotation: bool,
}

impl Step {
    /// Half of what the step before was longer (s).
    #[inline(always)]
    pub fn excess(&self) -> f64 {
        0.5 * (self.last_dt - self.dt)
    }
}

/// What acts on the spheres in a step.
#[derive(Clone, Copy)]
pub(super) struct Loads<'a> {
    /// Force and torque of the contacts (N, N m).
    pub force: &'a [Vec3],
    pub torque: &'a [Vec3],
    /// Force and torque of the fluid (N, N m), if there is one.
    pub fluid: Option<&'a [Vec3]>,
    pub fluid_torque: Option<&'a [Vec3]>,
    /// What a user adds, if anything.
    pub external: Option<&'a ExternalLoads>,
    /// Which spheres others move; empty where none.
    pub held: &'a [bool],
}

/// What a fluid puts on spheres, in storage order, and walls.
#[derive(Clone, Copy, Default)]
pub(crate) struct FluidLoads<'a> {
    /// Force on each sphere (N).
    pub force: Option<&'a [Vec3]>,
    /// Torque on each sphere (N m).
    pub torque: Option<&'a [Vec3]>,
    /// Force on each wall (N).
    pub on_walls: Option<&'a PerWall<Vec3>>,
}

/// What a step found.
#[derive(Clone, Copy)]
struct Found {
    /// Largest square of a velocity (m²/s²), as bits: these sort as the
    /// numbers do, and vector units have no doubt about them.
    fastest2: u64,
    /// All positions and spins are finite.
    finite: bool,
}

/// Advances the spheres by one time step: a = f/m (+ g), v += a Δt,
/// x += v Δt, and the same for spins. Returns the farthest way that a sphere
/// went (m).
///
/// `work` has room for what the forces on each sphere do, or is empty where that is not tracked.
///
/// # Errors
/// [`DemError::NotFinite`] names the first particle that is not finite.
pub(super) fn advance(
    particles: &mut Particles,
    centre: &mut [[f64; 4]],
    loads: Loads<'_>,
    step: Step,
    work: &mut [MotionWork],
) -> Result<f64, DemError> {
    let span = MoveSpan {
        position: &mut particles.position,
        velocity: &mut particles.velocity,
        spin: &mut particles.spin,
        centre,
        mass: &particles.mass,
        force: loads.force,
        torque: loads.torque,
        fluid: loads.fluid.unwrap_or(&[]),
        fluid_torque: loads.fluid_torque.unwrap_or(&[]),
        external_force: loads.external.map_or(&[], |e| &e.force),
        external_torque: loads.external.map_or(&[], |e| &e.torque),
        held: loads.held,
        work,
    };
    let external = loads.external.is_some();
    let arch = pulp::Arch::new();
    let run = |span: MoveSpan<'_>| arch.dispatch(Advance { span, step: &step, external });
    let found = for_blocks(span, &run, &|a: Found, b: Found| Found {
        fastest2: a.fastest2.max(b.fastest2),
        finite: a.finite & b.finite,
    });
    if found.finite {
        Ok(step.dt * f64::from_bits(found.fastest2).sqrt())
    } else {
        Err(first_not_finite(particles, loads))
    }
}

/// A run of blocks that moves.
struct MoveSpan<'a> {
    position: &'a mut [Vec3],
    velocity: &'a mut [Vec3],
    spin: &'a mut [Vec3],
    centre: &'a mut [[f64; 4]],
    mass: &'a [f64],
    force: &'a [Vec3],
    torque: &'a [Vec3],
    /// Empty without fluid.
    fluid: &'a [Vec3],
    fluid_torque: &'a [Vec3],
    /// Empty without external loads.
    external_force: &'a [Vec3],
    external_torque: &'a [Vec3],
    /// Empty where all move freely.
    held: &'a [bool],
    /// Empty where work is not tracked.
    work: &'a mut [MotionWork],
}

impl Span for MoveSpan<'_> {
    fn blocks(&self) -> usize {
        self.position.len().div_ceil(BLOCK)
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let n = blocks * BLOCK;
        let position = cut_mut(self.position, n);
        let velocity = cut_mut(self.velocity, n);
        let spin = cut_mut(self.spin, n);
        let centre = cut_mut(self.centre, n);
        let mass = cut(self.mass, n);
        let force = cut(self.force, n);
        let torque = cut(self.torque, n);
        let fluid = cut(self.fluid, n);
        let fluid_torque = cut(self.fluid_torque, n);
        let external_force = cut(self.external_force, n);
        let external_torque = cut(self.external_torque, n);
        let held = cut(self.held, n);
        let work = cut_mut(self.work, n);
        (
            MoveSpan {
                position: position.0,
                velocity: velocity.0,
                spin: spin.0,
                centre: centre.0,
                mass: mass.0,
                force: force.0,
                torque: torque.0,
                fluid: fluid.0,
                fluid_torque: fluid_torque.0,
                external_force: external_force.0,
                external_torque: external_torque.0,
                held: held.0,
                work: work.0,
            },
            MoveSpan {
                position: position.1,
                velocity: velocity.1,
                spin: spin.1,
                centre: centre.1,
                mass: mass.1,
                force: force.1,
                torque: torque.1,
                fluid: fluid.1,
                fluid_torque: fluid_torque.1,
                external_force: external_force.1,
                external_torque: external_torque.1,
                held: held.1,
                work: work.1,
            },
        )
    }
}

/// The motion of a run of blocks, compiled once more for processors with wider
/// vector units; the bits are the same.
struct Advance<'a> {
    span: MoveSpan<'a>,
    step: &'a Step,
    external: bool,
}

impl pulp::NullaryFnOnce for Advance<'_> {
    type Output = Found;

    #[inline(always)]
    fn call(self) -> Found {
        let Advance { span, step, external } = self;
        match span.held.is_empty() {
            true => span.choose::<false>(step, external),
            false => span.choose::<true>(step, external),
        }
    }
}

impl MoveSpan<'_> {
    #[inline(always)]
    fn choose<const HELD: bool>(self, step: &Step, external: bool) -> Found {
        match (step.rotation, external, !self.work.is_empty()) {
            (true, false, false) => self.advance::<HELD, true, false, false>(step),
            (false, false, false) => self.advance::<HELD, false, false, false>(step),
            (true, true, false) => self.advance::<HELD, true, true, false>(step),
            (false, true, false) => self.advance::<HELD, false, true, false>(step),
            (true, false, true) => self.advance::<HELD, true, false, true>(step),
            (false, false, true) => self.advance::<HELD, false, false, true>(step),
            (true, true, true) => self.advance::<HELD, true, true, true>(step),
            (false, true, true) => self.advance::<HELD, false, true, true>(step),
        }
    }

    #[inline(always)]
    fn advance<const HELD: bool, const ROTATION: bool, const EXTERNAL: bool, const WORK: bool>(
        self,
        step: &Step,
    ) -> Found {
        let dt = step.dt;
        let mut found = Found { fastest2: 0, finite: true };
        for k in 0..self.position.len() {
            if HELD && self.held[k] {
                if WORK {
                    self.work[k] = MotionWork::default();
                }
                continue;
            }
            let mut force = self.force[k];
            if let Some(fluid) = self.fluid.get(k) {
                force += fluid;
            }
            if EXTERNAL {
                force += self.external_force[k];
            }
            let inverse_mass = 1.0 / self.mass[k];
            let mut a = inverse_mass * force + step.gravity;
            let undamped = a;
            step.damping.damp(&mut a, &self.velocity[k], dt);
            let v = self.velocity[k] + dt * a;
            if WORK {
                // Each sphere's own, added up later: a sum would keep the loop from vector units.
                let way = 0.5 * (step.last_dt * self.velocity[k] + dt * v);
                self.work[k] = MotionWork {
                    damping: self.mass[k] * (undamped - a).dot(&way),
                    fluid: self.fluid.get(k).map_or(0.0, |fluid| fluid.dot(&way)),
                    external: if EXTERNAL { self.external_force[k].dot(&way) } else { 0.0 },
                    motion: 0.0,
                    step_change: step.excess() * self.mass[k] * a.dot(&self.velocity[k]),
                };
            }
            let [x, y, z, radius] = self.centre[k];
            let x = Vec3::new(x, y, z) + dt * v;
            self.velocity[k] = v;
            self.position[k] = x;
            self.centre[k] = [x.x, x.y, x.z, radius];
            let speed2 = v.norm_squared();
            found.fastest2 = found.fastest2.max(speed2.to_bits());
            let mut sum = speed2 + x.norm_squared();
            if ROTATION {
                let mut torque = self.torque[k];
                if let Some(fluid) = self.fluid_torque.get(k) {
                    torque += fluid;
                }
                if EXTERNAL {
                    torque += self.external_torque[k];
                }
                // I = 2/5 m r²
                let mut a = (2.5 * inverse_mass / (radius * radius)) * torque;
                let undamped = a;
                step.damping.damp(&mut a, &self.spin[k], dt);
                let spin = self.spin[k] + dt * a;
                if WORK {
                    let work = &mut self.work[k];
                    let turn = 0.5 * (step.last_dt * self.spin[k] + dt * spin);
                    let inertia = 0.4 * self.mass[k] * radius * radius;
                    work.damping += inertia * (undamped - a).dot(&turn);
                    work.step_change += step.excess() * inertia * a.dot(&self.spin[k]);
                    work.fluid += self.fluid_torque.get(k).map_or(0.0, |fluid| fluid.dot(&turn));
                    if EXTERNAL {
                        work.external += self.external_torque[k].dot(&turn);
                    }
                }
                self.spin[k] = spin;
                sum += spin.norm_squared();
            }
            found.finite &= sum.is_finite();
        }
        found
    }
}

/// Names the first particle with something that is not finite.
pub(super) fn first_not_finite(particles: &Particles, loads: Loads<'_>) -> DemError {
    let fluid = loads.fluid.unwrap_or(&[]);
    let external = |of: fn(&ExternalLoads) -> &[Vec3]| loads.external.map_or(&[][..], of);
    let bad = |v: Option<&Vec3>| v.is_some_and(|v| !v.iter().all(|c| c.is_finite()));
    for (i, &particle) in particles.id.iter().enumerate() {
        for (quantity, values) in [
            ("the fluid force", fluid),
            ("the fluid torque", loads.fluid_torque.unwrap_or(&[])),
            ("the external force", external(|e| &e.force)),
            ("the external torque", external(|e| &e.torque)),
            ("the contact force", loads.force),
            ("the contact torque", loads.torque),
            ("the velocity", &particles.velocity),
            ("the position", &particles.position),
            ("the spin", &particles.spin),
        ] {
            if bad(values.get(i)) {
                return DemError::NotFinite { particle, quantity };
            }
        }
    }
    // Every number is finite, but some sphere went so far or turned so fast
    // that a square overflowed.
    let far = |i: &usize| {
        !(particles.position[*i].norm_squared() + particles.spin[*i].norm_squared()).is_finite()
    };
    let particle = (0..particles.len()).find(far).map_or(0, |i| particles.id[i]);
    DemError::NotFinite { particle, quantity: "the motion" }
}
