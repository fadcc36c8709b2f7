//! What effects of contacts dissipate is booked by cause: the balance closes as the time step
//! becomes smaller.

mod dem_support;

use dem_support::{frictionless_walls, material};
use dempfv::Vec3;
use dempfv::dem::law::{Adhesion, Bonds, GranularEffects, Hertz, Resistance, Restitution};
use dempfv::dem::{Dem, DemOptions, EnergyBalance, Particles};

const SPACE: dempfv::Aabb =
    dempfv::Aabb { min: Vec3::new(-9.0, -9.0, -9.0), max: Vec3::new(9.0, 9.0, 9.0) };

/// Two spheres that strike each other aside, with spins, or bonded ones that are torn apart.
fn pair(effects: GranularEffects) -> Dem {
    let bonded = effects.bonds.is_some();
    let (x, speed) = if bonded { (0.1, -1.0) } else { (0.12, 1.0) };
    let centres = vec![Vec3::new(-x, 0.0, 0.0), Vec3::new(x, if bonded { 0.0 } else { 0.1 }, 0.0)];
    let mut p = Particles::new(centres, vec![0.1, 0.1], 2600.0);
    p.velocity = vec![speed * Vec3::x(), -speed * Vec3::x()];
    p.spin = vec![Vec3::new(3.0, 0.0, 5.0), Vec3::new(-4.0, 2.0, 0.0)];
    let (walls, options) = (frictionless_walls(), DemOptions::default());
    let mut dem = Dem::with_effects(effects, p, SPACE, &[material()], walls, options).unwrap();
    if bonded {
        dem.bond().unwrap();
    }
    dem.track_energy(true);
    dem
}

/// Energy before (J), and the balance 0.15 s later, at `refinement` steps of 10⁻⁴ s each.
fn after(effects: GranularEffects, refinement: usize) -> (f64, EnergyBalance) {
    let mut dem = pair(effects);
    let start = dem.energy_balance().unwrap();
    for _ in 0..1500 * refinement {
        dem.step(1e-4 / refinement as f64).unwrap();
    }
    assert_eq!(dem.contacts().count(), 0);
    (start.translation + start.rotation, dem.energy_balance().unwrap())
}

type Cause = fn(&EnergyBalance) -> f64;

/// What is left falls with the time step, to 6e-6 at most of what there was; with bonds it is
/// round-off.
#[test]
fn losses_are_booked_by_their_cause() {
    let none = GranularEffects::default();
    let hertz = Some(Hertz { poisson_ratio: 0.3, wall_poisson_ratio: 0.3 });
    let restitution = Some(Restitution { spheres: 0.5, walls: 0.5 });
    let resistance = Some(Resistance { friction: 0.1, stiffness_ratio: 0.5, damping_ratio: 0.3 });
    let bonds = Some(Bonds { tension: 2e4, cohesion: 2e4, interaction_range: 1.0 });
    let friction: Cause = |b| b.friction;
    let cases: [(&str, GranularEffects, Cause); 9] = [
        ("hertz", GranularEffects { hertz, ..none }, friction),
        ("restitution", GranularEffects { restitution, ..none }, |b| b.contact_damping),
        ("both", GranularEffects { hertz, restitution, ..none }, |b| b.contact_damping),
        ("rolling", GranularEffects { rolling: resistance, ..none }, |b| b.rolling),
        ("twisting", GranularEffects { twisting: resistance, ..none }, |b| b.rolling),
        ("hertz, rolling", GranularEffects { hertz, rolling: resistance, ..none }, |b| b.rolling),
        ("hertz, twisting", GranularEffects { hertz, twisting: resistance, ..none }, |b| b.rolling),
        ("jkr", GranularEffects { hertz, adhesion: Some(Adhesion::Jkr(20.0)), ..none }, |b| {
            b.breakage
        }),
        ("bonds", GranularEffects { bonds, ..none }, |b| b.breakage),
    ];
    for (name, effects, cause) in cases {
        let (start, coarse) = after(effects, 1);
        let (_, fine) = after(effects, 4);
        let share = |b: &EnergyBalance| b.residual / start;
        println!("{name}: {:e} {:e} of {:e}", share(&coarse), share(&fine), cause(&fine) / start);
        assert!(cause(&fine) > 1e-4 * start, "{name}: {fine:?}");
        let bound = if name == "bonds" { 1e-12 } else { 6e-6 };
        assert!(share(&fine).abs() < bound, "{name}: {fine:?}");
        let falls = share(&fine).abs() < 0.4 * share(&coarse).abs();
        assert!(falls || name == "bonds", "{name}: {coarse:?} {fine:?}");
    }
}
