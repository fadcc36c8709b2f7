//! A law that acts across a gap: the neighbour list reaches as far, and a
//! contact keeps its history there.

mod dem_support;

use dem_support::{UNIT, frictionless_walls, material};
use dempfv::Vec3;
use dempfv::dem::law::vector::scaled;
use dempfv::dem::law::{Batch, ContactForce, ContactLaw, Geometry, Needs, Radii, Stiffness, put};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};

const CUT_OFF: f64 = 0.05;
const STIFFNESS: f64 = 1e4;

/// A spring that pulls across gaps of up to 5 cm, and counts the steps since
/// it has begun.
#[derive(Clone, Copy, Debug)]
struct LongSpring;

impl ContactLaw for LongSpring {
    type History = [f64; 2];
    type Parameters = ();
    type Scratch = ();

    fn name(&self) -> &'static str {
        "long spring"
    }

    fn between_spheres(&self, _: &Material, _: &Material) {}

    fn on_wall(&self, _: &Material, _: &WallMaterial) {}

    fn needs(&self, (): &()) -> Needs {
        Needs::Motion
    }

    fn cut_off(&self) -> f64 {
        CUT_OFF
    }

    fn stiffness(&self, (): &(), _: impl Radii, _: f64) -> Stiffness {
        Stiffness { normal: STIFFNESS, shear: 0.0 }
    }

    fn force(&self, (): &(), _: impl Radii, overlap: f64, _: &[f64; 2]) -> ContactForce {
        ContactForce { normal: STIFFNESS * overlap, shear: Vec3::zeros() }
    }

    fn elastic_energy(&self, (): &(), _: impl Radii, overlap: f64, _: &[f64; 2]) -> f64 {
        0.5 * STIFFNESS * overlap.powi(2)
    }

    /// The second number has the sign of a force, to see that it follows.
    fn reversed(&self, [steps, signed]: [f64; 2]) -> [f64; 2] {
        [steps, -signed]
    }

    #[inline(always)]
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, [f64; 2]>,
        (): &mut (),
        _: impl Fn(usize) + Copy,
    ) {
        for l in batch.lanes() {
            let force = scaled(STIFFNESS * batch.geometry.overlap(l), batch.geometry.normal(l));
            put(&mut batch.force, l, force);
            if batch.dt != 0.0 {
                batch.history[0][l] += 1.0;
                batch.history[1][l] = force[0];
            }
        }
    }
}

/// Two spheres with a gap between them, with a list that is renewed all the
/// time.
fn pair(gap: f64) -> Dem {
    let centres = vec![Vec3::new(0.7 + gap, 0.5, 0.5), Vec3::new(0.5, 0.5, 0.5)];
    let spheres = Particles::new(centres, vec![0.1; 2], 2600.0);
    let options = DemOptions { skin: 1e-4, ..DemOptions::default() };
    let walls = frictionless_walls();
    Dem::with_law(LongSpring, spheres, UNIT, &[material()], walls, options).unwrap()
}

/// The gap swings with ω = √(2k/m), and the energy stays.
#[test]
fn a_force_acts_across_the_gap() {
    let mut dem = pair(0.04);
    let frequency = (2.0 * STIFFNESS / dem.mass(0)).sqrt();
    let gap = |dem: &Dem| (dem.position(0) - dem.position(1)).norm() - 0.2;
    let dt = 1e-3 / frequency;
    dem.compute_contacts().unwrap();
    assert_eq!(dem.sphere_contact_count(), 1);
    let start = dem.elastic_energy();
    assert!((start / (0.5 * STIFFNESS * 0.04f64.powi(2)) - 1.0).abs() < 1e-12);
    // A third of a period: cos(2π/3) = −1/2.
    let steps = (2.0 * std::f64::consts::PI / 3.0 / 1e-3).round() as usize;
    for _ in 0..steps {
        dem.step(dt).unwrap();
    }
    assert!((gap(&dem) / -0.02 - 1.0).abs() < 1e-3, "{}", gap(&dem));
    let all = dem.kinetic_energy() + dem.elastic_energy();
    assert!((all / start - 1.0).abs() < 2e-3, "{all} {start}");
    // One step less than forces: histories follow the step before.
    let history = dem.state().sphere_history.numbers;
    assert_eq!(history[0], (steps - 1) as f64);
}

