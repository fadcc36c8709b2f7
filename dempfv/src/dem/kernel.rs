//! The contact law, stateless: numbers in, numbers out.

/// A vector as the kernels use it.
pub(super) type V = [f64; 3];

#[inline(always)]
pub(super) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + s b
#[inline(always)]
pub(super) fn add_scaled(a: V, s: f64, b: V) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline(always)]
pub(super) fn scaled(s: f64, a: V) -> V {
    [s * a[0], s * a[1], s * a[2]]
}

/// The part of `a` normal to the unit vector `n`.
#[inline(always)]
fn tangential(a: V, n: V) -> V {
    add_scaled(a, -dot(a, n), n)
}

/// How a contact moved during the last step.
pub(super) struct Sliding {
    /// Unit normal now.
    pub normal: V,
    /// Half the change of the normal during the step.
    pub half_turn: V,
    /// Mean rotation of the two bodies about the normal during the step (rad).
    pub twist: f64,
    /// Relative tangential displacement of the second body at the contact (m).
    pub slip: V,
}

/// The shear force on the second body after a step: the old force `shear`
/// turns with the contact, grows against the slip with `stiffness` (N/m), and
/// is cut at `limit` (N).
///
/// The turn takes the old normal n₀ to the new one n₁ along the shortest way:
/// s' = s − (s·n₁) m / (m·n₁), m = n₁ − (n₁ − n₀)/2, which is exact for s ⊥ n₀;
/// then s' turns about n₁ by the twist; then it gets back the length of s, so
/// that a contact carried around neither gains nor loses.
#[inline(always)]
pub(super) fn shear_force(shear: V, motion: &Sliding, stiffness: f64, limit: f64) -> V {
    let n = motion.normal;
    let along = dot(shear, n);
    let middle = add_scaled(n, -1.0, motion.half_turn);
    let s = add_scaled(shear, -along, middle);
    let s = add_scaled(s, motion.twist, cross(n, s));
    let turned2 = dot(s, s);
    let ratio = if turned2 > 0.0 { dot(shear, shear) / turned2 } else { 0.0 };
    let s = scaled(ratio.sqrt(), s);
    let s = add_scaled(s, -stiffness, motion.slip);
    let size2 = dot(s, s);
    let share = if size2 > limit * limit { limit / size2.sqrt() } else { 1.0 };
    scaled(share, s)
}

/// Contacts evaluated at a time: enough to fill vector units and to hide the
/// latency of roots and divisions, few enough to stay in the first cache.
pub(super) const LANES: usize = 64;

type Lane = [f64; LANES];

/// A batch of touching pairs, lane by lane.
pub(super) struct Batch {
    /// Pairs in the batch.
    pub count: usize,
    /// Place of each pair in the list it came from.
    pub slot: [usize; LANES],
    /// Vector from the first centre to the second (m), by component.
    pub apart: [Lane; 3],
    /// Its square (m²).
    pub distance2: Lane,
    /// Radius of the first and second sphere (m).
    pub radius: [Lane; 2],
    /// Velocity of the second relative to the first (m/s).
    pub velocity: [Lane; 3],
    /// Sum of the spins (rad/s).
    pub spin: [Lane; 3],
    /// Sum of radius times spin (m/s).
    pub rim: [Lane; 3],
    /// In: shear force before; out: after (N), on the second sphere.
    pub shear: [Lane; 3],
    /// Out: force on the second sphere (N).
    pub force: [Lane; 3],
    /// Out: normal × shear force (N).
    pub moment: [Lane; 3],
    /// Out: overlap (m).
    pub overlap: Lane,
}

impl Batch {
    /// An empty batch.
    pub fn new() -> Batch {
        const ZERO: Lane = [0.0; LANES];
        Batch {
            count: 0,
            slot: [0; LANES],
            apart: [ZERO; 3],
            distance2: ZERO,
            radius: [ZERO; 2],
            velocity: [ZERO; 3],
            spin: [ZERO; 3],
            rim: [ZERO; 3],
            shear: [ZERO; 3],
            force: [ZERO; 3],
            moment: [ZERO; 3],
            overlap: ZERO,
        }
    }
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

/// Evaluates the contacts of a batch.
#[inline(always)]
pub(super) fn evaluate<const FRICTION: bool, const ROTATION: bool>(b: &mut Batch, law: PairLaw) {
    let count = b.count.min(LANES);
    for l in 0..count {
        let (r1, r2) = (b.radius[0][l], b.radius[1][l]);
        let distance = b.distance2[l].sqrt();
        let inverse = 1.0 / distance;
        let normal = scaled(inverse, get(&b.apart, l));
        let overlap = (r1 + r2) - distance;
        let stiffness = law.pair * r1 * r2 / (r1 + r2);
        let push = stiffness * overlap;
        let mut force = scaled(push, normal);
        if FRICTION {
            let velocity = get(&b.velocity, l);
            let across = tangential(velocity, normal);
            let half_turn = scaled(0.5 * law.dt * inverse, across);
            let mut motion =
                Sliding { normal, half_turn, twist: 0.0, slip: scaled(law.dt, across) };
            if ROTATION {
                let spin = get(&b.spin, l);
                // Σ arm ω with the arms r − overlap/2
                let rim = add_scaled(get(&b.rim, l), -0.5 * overlap, spin);
                // The normal half way: a contact that only turns must not slip.
                let middle = add_scaled(normal, -1.0, half_turn);
                let slip = add_scaled(velocity, -1.0, cross(rim, middle));
                motion.twist = 0.5 * law.dt * dot(spin, normal);
                motion.slip = scaled(law.dt, tangential(slip, normal));
            }
            let old = get(&b.shear, l);
            // Not even round-off may change a force that has followed already.
            let shear = if law.dt == 0.0 {
                old
            } else {
                shear_force(old, &motion, law.ratio * stiffness, law.friction * push)
            };
            force = add_scaled(force, 1.0, shear);
            put(&mut b.shear, l, shear);
            if ROTATION {
                put(&mut b.moment, l, cross(normal, shear));
            }
        }
        put(&mut b.force, l, force);
        b.overlap[l] = overlap;
    }
}
