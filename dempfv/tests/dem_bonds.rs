//! Brittle bonds.

mod dem_support;
mod law_support;

use std::f64::consts::PI;

use dem_support::{bits, frictionless_walls, settled};
use dempfv::Vec3;
use dempfv::dem::law::{Adhesion, Bonds, Granular, GranularEffects, Hertz};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles};
use law_support::BOX;

const MATERIAL: Material =
    Material { young: 1e8, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
const BONDS: Bonds = Bonds { tension: 2e5, cohesion: 3e5, interaction_range: 1.02 };
const R: f64 = 0.1;

fn law() -> GranularEffects {
    GranularEffects { bonds: Some(BONDS), ..GranularEffects::default() }
}

/// A row of bonded spheres along x, with gaps and overlaps of a percent in turns, whose ends are
/// so heavy that only the motion given counts.
fn column(count: usize) -> Dem {
    let gap = |k: usize| if k.is_multiple_of(2) { 0.01 } else { -0.01 } * R;
    let mut x = vec![Vec3::new(3.0, 5.0, 5.0)];
    for k in 1..count {
        x.push(x[k - 1] + Vec3::new(2.0 * R + gap(k), 0.0, 0.0));
    }
    let mut p = Particles::new(x, vec![R; count], MATERIAL.density);
    p.mass[0] = 1e30;
    p.mass[count - 1] = 1e30;
    let options = DemOptions { damping: 0.3, ..DemOptions::default() };
    let walls = frictionless_walls();
    let mut dem = Dem::with_effects(law(), p, BOX, &[MATERIAL], walls, options).unwrap();
    assert_eq!(dem.bond().unwrap(), count as u64 - 1);
    dem
}

/// Force on the first sphere (N).
fn pull(dem: &mut Dem) -> Vec3 {
    dem.compute_contacts().unwrap();
    dem.force(0)
}

/// What pressed contacts store is gone once they are bonded, and is no residual of the energy.
#[test]
fn bonds_made_later_leave_no_residual() {
    let position = [0.0, 1.9 * R, 3.8 * R].map(|d| Vec3::new(3.0 + d, 5.0, 5.0));
    let p = Particles::new(position.to_vec(), vec![R; 3], MATERIAL.density);
    let options = DemOptions { damping: 0.3, ..DemOptions::default() };
    let walls = frictionless_walls();
    let mut dem = Dem::with_effects(law(), p, BOX, &[MATERIAL], walls, options).unwrap();
    dem.compute_contacts().unwrap();
    dem.track_energy(true);
    for _ in 0..10 {
        dem.step(1e-6).unwrap();
    }
    let before = dem.energy_balance().unwrap();
    assert_eq!(dem.bond().unwrap(), 2);
    dem.step(1e-6).unwrap();
    let after = dem.energy_balance().unwrap();
    assert!(after.elastic < 1e-3 * before.elastic, "{after:?}");
    assert!(after.residual.abs() < 1e-3 * before.elastic, "{after:?}");
}

/// Bonds hold nothing at first, then as springs in series; a column pulled apart breaks at σ_t A, at
/// one bond, and hangs together no more. Pushed together again it bears pressure, and no tension
/// ever.
#[test]
fn a_column_breaks_at_its_strength() {
    let count = 6;
    let mut dem = column(count);
    assert_eq!(pull(&mut dem), Vec3::zeros());
    let stiffness = MATERIAL.young * R;
    let strength = BONDS.tension * PI * R * R;
    let stretch = strength / stiffness * (count - 1) as f64;
    let (mut tension, dt, steps) = (0.0f64, 1e-4, 40_000);
    let step = |dem: &mut Dem, speed: f64| {
        dem.set_velocity(0, Vec3::zeros());
        dem.set_velocity(count - 1, Vec3::new(speed, 0.0, 0.0));
        dem.step(dt).unwrap();
    };
    let speed = 1.2 * stretch / (f64::from(steps) * dt);
    for k in 0..steps {
        step(&mut dem, speed);
        let force = pull(&mut dem).x;
        tension = tension.max(force);
        if k == steps / 2 {
            let expected = stiffness / (count - 1) as f64 * speed * dt * f64::from(k);
            assert!((force / expected - 1.0).abs() < 0.01, "{force} {expected}");
            assert_eq!((dem.intact_bonds(), dem.broken_bonds()), (count as u64 - 1, 0));
        }
    }
    println!("{tension} {strength} {}", dem.broken_bonds());
    assert!((tension / strength - 1.0).abs() < 0.01, "{tension} {strength}");
    assert_eq!((dem.intact_bonds(), dem.broken_bonds()), (count as u64 - 2, 1));
    for speed in [-3.0 * speed, 3.0 * speed] {
        let mut push = 0.0f64;
        for _ in 0..steps {
            step(&mut dem, speed);
            let force = pull(&mut dem).x;
            push = push.max(-force);
            assert!(force < 0.05 * strength, "{force}");
        }
        assert!(push > strength, "{push}");
    }
    assert_eq!(dem.broken_bonds(), 1);
}

/// Two bonded spheres pressed with F_n and sheared: they hold c A + F_n tan φ, then F_n tan φ.
#[test]
fn a_bond_shears_off() {
    let overlap = 2e-4;
    let x = vec![Vec3::new(5.0, 5.0, 5.0), Vec3::new(5.0 + 2.0 * R, 5.0, 5.0)];
    let mut p = Particles::new(x, vec![R; 2], MATERIAL.density);
    p.mass.fill(1e30);
    let options = DemOptions { rotation: false, ..DemOptions::default() };
    let walls = frictionless_walls();
    let mut dem = Dem::with_effects(law(), p, BOX, &[MATERIAL], walls, options).unwrap();
    dem.bond().unwrap();
    let (dt, steps) = (1e-4, 2000);
    let mut drive = |velocity: Vec3| {
        let (mut most, mut last) = (0.0f64, 0.0);
        let area = PI * R * R;
        for _ in 0..steps {
            dem.set_velocity(1, velocity / (f64::from(steps) * dt));
            dem.step(dt).unwrap();
            dem.compute_contacts().unwrap();
            let contact = dem.contacts().next().unwrap();
            let friction = 0.5f64.tan() * contact.normal_force;
            let strength = BONDS.cohesion * area + friction;
            last = contact.shear.norm() / friction;
            if dem.broken_bonds() == 0 {
                most = most.max(contact.shear.norm() / strength);
            }
        }
        (most, last, dem.broken_bonds())
    };
    drive(Vec3::new(-overlap, 0.0, 0.0));
    let (most, last, broken) = drive(Vec3::new(0.0, 3e-3, 0.0));
    println!("{most} {last}");
    // In 2,000 steps of 7.5 N each.
    assert!((0.998..=1.0).contains(&most), "{most}");
    assert!((last - 1.0).abs() < 1e-6, "{last}");
    assert_eq!(broken, 1);
}

/// Strengths of nothing and range: only what is near enough is bonded, and what was never bonded
/// is not broken.
#[test]
fn bonds_are_made_within_the_range() {
    let x = [0.0, 2.01 * R, 4.04 * R, 5.5 * R].map(|x| Vec3::new(4.0 + x, 5.0, 5.0)).to_vec();
    let p = Particles::new(x, vec![R, R, R, 0.4 * R], MATERIAL.density);
    let walls = frictionless_walls();
    let options = DemOptions::default();
    let mut dem = Dem::with_effects(law(), p, BOX, &[MATERIAL], walls, options).unwrap();
    assert_eq!((dem.intact_bonds(), dem.broken_bonds()), (0, 0));
    // 2.01 and 2.03 radii apart, of which 2.04 is the range; 1.46 of 1.4, of which 1.428 is.
    assert_eq!(dem.bond().unwrap(), 2);
    assert_eq!(dem.contacts().count(), 2);
}

/// A packing that is cemented and thrown against itself: energy falls, momentum stays, and a restart
/// while bonds break changes no bit, nor do threads.
#[test]
fn a_cemented_packing_keeps_momentum_and_bits() {
    let soft = dem_support::material();
    let weak = Bonds { tension: 3e3, cohesion: 3e3, interaction_range: 1.02 };
    let law = || GranularEffects { bonds: Some(weak), ..GranularEffects::default() };
    let packing = settled(2600, 3, DemOptions { damping: 0.2, ..DemOptions::default() });
    let start = || {
        let p = packing.storage();
        let mut order: Vec<usize> = (0..p.len()).collect();
        order.sort_by_key(|&i| p.id[i]);
        let of = |i: &usize| (p.position[*i], p.radius[*i]);
        let (x, r): (Vec<_>, Vec<_>) = order.iter().map(of).unzip();
        let mut p = Particles::new(x, r, soft.density);
        for (x, v) in p.position.iter().zip(&mut p.velocity) {
            *v = 3.0 * Vec3::new(x.y - 0.5, 0.3 * (9.0 * x.z).sin(), 0.5 - x.x);
        }
        let walls = frictionless_walls();
        let far = dempfv::Aabb { min: Vec3::repeat(-9.0), max: Vec3::repeat(10.0) };
        let mut dem =
            Dem::with_effects(law(), p, far, &[soft], walls, DemOptions::default()).unwrap();
        assert!(dem.bond().unwrap() > 5000);
        dem
    };
    let run = |threads: usize, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut dem = start();
            let (momentum, energy) = (dem.momentum(), dem.kinetic_energy());
            let size: f64 = dem.storage().mass.iter().sum::<f64>();
            for step in 0..300 {
                dem.step(2e-4).unwrap();
                if stop && step == 100 {
                    assert!(dem.broken_bonds() > 100, "{}", dem.broken_bonds());
                    let state = postcard::to_stdvec(&dem.state()).unwrap();
                    let state = postcard::from_bytes(&state).unwrap();
                    let (walls, options) = (frictionless_walls(), DemOptions::default());
                    dem = Dem::with_effects_from_state(law(), state, &[soft], walls, options)
                        .unwrap();
                }
            }
            let broken = dem.broken_bonds();
            println!("{} intact, {broken} broken", dem.intact_bonds());
            assert!(broken > 1000 && dem.intact_bonds() > 100);
            assert!((dem.momentum() - momentum).norm() < 1e-12 * size);
            assert!(dem.kinetic_energy() + dem.elastic_energy() < 1.05 * energy + 1e2);
            (bits(&dem), broken)
        })
    };
    let one = run(1, false);
    assert!(one == run(2, false), "two threads");
    assert!(one == run(1, true), "a restart");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |effects: GranularEffects| Granular::new(effects).unwrap_err();
    for bonds in [
        Bonds { tension: -1.0, ..BONDS },
        Bonds { cohesion: f64::NAN, ..BONDS },
        Bonds { interaction_range: 0.9, ..BONDS },
        Bonds { interaction_range: f64::INFINITY, ..BONDS },
    ] {
        let error = refused(GranularEffects { bonds: Some(bonds), ..Default::default() });
        assert!(matches!(error, DemError::Parameter { .. }), "{bonds:?}: {error}");
    }
    let hertz = Some(Hertz { poisson_ratio: 0.2, wall_poisson_ratio: 0.2 });
    let bonds = Some(BONDS);
    let error = refused(GranularEffects { hertz, bonds, ..Default::default() });
    assert!(error.to_string().contains("linear spring"), "{error}");
    let adhesion = Some(Adhesion::Constant(1.0));
    let error = refused(GranularEffects { adhesion, bonds, ..Default::default() });
    assert!(error.to_string().contains("beside bonds"), "{error}");
}
