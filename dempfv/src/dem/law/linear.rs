//! The linear elastic-frictional law (Cundall and Strack 1979).

use super::batch::{Batch, Lane, ZERO_LANE, get, put};
use super::contact_law::{ContactForce, ContactLaw, Needs, Stiffness};
use super::geometry::{Geometry, Radii};
use super::loss::Loss;
use super::turn::turn;
use super::vector::{Vector, add_scaled, cross, dot, scaled};
use crate::Vec3;
use crate::dem::material::{Material, WallMaterial};
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const CONTACTS: Effect = Effect {
    name: "contacts",
    family: Family::Contacts,
    equation: "F_n = k_n δ, k_n = 2 E r₁ r₂ / (r₁ + r₂) between spheres, 2 E E_w / (E + E_w) r on a wall",
    source: "P. A. Cundall, O. D. L. Strack: Géotechnique 29 (1979)",
    keys: &[
        EffectKey { key: "young in [particles]", unit: "Pa", default: "1e6" },
        EffectKey { key: "young in [walls]", unit: "Pa", default: "the spheres'" },
    ],
    needs: "",
    test: "dempfv/tests/dem_conservation.rs",
};

/// What this effect says of itself.
pub const FRICTION: Effect = Effect {
    name: "friction",
    family: Family::Contacts,
    equation: "dF_s = −k_s ds, k_s = (k_s/k_n) k_n, |F_s| ≤ F_n tan φ; F_s turns with the contact",
    source: "P. A. Cundall, O. D. L. Strack: Géotechnique 29 (1979)",
    keys: &[
        EffectKey { key: "friction_angle in [particles]", unit: "degrees", default: "30" },
        EffectKey { key: "stiffness_ratio in [particles]", unit: "", default: "0.5" },
        EffectKey {
            key: "friction_angle in a run stage",
            unit: "degrees",
            default: "the spheres'",
        },
    ],
    needs: "rotation, unless it is switched off",
    test: "dempfv/tests/dem_conservation.rs, dempfv/tests/dem_energy.rs",
};

/// Linear springs with Coulomb's friction: F_n = k_n δ along the normal, and
/// across it a force that grows by k_s times the slip, turns with the
/// contact, and is cut at F_n tan φ.
///
/// k_n = 2 E r₁ r₂ / (r₁ + r₂) between spheres and
/// k_n = 2 E E_w / (E + E_w) r on a wall; k_s = (k_s/k_n) k_n. Between two
/// materials, E is the harmonic mean of the moduli, k_s/k_n the mean of the
/// ratios, and φ the smaller angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linear;

/// Constants of the linear law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearParameters {
    /// k_n over the reduced radius (Pa).
    pub modulus: f64,
    /// k_s / k_n.
    pub ratio: f64,
    /// Friction coefficient.
    pub friction: f64,
}

/// What the loops of the kernel hand on.
#[derive(Debug)]
pub struct LinearScratch {
    /// Normal stiffness (N/m).
    stiffness: Lane,
    /// See [`turn`].
    turned: [Lane; 3],
    ratio: Lane,
    /// See [`grow`].
    loss: [Lane; 3],
}

impl Default for LinearScratch {
    fn default() -> LinearScratch {
        LinearScratch {
            stiffness: ZERO_LANE,
            turned: [ZERO_LANE; 3],
            ratio: ZERO_LANE,
            loss: [ZERO_LANE; 3],
        }
    }
}

impl ContactLaw for Linear {
    /// Shear force on the second body (N).
    type History = [f64; 3];
    type Parameters = LinearParameters;
    type Scratch = LinearScratch;

