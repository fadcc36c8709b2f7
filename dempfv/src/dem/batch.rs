//! Contacts of spheres evaluated a batch at a time.
//!
//! A batch is filled with rows (one sphere or contact each) and evaluated by
//! loops over its lanes, which compilers turn into vector instructions. Each
//! loop is short, so that a processor looks ahead over several of its turns
//! and hides the latency of roots and divisions.

use super::kernel::{Sliding, V, add_scaled, cross, dot, grow, scaled, tangential, turn};

/// Contacts evaluated at a time: enough to fill vector units and to hide
/// latencies, few enough to stay in the first cache.
pub(super) const LANES: usize = 32;

/// The widest vectors hold so many numbers.
const WIDTH: usize = 8;

type Lane = [f64; LANES];

/// A batch of touching pairs. The arrays of pairs hold the first and the
/// second sphere's.
pub(super) struct Batch {
    /// Pairs in the batch.
    pub count: usize,
    /// Place of each pair in the range that it came from.
    pub slot: [u32; LANES],
    /// Indices of the spheres.
    pub pair: [[u32; 2]; LANES],
    /// Vector from the first centre to the second (m).
    pub apart: [Lane; 3],
    /// Radii (m).
    pub radius: [Lane; 2],
    /// Velocity of the second sphere relative to the first (m/s).
    pub velocity: [Lane; 3],
    /// Spins (rad/s).
    pub spin: [[Lane; 3]; 2],
    /// In: shear force before; out: after (N), on the second sphere.
    pub shear: [Lane; 3],
    /// Out: force on the second sphere (N).
    pub force: [Lane; 3],
    /// Out: torques (N m), that on the first sphere with the sign changed.
    pub torque: [[Lane; 3]; 2],
    normal: [Lane; 3],
    /// 1 / distance (1/m)
    inverse: Lane,
    overlap: Lane,
    /// Normal stiffness (N/m).
    stiffness: Lane,
    /// See [`turn`].
    turned: [Lane; 3],
    ratio: Lane,
    /// See [`grow`].
    loss: [Lane; 3],
}

/// The constants of a pass.
#[derive(Clone, Copy)]
pub(super) struct PairLaw {
    /// k_n = `pair` r₁ r₂ / (r₁ + r₂) (`pair` in Pa).
    pub pair: f64,
    /// k_s / k_n.
    pub ratio: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Length of the step whose motion the shear forces follow (s), or 0 if
    /// they have followed it already.
    pub dt: f64,
}

#[inline(always)]
pub(super) fn get(lanes: &[Lane; 3], l: usize) -> V {
    [lanes[0][l], lanes[1][l], lanes[2][l]]
}

#[inline(always)]
pub(super) fn put(lanes: &mut [Lane; 3], l: usize, v: V) {
    lanes[0][l] = v[0];
    lanes[1][l] = v[1];
    lanes[2][l] = v[2];
}

impl Batch {
    pub fn new() -> Batch {
        const ZERO: Lane = [0.0; LANES];
        Batch {
            count: 0,
            slot: [0; LANES],
            pair: [[0; 2]; LANES],
            apart: [ZERO; 3],
            radius: [ZERO; 2],
            velocity: [ZERO; 3],
            spin: [[ZERO; 3]; 2],
            shear: [ZERO; 3],
            force: [ZERO; 3],
            torque: [[ZERO; 3]; 2],
            normal: [ZERO; 3],
            inverse: ZERO,
            overlap: ZERO,
            stiffness: ZERO,
            turned: [ZERO; 3],
            ratio: ZERO,
            loss: [ZERO; 3],
        }
    }

    /// Evaluates the contacts: what goes in and out is said at the fields.
    #[inline(always)]
    pub fn evaluate<const FRICTION: bool, const ROTATION: bool>(&mut self, law: PairLaw) {
        // Whole vectors: what the lanes beyond the last contact hold does no
        // harm.
        let lanes = self.count.next_multiple_of(WIDTH).min(LANES);
        self.touch(lanes, law);
        // Not even round-off may change a force that has followed already.
        if FRICTION && law.dt != 0.0 {
            self.follow::<ROTATION>(lanes, law);
            self.slide(lanes, law);
        }
        self.sum::<FRICTION, ROTATION>(lanes);
    }

    /// Normals, overlaps and stiffnesses.
    #[inline(always)]
    fn touch(&mut self, lanes: usize, law: PairLaw) {
        for l in 0..lanes.min(LANES) {
            let (r1, r2) = (self.radius[0][l], self.radius[1][l]);
            let apart = get(&self.apart, l);
            let distance = dot(apart, apart).sqrt();
            let inverse = 1.0 / distance;
            put(&mut self.normal, l, scaled(inverse, apart));
            self.inverse[l] = inverse;
            self.overlap[l] = (r1 + r2) - distance;
            self.stiffness[l] = law.pair * r1 * r2 / (r1 + r2);
        }
    }