/// Beyond the cut-off there is neither force nor history.
#[test]
fn nothing_acts_beyond_the_cut_off() {
    let mut dem = pair(0.049);
    dem.step(1e-5).unwrap();
    dem.step(1e-5).unwrap();
    assert_eq!(dem.state().sphere_history.numbers[0], 1.0);
    dem.set_velocity(0, Vec3::new(10.0, 0.0, 0.0));
    for _ in 0..20 {
        dem.step(1e-5).unwrap();
    }
    assert_eq!(dem.sphere_contact_count(), 0);
    assert!(dem.state().sphere_history.bodies.is_empty());
    assert_eq!(dem.force(1), Vec3::zeros());
    let mut far = pair(0.051);
    far.step(1e-5).unwrap();
    assert_eq!(far.sphere_contact_count(), 0);
}

/// A sphere near a wall feels it, too.
#[test]
fn walls_pull_across_the_gap() {
    let spheres = Particles::new(vec![Vec3::new(0.5, 0.13, 0.5)], vec![0.1], 2600.0);
    let walls = frictionless_walls();
    let options = DemOptions::default();
    let mut dem = Dem::with_law(LongSpring, spheres, UNIT, &[material()], walls, options).unwrap();
    dem.compute_contacts().unwrap();
    assert_eq!(dem.wall_contact_count(), 1);
    assert!((dem.force(0).y / (-STIFFNESS * 0.03) - 1.0).abs() < 1e-12);
}

/// Sorting renumbers the spheres in storage: a history that has a sign is
/// turned around where two spheres change places.
#[test]
fn histories_follow_a_new_order() {
    let centres: Vec<_> = (0..40)
        .map(|k| Vec3::new(0.1 + 0.2 * f64::from(k % 5), 0.1 + 0.1 * f64::from(k / 5), 0.5))
        .collect();
    let spheres = Particles::new(centres, vec![0.045; 40], 2600.0);
    let walls = frictionless_walls();
    let options = DemOptions::default();
    let dem = Dem::with_law(LongSpring, spheres, UNIT, &[material()], walls, options).unwrap();
    // The other way round in storage.
    let mut state = dem.state();
    state.particles.id.reverse();
    state.particles.position.reverse();
    let mut dem =
        Dem::with_law_from_state(LongSpring, state, &[material()], walls, options).unwrap();
    for i in 0..40 {
        let x = dem.position(i);
        dem.set_velocity(i, 1e-2 * Vec3::new((40.0 * x.y).sin(), (30.0 * x.x).cos(), 0.0));
    }
    for _ in 0..300 {
        dem.step(1e-4).unwrap();
    }
    dem.compute_contacts().unwrap();
    // The signed number of each pair, seen from the sphere with the smaller
    // number of the user's.
    let seen = |dem: &Dem| {
        let state = dem.state();
        let pairs = state.sphere_history.bodies.iter().enumerate();
        let mut seen: Vec<_> = pairs
            .map(|(k, pair)| {
                let [a, b] = pair.map(|i| state.particles.id[i as usize]);
                let signed = state.sphere_history.numbers[2 * k + 1];
                (a.min(b), a.max(b), if a < b { signed } else { -signed })
            })
            .collect();
        seen.sort_by_key(|&(a, b, _)| (a, b));
        seen
    };
    let (before, order) = (seen(&dem), dem.storage().id.clone());
    assert!(before.iter().any(|s| s.2 != 0.0));
    dem.sort_spatially().unwrap();
    assert!(dem.storage().id != order, "the order is the same: no test");
    assert_eq!(seen(&dem), before);
}