    fn name(&self) -> &'static str {
        "linear"
    }

    fn between_spheres(&self, first: &Material, second: &Material) -> LinearParameters {
        let (a, b) = (first.young, second.young);
        LinearParameters {
            modulus: if a == b { 2.0 * a } else { 4.0 * a * b / (a + b) },
            ratio: 0.5 * (first.stiffness_ratio + second.stiffness_ratio),
            friction: first.friction_angle.min(second.friction_angle).tan(),
        }
    }

    fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> LinearParameters {
        LinearParameters {
            modulus: 2.0 * sphere.young * wall.young / (sphere.young + wall.young),
            ratio: sphere.stiffness_ratio,
            friction: sphere.friction_angle.min(wall.friction_angle).tan(),
        }
    }

    fn needs(&self, parameters: &LinearParameters) -> Needs {
        // Without friction nothing turns a sphere.
        if parameters.friction > 0.0 { Needs::Torques } else { Needs::Overlap }
    }

    #[inline(always)]
    fn stiffness(&self, p: &LinearParameters, radii: impl Radii, _: f64) -> Stiffness {
        let normal = radii.reduced(p.modulus);
        Stiffness { normal, shear: if p.friction > 0.0 { p.ratio * normal } else { 0.0 } }
    }

    fn force(
        &self,
        p: &LinearParameters,
        radii: impl Radii,
        overlap: f64,
        history: &[f64; 3],
    ) -> ContactForce {
        let normal = self.stiffness(p, radii, overlap).normal * overlap.max(0.0);
        ContactForce { normal, shear: Vec3::from(*history) }
    }

    /// F_n² / 2k_n + F_s² / 2k_s
    fn elastic_energy(
        &self,
        p: &LinearParameters,
        radii: impl Radii,
        overlap: f64,
        history: &[f64; 3],
    ) -> f64 {
        let stiffness = self.stiffness(p, radii, overlap).normal;
        let ContactForce { normal, shear } = self.force(p, radii, overlap, history);
        let shear = shear.norm_squared();
        let tangential = if shear > 0.0 { shear / (p.ratio * stiffness) } else { 0.0 };
        0.5 * (normal.powi(2) / stiffness + tangential)
    }

    fn reversed(&self, history: [f64; 3]) -> [f64; 3] {
        history.map(|x| -x)
    }

    #[inline(always)]
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, [f64; 3]>,
        scratch: &mut LinearScratch,
        parameters: impl Fn(usize) -> LinearParameters + Copy,
    ) {
        for l in batch.lanes() {
            let (radii, overlap) = (batch.geometry.radii(l), batch.geometry.overlap(l));
            scratch.stiffness[l] = self.stiffness(&parameters(l), radii, overlap).normal;
        }
        if MOTION && batch.dt != 0.0 {
            follow::<G, TORQUES>(batch, scratch, parameters);
            slide(batch, scratch, parameters);
            if batch.tracks_energy {
                lose(batch, scratch, parameters);
            }
        }
        sum::<G, MOTION, TORQUES>(batch, scratch);
    }
}

/// Turns the shear forces with the contacts and finds what slip takes.
#[inline(always)]
fn follow<G: Geometry, const TORQUES: bool>(
    batch: &Batch<G, [f64; 3]>,
    scratch: &mut LinearScratch,
    parameters: impl Fn(usize) -> LinearParameters,
) {
    for l in batch.lanes() {
        let motion = batch.geometry.sliding::<TORQUES>(l, batch.dt);
        let (turned, ratio) = turn(get(&batch.history, l), &motion);
        put(&mut scratch.turned, l, turned);
        scratch.ratio[l] = ratio;
        let stiffness = parameters(l).ratio * scratch.stiffness[l];
        put(&mut scratch.loss, l, scaled(stiffness, motion.slip));
    }
}

/// The shear forces after the step.
#[inline(always)]
fn slide<G: Geometry>(
    batch: &mut Batch<G, [f64; 3]>,
    scratch: &LinearScratch,
    parameters: impl Fn(usize) -> LinearParameters,
) {
    for l in batch.lanes() {
        let normal = scratch.stiffness[l] * batch.geometry.overlap(l);
        let limit = parameters(l).friction * normal;
        let (turned, loss) = (get(&scratch.turned, l), get(&scratch.loss, l));
        put(&mut batch.history, l, grow(turned, scratch.ratio[l], loss, limit));
    }
}