    /// Turns the shear forces with the contacts and finds what slip adds.
    #[inline(always)]
    fn follow<const ROTATION: bool>(&mut self, lanes: usize, law: PairLaw) {
        for l in 0..lanes.min(LANES) {
            let normal = get(&self.normal, l);
            let velocity = get(&self.velocity, l);
            let across = tangential(velocity, normal);
            let half_turn = scaled(0.5 * law.dt * self.inverse[l], across);
            let mut motion =
                Sliding { normal, half_turn, twist: 0.0, slip: scaled(law.dt, across) };
            if ROTATION {
                let (a, b) = (get(&self.spin[0], l), get(&self.spin[1], l));
                let (r1, r2) = (self.radius[0][l], self.radius[1][l]);
                let spin = add_scaled(a, 1.0, b);
                // Σ arm ω with the arms r − overlap/2
                let rim = add_scaled(scaled(r1, a), r2, b);
                let rim = add_scaled(rim, -0.5 * self.overlap[l], spin);
                // The normal half way: a contact that only turns must not slip.
                let middle = add_scaled(normal, -1.0, half_turn);
                let slip = add_scaled(velocity, -1.0, cross(rim, middle));
                motion.twist = 0.5 * law.dt * dot(spin, normal);
                motion.slip = scaled(law.dt, tangential(slip, normal));
            }
            let (turned, ratio) = turn(get(&self.shear, l), &motion);
            put(&mut self.turned, l, turned);
            self.ratio[l] = ratio;
            put(&mut self.loss, l, scaled(law.ratio * self.stiffness[l], motion.slip));
        }
    }

    /// The shear forces after the step.
    #[inline(always)]
    fn slide(&mut self, lanes: usize, law: PairLaw) {
        for l in 0..lanes.min(LANES) {
            let limit = law.friction * (self.stiffness[l] * self.overlap[l]);
            let shear = grow(get(&self.turned, l), self.ratio[l], get(&self.loss, l), limit);
            put(&mut self.shear, l, shear);
        }
    }

    /// Forces and torques.
    #[inline(always)]
    fn sum<const FRICTION: bool, const ROTATION: bool>(&mut self, lanes: usize) {
        for l in 0..lanes.min(LANES) {
            let normal = get(&self.normal, l);
            let mut force = scaled(self.stiffness[l] * self.overlap[l], normal);
            if FRICTION {
                let shear = get(&self.shear, l);
                force = add_scaled(force, 1.0, shear);
                if ROTATION {
                    let half = 0.5 * self.overlap[l];
                    let moment = cross(normal, shear);
                    put(&mut self.torque[0], l, scaled(self.radius[0][l] - half, moment));
                    put(&mut self.torque[1], l, scaled(half - self.radius[1][l], moment));
                }
            }
            put(&mut self.force, l, force);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: PairLaw = PairLaw { pair: 2e6, ratio: 0.5, friction: 0.4, dt: 1e-4 };

    /// A full batch of contacts of unit spheres that slide, roll and twist,
    /// with shear forces near what friction allows, so that some are cut.
    fn busy() -> Batch {
        let mut batch = Batch::new();
        batch.count = LANES;
        let mut x = 0.0f64;
        let mut next = || {
            x += 1.0;
            (x * x).sin()
        };
        batch.radius = [[1.0; LANES]; 2];
        for l in 0..LANES {
            let apart = [next(), next(), next()];
            put(&mut batch.apart, l, scaled(1.99 / dot(apart, apart).sqrt(), apart));
            put(&mut batch.velocity, l, [next(), next(), next()]);
            put(&mut batch.shear, l, scaled(5e3, [next(), next(), next()]));
            put(&mut batch.spin[0], l, [next(), next(), next()]);
            put(&mut batch.spin[1], l, [next(), next(), next()]);
        }
        batch
    }

    struct Run(Batch);

    impl pulp::NullaryFnOnce for Run {
        type Output = Vec<u64>;

        #[inline(always)]
        fn call(mut self) -> Vec<u64> {
            self.0.evaluate::<true, true>(LAW);
            let Batch { shear, force, torque: [a, b], .. } = self.0;
            [shear, force, a, b].iter().flatten().flatten().map(|x| x.to_bits()).collect()
        }
    }

    #[test]
    fn wider_vectors_change_no_bit() {
        let plain = pulp::NullaryFnOnce::call(Run(busy()));
        let forces = plain.iter().map(|&bits| f64::from_bits(bits));
        assert!(forces.clone().all(f64::is_finite) && forces.sum::<f64>() != 0.0);
        assert_eq!(pulp::Arch::new().dispatch(Run(busy())), plain);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            assert_eq!(simd.vectorize(Run(busy())), plain);
        }
    }
}
