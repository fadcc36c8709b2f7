//! Adhesion: constant, DMT, and JKR, against closed forms.

mod dem_support;
mod law_support;

use std::f64::consts::PI;

use dem_support::frictionless_walls;
use dempfv::dem::law::{Adhesion, Granular, GranularEffects, Hertz, Restitution};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles, WallMaterial};
use dempfv::{Vec3, WallId};
use law_support::{BOX, energy, same_bits};

const MATERIAL: Material =
    Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.0, density: 2600.0 };
const HERTZ: Hertz = Hertz { poisson_ratio: 0.3, wall_poisson_ratio: 0.3 };
/// E* of two such solids (Pa).
const MODULUS: f64 = 1e6 / (2.0 * 0.91);
/// Work of adhesion (J/m²).
const WORK: f64 = 5.0;
const RADII: [f64; 2] = [0.1, 0.3];
const REDUCED: f64 = 0.075;

fn law(adhesion: Adhesion, hertz: bool) -> GranularEffects {
    GranularEffects {
        hertz: hertz.then_some(HERTZ),
        adhesion: Some(adhesion),
        ..GranularEffects::default()
    }
}

/// Two spheres so heavy that only the motion given counts, with a gap between them.
fn pair(law: GranularEffects, gap: f64) -> Dem {
    let x = vec![Vec3::new(5.0, 5.0, 5.0), Vec3::new(5.4 + gap, 5.0, 5.0)];
    let mut p = Particles::new(x, RADII.to_vec(), MATERIAL.density);
    p.mass.fill(1e30);
    let walls = frictionless_walls();
    Dem::with_effects(law, p, BOX, &[MATERIAL], walls, DemOptions::default()).unwrap()
}

/// Moves the second sphere by `way` in `steps` steps, and calls `see` with overlap and force on it
/// along the normal, positive where it is pushed away.
fn move_by(dem: &mut Dem, way: f64, steps: usize, mut see: impl FnMut(f64, f64)) {
    let dt = 1e-3;
    for _ in 0..steps {
        dem.set_velocity(1, Vec3::new(way / steps as f64 / dt, 0.0, 0.0));
        dem.compute_contacts().unwrap();
        dem.integrate(dt, None, None).unwrap();
        dem.compute_contacts().unwrap();
        let overlap = 0.4 - (dem.position(1).x - dem.position(0).x);
        see(overlap, dem.force(1).x);
    }
}

/// The pull-off force of a constant force is that force, of DMT 2π w R*, of JKR 3/2 π w R*.
#[test]
fn pull_off_forces_are_those_of_the_theories() {
    for (adhesion, hertz, expected) in [
        (Adhesion::Constant(3.0), false, 3.0),
        (Adhesion::Constant(3.0), true, 3.0),
        (Adhesion::Dmt(WORK), true, 2.0 * PI * WORK * REDUCED),
        (Adhesion::Jkr(WORK), true, 1.5 * PI * WORK * REDUCED),
    ] {
        let mut dem = pair(law(adhesion, hertz), -1e-3);
        let mut tension = 0.0f64;
        // To a gap of 4 mm, in steps of 0.25 µm. At the last touch a spring still pushes, but for
        // JKR, whose largest tension is not at its end.
        let jkr = matches!(adhesion, Adhesion::Jkr(_));
        move_by(&mut dem, 5e-3, 20_000, |overlap, force| {
            let push = match (hertz, jkr) {
                (_, true) => 0.0,
                (true, false) => 4.0 / 3.0 * MODULUS * REDUCED.sqrt() * overlap.max(0.0).powf(1.5),
                (false, false) => 2.0 * MATERIAL.young * REDUCED * overlap.max(0.0),
            };
            if force != 0.0 {
                tension = tension.max(push - force);
            }
        });
        println!("{adhesion:?} {tension} {expected}");
        assert!((tension / expected - 1.0).abs() < 1e-6, "{adhesion:?} {tension} {expected}");
        assert_eq!(dem.force(1), Vec3::zeros(), "{adhesion:?}");
    }
}

/// JKR begins where the surfaces touch, with −8/9 of the pull-off force, and holds on to
/// δ = −a₀²/R* · (1/6)^(1/3)/2, a₀³ = 9π w R*²/2E*, where the last force is −5/9 of it; beyond
/// there is nothing, until they touch again.
#[test]
fn jkr_has_a_hysteresis() {
    let mut dem = pair(law(Adhesion::Jkr(WORK), true), 4e-3);
    let pull_off = 1.5 * PI * WORK * REDUCED;
    let unit = (4.5 * PI * WORK * REDUCED * REDUCED / MODULUS).cbrt();
    let least = -0.5 * (1.0f64 / 6.0).cbrt() * unit * unit / REDUCED;
    for _ in 0..2 {
        let mut first = None;
        move_by(&mut dem, -4.5e-3, 45_000, |overlap, force| {
            if force != 0.0 {
                first.get_or_insert((overlap, force));
            }
        });
        let (overlap, force) = first.unwrap();
        assert!((0.0..1.1e-7).contains(&overlap), "{overlap}");
        assert!((force / (-8.0 / 9.0 * pull_off) - 1.0).abs() < 1e-3, "{force}");
        assert_eq!(dem.contacts().count(), 1);
        let mut last = (0.0, 0.0);
        move_by(&mut dem, 4.5e-3, 45_000, |overlap, force| {
            if force != 0.0 {
                last = (overlap, force);
            }
        });
        println!("{last:?} {least}");
        assert!((last.0 / least - 1.0).abs() < 1e-3, "{last:?} {least}");
        assert!((last.1 / (-5.0 / 9.0 * pull_off) - 1.0).abs() < 0.03, "{last:?}");
        // Within the cut-off, perhaps, but no contact.
        assert_eq!((dem.contacts().count(), dem.sphere_contact_count()), (0, 0));
    }
}