/// What slip has dissipated: ½ (s₀ + s₁) · (s* − s₁) / k_s, where s₀ is the turned shear force of
/// before, s* what it would be without the limit, s₁ what it is. With s² / 2k_s this is the whole
/// work of the mean force over the slip.
#[inline(always)]
fn lose<G: Geometry>(
    batch: &mut Batch<G, [f64; 3]>,
    scratch: &LinearScratch,
    parameters: impl Fn(usize) -> LinearParameters,
) {
    let mut lost = ZERO_LANE;
    for l in batch.lanes() {
        let before = scaled(scratch.ratio[l].sqrt(), get(&scratch.turned, l));
        let trial = add_scaled(before, -1.0, get(&scratch.loss, l));
        let now = get(&batch.history, l);
        let work = dot(add_scaled(before, 1.0, now), add_scaled(trial, -1.0, now));
        let stiffness = parameters(l).ratio * scratch.stiffness[l];
        lost[l] = if stiffness > 0.0 { 0.5 * work / stiffness } else { 0.0 };
    }
    batch.book(Loss::Friction, &lost);
}

/// Forces and torques.
#[inline(always)]
fn sum<G: Geometry, const MOTION: bool, const TORQUES: bool>(
    batch: &mut Batch<G, [f64; 3]>,
    scratch: &LinearScratch,
) {
    for l in batch.lanes() {
        let normal = batch.geometry.normal(l);
        let mut force = scaled(scratch.stiffness[l] * batch.geometry.overlap(l), normal);
        if MOTION {
            let shear = get(&batch.history, l);
            force = add_scaled(force, 1.0, shear);
            if TORQUES {
                let moment = cross(normal, shear);
                let [first, second] = batch.geometry.arms(l);
                put(&mut batch.torque[0], l, scaled(-first, moment));
                put(&mut batch.torque[1], l, scaled(-second, moment));
            }
        }
        put(&mut batch.force, l, force);
    }
}

/// The shear force: `turned` with its length back, less `loss` (N) that the
/// slip takes, cut at `limit` (N).
#[inline(always)]
fn grow(turned: Vector, ratio: f64, loss: Vector, limit: f64) -> Vector {
    let s = scaled(ratio.sqrt(), turned);
    let s = add_scaled(s, -1.0, loss);
    let size2 = dot(s, s);
    let share = if size2 > limit * limit { limit / size2.sqrt() } else { 1.0 };
    scaled(share, s)
}

#[cfg(test)]
mod tests {
    use super::super::batch::CONTACTS_PER_BATCH;
    use super::super::geometry::SpherePairs;
    use super::*;

    const PARAMETERS: LinearParameters =
        LinearParameters { modulus: 2e6, ratio: 0.5, friction: 0.4 };

    /// A full batch of contacts of unit spheres that slide, roll and twist,
    /// with shear forces near what friction allows, so that some are cut.
    fn busy() -> Batch<SpherePairs, [f64; 3]> {
        let mut batch = Batch::<SpherePairs, [f64; 3]>::new(1e-4, false);
        batch.count = CONTACTS_PER_BATCH;
        let mut x = 0.0f64;
        let mut next = || {
            x += 1.0;
            (x * x).sin()
        };
        let pairs = &mut batch.geometry;
        pairs.radius = [[1.0; CONTACTS_PER_BATCH]; 2];
        for l in 0..CONTACTS_PER_BATCH {
            let apart = [next(), next(), next()];
            put(&mut pairs.apart, l, scaled(1.99 / dot(apart, apart).sqrt(), apart));
            put(&mut pairs.velocity, l, [next(), next(), next()]);
            put(&mut batch.history, l, scaled(5e3, [next(), next(), next()]));
            put(&mut pairs.spin[0], l, [next(), next(), next()]);
            put(&mut pairs.spin[1], l, [next(), next(), next()]);
        }
        batch
    }

    struct Run(Batch<SpherePairs, [f64; 3]>);

    impl pulp::NullaryFnOnce for Run {
        type Output = Vec<u64>;

        #[inline(always)]
        fn call(mut self) -> Vec<u64> {
            for l in self.0.lanes() {
                self.0.geometry.measure(l);
            }
            let mut scratch = LinearScratch::default();
            Linear.evaluate::<_, true, true>(&mut self.0, &mut scratch, |_| PARAMETERS);
            let Batch { history, force, torque: [a, b], .. } = self.0;
            [history, force, a, b].iter().flatten().flatten().map(|x| x.to_bits()).collect()
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
