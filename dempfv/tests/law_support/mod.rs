//! What the tests of the granular law share.
#![allow(dead_code)] // each test file uses its part

use dempfv::dem::law::{GranularEffects, Hertz};
use dempfv::dem::{Dem, DemOptions, Material, WallMaterial};
use dempfv::{Aabb, Vec3};

use crate::dem_support::{bits, cloud};

pub const BOX: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(10.0, 10.0, 10.0) };

/// Hertz-Mindlin contacts alone.
pub fn hertz(poisson_ratio: f64) -> GranularEffects {
    let hertz = Hertz { poisson_ratio, wall_poisson_ratio: poisson_ratio };
    GranularEffects { hertz: Some(hertz), ..GranularEffects::default() }
}

/// What a collision of the first sphere was like.
#[derive(Clone, Copy, Debug, Default)]
pub struct Collision {
    /// Largest overlap (m).
    pub overlap: f64,
    /// Largest force (N).
    pub force: f64,
    /// From the first touch to the last, interpolated between steps (s).
    pub duration: f64,
}

/// Steps until the one contact that there is has come and gone.
pub fn collide(dem: &mut Dem, dt: f64) -> Collision {
    let (mut found, mut start, mut time) = (Collision::default(), None, 0.0);
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..1_000_000 {
        dem.step(dt).unwrap();
        time += dt;
        dem.compute_contacts().unwrap();
        let now = dem.contacts().next().map(|c| (c.overlap, dem.force(c.i as usize).norm()));
        match (before, now) {
            (_, Some((overlap, force))) => {
                found.overlap = found.overlap.max(overlap);
                found.force = found.force.max(force);
                start.get_or_insert(time - dt);
            }
            (Some(_), None) => {
                found.duration = time - dt - start.unwrap();
                return found;
            }
            (None, None) => {}
        }
        before = now;
    }
    panic!("no collision");
}

/// Kinetic energy of the velocities at the time of the positions, v + F/m Δt/2, and elastic
/// energy (J).
pub fn energy(dem: &Dem, dt: f64) -> f64 {
    let p = dem.storage();
    let kinetic: f64 = (0..p.len())
        .map(|i| {
            let inertia = 0.4 * p.mass[i] * p.radius[i].powi(2);
            let v = p.velocity[i] + dem.storage_forces()[i] * (0.5 * dt / p.mass[i]);
            let w = p.spin[i] + dem.storage_torques()[i] * (0.5 * dt / inertia);
            0.5 * (p.mass[i] * v.norm_squared() + inertia * w.norm_squared())
        })
        .sum();
    kinetic + dem.elastic_energy()
}

const ROUGH: Material =
    Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.4, density: 2600.0 };
const WALLS: WallMaterial = WallMaterial { young: 2e6, friction_angle: 0.3 };

/// A cloud that falls in on itself, every sphere with a spin of its own, with the walls far away; or
/// one that goes for the walls around it.
fn gas(law: GranularEffects, count: usize, inwards: f64, box_: Aabb) -> Dem {
    let mut p = cloud(count, 5);
    for i in 0..p.len() {
        let centre = Vec3::repeat(0.5) - p.position[i];
        let random = Vec3::new(
            (1e5 * p.radius[i]).sin(),
            (2e5 * p.radius[i]).sin(),
            (3e5 * p.radius[i]).cos(),
        );
        p.velocity[i] = inwards * centre + 0.5 * random;
        p.spin[i] = 20.0 * random;
    }
    Dem::with_effects(law, p, box_, &[ROUGH], WALLS, DemOptions::default()).unwrap()
}

/// What holds for all effects: actions and reactions cancel, to round-off, in momentum and angular
/// momentum; a restart in the middle and the number of threads change no bit.
pub fn same_bits(law: impl Fn() -> GranularEffects + Sync) {
    let dt = 1e-4;
    let mut dem = gas(law(), 1000, 2.0, Aabb { min: Vec3::repeat(-9.0), max: Vec3::repeat(10.0) });
    let sums = |dem: &Dem| {
        let p = dem.storage();
        let each = (0..p.len()).map(|i| {
            let inertia = 0.4 * p.mass[i] * p.radius[i].powi(2);
            let momentum = p.mass[i] * p.velocity[i];
            (momentum, p.position[i].cross(&momentum) + inertia * p.spin[i])
        });
        each.fold((Vec3::zeros(), Vec3::zeros(), 0.0, 0.0), |(p, l, a, b), (dp, dl)| {
            (p + dp, l + dl, a + dp.norm(), b + dl.norm())
        })
    };
    let (momentum, angular, scale, angular_scale) = sums(&dem);
    let mut contacts = 0;
    for _ in 0..2500 {
        dem.step(dt).unwrap();
        contacts = contacts.max(dem.contacts().count());
    }
    assert!(contacts > 60, "only {contacts} contacts at a time: no test");
    let after = sums(&dem);
    assert!((after.0 - momentum).norm() < 1e-12 * scale, "{}", after.0 - momentum);
    assert!((after.1 - angular).norm() < 1e-12 * angular_scale, "{}", after.1 - angular);

    let run = |threads: usize, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
            let mut dem = gas(law(), 3000, -2.0, unit);
            let (mut walls, mut contacts) = (0, 0);
            for step in 0..400 {
                dem.step(dt).unwrap();
                walls = walls.max(dem.wall_contact_count());
                contacts = contacts.max(dem.sphere_contact_count());
                if stop && step == 250 {
                    let state = postcard::to_stdvec(&dem.state()).unwrap();
                    let state = postcard::from_bytes(&state).unwrap();
                    let options = DemOptions::default();
                    dem = Dem::with_effects_from_state(law(), state, &[ROUGH], WALLS, options)
                        .unwrap();
                }
            }
            assert!(walls > 5 && contacts > 30, "{walls} {contacts}: no test");
            bits(&dem)
        })
    };
    let one = run(1, false);
    assert!(one == run(2, false), "two threads");
    assert!(one == run(1, true), "a restart");
}