/// What is pulled with a force below the pull-off force stays, with one above it comes off: on all
/// walls, where R* = R, as on spheres.
#[test]
fn a_sphere_hangs_on_a_wall() {
    for (adhesion, factor) in [(Adhesion::Dmt(WORK), 2.0), (Adhesion::Jkr(WORK), 1.5)] {
        let pull_off = factor * PI * WORK * 0.1;
        for wall in WallId::ALL {
            for (share, holds) in [(0.98, true), (1.02, false)] {
                let normal = wall.inward_normal();
                let x = BOX.center() - (5.0 - 0.1 + 5e-4) * normal;
                let p = Particles::new(vec![x], vec![0.1], MATERIAL.density);
                let options = DemOptions { damping: 0.6, ..DemOptions::default() };
                let walls = WallMaterial { young: MATERIAL.young, friction_angle: 0.0 };
                let law = law(adhesion, true);
                let mut dem = Dem::with_effects(law, p, BOX, &[MATERIAL], walls, options).unwrap();
                let steps = 30_000;
                for step in 0..2 * steps {
                    // The load grows slowly: a sudden one would tear it off by its swing.
                    let load = share * pull_off * (f64::from(step) / f64::from(steps)).min(1.0);
                    dem.compute_contacts().unwrap();
                    dem.add_force(0, load * normal);
                    dem.integrate(2e-4, None, None).unwrap();
                    if dem.wall_contact_count() == 0 {
                        break;
                    }
                }
                dem.compute_contacts().unwrap();
                assert_eq!(dem.wall_contact_count() == 1, holds, "{adhesion:?} {wall} {share}");
            }
        }
    }
}

/// Work and energy: ∫ F dδ along the way is the change of the energy that the law tells.
#[test]
fn energy_is_the_work_of_the_force() {
    for (adhesion, hertz) in [
        (Adhesion::Constant(3.0), false),
        (Adhesion::Constant(3.0), true),
        (Adhesion::Dmt(WORK), true),
        (Adhesion::Jkr(WORK), true),
    ] {
        let mut dem = pair(law(adhesion, hertz), -1e-3);
        dem.compute_contacts().unwrap();
        let (start, mut work) = (dem.elastic_energy(), 0.0);
        let mut before = (1e-3, dem.force(1).x);
        // To an overlap of 1e-5 m; JKR on to a gap.
        let jkr = matches!(adhesion, Adhesion::Jkr(_));
        let way = if jkr { 1.25e-3 } else { 0.99e-3 };
        move_by(&mut dem, way, 10_000, |overlap, force| {
            work += 0.5 * (force + before.1) * (before.0 - overlap);
            before = (overlap, force);
        });
        let change = dem.elastic_energy() - start;
        println!("{adhesion:?} {work} {change}");
        assert!((change / -work - 1.0).abs() < 1e-6, "{adhesion:?} {work} {change}");
    }
}

/// A collision with DMT adhesion, fast enough to part again: energy to second order.
#[test]
fn a_sticky_collision_conserves_energy() {
    let error = |dt: f64| {
        let x = vec![Vec3::new(5.0, 5.0, 5.0), Vec3::new(5.401, 5.0, 5.0)];
        let mut p = Particles::new(x, RADII.to_vec(), MATERIAL.density);
        p.velocity[0].x = 0.2;
        let walls = frictionless_walls();
        let law = law(Adhesion::Dmt(WORK), true);
        let options = DemOptions::default();
        let mut dem = Dem::with_effects(law, p, BOX, &[MATERIAL], walls, options).unwrap();
        let start = dem.kinetic_energy();
        let mut worst = 0.0f64;
        for _ in 0..(0.15 / dt) as usize {
            dem.step(dt).unwrap();
            dem.compute_contacts().unwrap();
            // In the middle of the contact: its two ends have a jump of the force.
            if dem.contacts().any(|c| c.overlap > 3e-4) {
                worst = worst.max((energy(&dem, dt) / start - 1.0).abs());
            }
        }
        assert!(worst > 0.0 && dem.sphere_contact_count() == 0);
        worst
    };
    let [coarse, fine] = [2e-5, 1e-5].map(error);
    println!("{coarse:e} {fine:e}");
    assert!(coarse < 1e-3 && fine < coarse, "{coarse:e} {fine:e}");
}

#[test]
fn sticky_gases_conserve_momentum_and_bits() {
    for (adhesion, hertz) in
        [(Adhesion::Constant(0.05), false), (Adhesion::Dmt(0.2), true), (Adhesion::Jkr(0.2), true)]
    {
        same_bits(|| {
            let restitution = Some(Restitution { spheres: 0.8, walls: 0.8 });
            GranularEffects { restitution, ..law(adhesion, hertz) }
        });
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    for adhesion in [Adhesion::Constant(0.0), Adhesion::Dmt(-1.0), Adhesion::Jkr(f64::NAN)] {
        let effects =
            GranularEffects { hertz: Some(HERTZ), adhesion: Some(adhesion), ..Default::default() };
        assert!(matches!(Granular::new(effects), Err(DemError::Parameter { .. })), "{adhesion:?}");
    }
    for adhesion in [Adhesion::Dmt(WORK), Adhesion::Jkr(WORK)] {
        let effects = GranularEffects { adhesion: Some(adhesion), ..Default::default() };
        let error = Granular::new(effects).unwrap_err();
        assert!(matches!(error, DemError::Effects { .. }), "{error}");
        assert!(error.to_string().contains("Hertz"), "{error}");
    }
}
