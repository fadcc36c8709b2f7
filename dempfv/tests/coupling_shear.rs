//! Drag and couples between neighbours that move past each other, roll and twist.

mod common;
mod lubrication_support;

use std::f64::consts::PI;

use common::{Random, cubic};
use dempfv::coupling::{Coupled, EdgeEffects, Saturation};
use dempfv::dem::DemOptions;
use dempfv::pfv::Fluid;
use dempfv::{Aabb, Vec3};
use lubrication_support::{ALL, NONE, around, open, spheres, wet};

/// A lattice of spacing a is sheared, v = γ y along x: every sphere meets those above and below across
/// a facet a² at γ a, so that the layers drag each other by μ a² / 0.45 R · γ a, the outer ones on one side.
#[test]
fn layers_of_a_lattice_shear_the_fluid() {
    let s = cubic(5, 0.0);
    let (a, rate, viscosity) = (1.0, 2.0, 3.0);
    let dem = spheres(&s.x, &s.r, s.bounds, 1e6, DemOptions::default());
    let edges = EdgeEffects { viscous_shear: true, ..NONE };
    let mut coupled = wet(dem, open(viscosity, 100), edges);
    let position = coupled.dem().storage().position.clone();
    let mut controls = coupled.controls();
    let (velocity, _) = controls.storage_velocities_mut();
    for (v, x) in velocity.iter_mut().zip(&position) {
        v.x = rate * x.y;
    }
    coupled.step(1e-12).unwrap();
    let expected = viscosity * a * a / (0.45 * s.r[0]) * rate * a;
    for (x, f) in s.x.iter().zip(coupled.fluid_force()) {
        let sides = if x.y < a {
            1.0
        } else if x.y > 4.0 * a {
            -1.0
        } else {
            0.0
        };
        let off = f - Vec3::new(sides * expected, 0.0, 0.0);
        assert!(off.norm() < 1e-12 * expected, "{x:?}: {f:?} {expected}");
    }
}

/// One sphere in the middle of a cube: each wall is all its own. Where walls hold the fluid the four
/// along which it moves drag it by μ A / (gap + 0.45 r) v, and feel the opposite; where it slips along
/// them nothing does.
#[test]
fn walls_without_slip_drag() {
    let (r, edge, viscosity, speed) = (0.2, 1.0, 3.0, 5.0);
    let expected = 4.0 * viscosity * edge * edge / (0.3 + 0.45 * r) * speed;
    for slip_walls in [true, false] {
        let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(edge) };
        let dem = spheres(&[Vec3::repeat(0.5)], &[r], bounds, 1e6, DemOptions::default());
        let saturation = open(viscosity, 100);
        let fluid = Fluid { slip_walls, ..saturation.fluid };
        let edges = EdgeEffects { viscous_shear: true, ..NONE };
        let mut coupled = wet(dem, Saturation { fluid, ..saturation }, edges);
        coupled.controls().storage_velocities_mut().0[0].x = speed;
        coupled.step(1e-12).unwrap();
        let drag = coupled.fluid_force()[0];
        let drag_expected = if slip_walls { 0.0 } else { -expected };
        assert!((drag - Vec3::new(drag_expected, 0.0, 0.0)).norm() < 1e-12 * expected, "{drag}");
    }
}

/// Two spheres alone.
fn pair(gap: f64, radii: [f64; 2], edges: EdgeEffects) -> Coupled {
    let x = [Vec3::new(-radii[0], 0.0, 0.0), Vec3::new(gap + radii[1], 0.0, 0.0)];
    let dem = spheres(&x, &radii, around(1e4), 1e6, DemOptions::default());
    wet(dem, open(2.0, 100), edges)
}

fn set(coupled: &mut Coupled, velocity: [Vec3; 2], spin: [Vec3; 2]) {
    let at = [0, 1].map(|k| coupled.dem().storage_index(k));
    let mut controls = coupled.controls();
    let (velocities, spins) = controls.storage_velocities_mut();
    for k in 0..2 {
        velocities[at[k]] = velocity[k];
        spins[at[k]] = spin[k];
    }
}

/// The formulas by hand, μ = 2 Pa·s, at gaps of 0.3, 0 and −0.01 of the mean radius R = 0.75, with a
/// roughness of 1e-3: shear ½ π μ (d ln(d/h) − 2R), pump π μ R³ (3/20 + 63/500 h/R) ln(R/h), twist
/// π μ R² h ln(R/h).
#[test]
fn forces_and_couples_are_those_of_the_formulas() {
    let (mu, radii, zero) = (2.0, [1.0, 0.5], [Vec3::zeros(); 2]);
    let r = 0.75;
    for gap in [0.3 * r, 0.0, -0.01 * r] {
        let h = f64::max(gap, 0.0) + 2e-3 * r;
        let d = 1.5 + gap;
        let only = |edges: EdgeEffects, velocity: [Vec3; 2], spin: [Vec3; 2]| {
            let mut coupled = pair(gap, radii, edges);
            set(&mut coupled, velocity, spin);
            coupled.step(1e-12).unwrap();
            (coupled.fluid_force(), coupled.fluid_torque())
        };
        let shear = EdgeEffects { shear_lubrication: true, ..NONE };
        let past = [Vec3::zeros(), Vec3::new(7.0, 3.0, 0.0)];
        let (force, torque) = only(shear, past, zero);
        let expected = 0.5 * PI * mu * (d * (d / h).ln() - 2.0 * r) * 3.0;
        let near = |a: Vec3, b: Vec3| assert!((a - b).norm() < 1e-9 * b.norm(), "{gap} {a} {b}");
        near(force[0], Vec3::new(0.0, expected, 0.0));
        near(force[1], Vec3::new(0.0, -expected, 0.0));
        // The plane between the power cells, of spheres of 1 and 0.5.
        let arm = (d * d + 0.75) / (2.0 * d);
        near(torque[0], Vec3::new(0.0, 0.0, expected * arm));
        near(torque[1], Vec3::new(0.0, 0.0, expected * (d - arm)));
        let turned = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(5.0, 0.0, 3.0)];
        let pump = EdgeEffects { pump_torque: true, ..NONE };
        let (force, torque) = only(pump, zero, turned);
        let couple =
            PI * mu * r.powi(3) * (0.15 * (r / h).ln() + 0.126 * (h / r) * (r / h).ln()) * 2.0;
        near(torque[0], Vec3::new(0.0, 0.0, couple));
        near(torque[1], Vec3::new(0.0, 0.0, -couple));
        assert!(force[0].norm() == 0.0);
        let twist = EdgeEffects { twist_torque: true, ..NONE };
        let (_, torque) = only(twist, zero, turned);
        near(torque[0], Vec3::new(PI * mu * r * r * h * (r / h).ln() * 5.0, 0.0, 0.0));
    }
}

/// Two spheres that turn as one body feel nothing of each other; nor do those that roll without slip,
/// but for the pump.
#[test]
fn a_rigid_motion_feels_nothing() {
    // The facet between the two is as wide as the box: viscous shear multiplies round-off by 10⁹.
    let mut coupled = pair(0.2, [1.0, 0.5], EdgeEffects { viscous_shear: false, ..ALL });
    let x = [0, 1].map(|k| coupled.dem().position(k));
    let spin = Vec3::new(0.3, -2.0, 1.0);
    let drift = Vec3::new(1.0, 2.0, 3.0);
    // Far walls brake what moves: a ten-thousandth.
    set(&mut coupled, x.map(|x| drift + spin.cross(&x)), [spin; 2]);
    coupled.step(1e-12).unwrap();
    let size = 2.0 * spin.norm();
    assert!(
        coupled.fluid_force().iter().all(|f| f.norm() < 1e-2 * size),
        "{:?}",
        coupled.fluid_force()
    );
    assert!(
        coupled.fluid_torque().iter().all(|t| t.norm() < 1e-12 * size),
        "{:?}",
        coupled.fluid_torque()
    );
}

/// Spheres at random places in a box of half edge 1, moving and turning at random, without contacts.
fn crowd(edges: EdgeEffects, viscosity: f64, every: u64) -> Coupled {
    let mut random = Random(4);
    let mut x: Vec<Vec3> = vec![];
    while x.len() < 60 {
        let at = 0.85 * random.vector();
        if x.iter().all(|y| (y - at).norm() > 0.32) {
            x.push(at);
        }
    }
    let r: Vec<f64> = x.iter().map(|_| 0.1 + 0.05 * random.next()).collect();
    let dem = spheres(&x, &r, around(1.0), 1e6, DemOptions::default());
    let mut coupled = wet(dem, open(viscosity, every), edges);
    let mut controls = coupled.controls();
    let (velocity, spin) = controls.storage_velocities_mut();
    for (v, w) in velocity.iter_mut().zip(spin) {
        *v = 0.1 * random.vector();
        *w = random.vector();
    }
    coupled
}

/// Action and reaction: without walls in it (which slip) the forces add up to nothing, and so do their
/// moments about any point with the torques, to round-off; with films at walls, the walls have the
/// rest.
#[test]
fn momentum_and_angular_momentum_stay() {
    let sums = |coupled: &Coupled| {
        let pores = coupled.dem().by_number(coupled.storage_flow().unwrap().force()).unwrap();
        let f: Vec<Vec3> =
            coupled.fluid_force().iter().zip(&pores).map(|(all, pores)| all - pores).collect();
        let (x, t) = (coupled.dem().positions(), coupled.fluid_torque());
        let force: Vec3 = f.iter().sum();
        let moment: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
        let torque: Vec3 = t.iter().sum();
        let size: f64 = f.iter().map(Vec3::norm).sum();
        (force, moment + torque, torque, size)
    };
    let mut coupled = crowd(EdgeEffects { normal_lubrication: false, ..ALL }, 1.0, 50);
    // So short that the positions are those of the forces.
    coupled.step(1e-15).unwrap();
    let (force, moment, torque, size) = sums(&coupled);
    assert!(force.norm() < 1e-13 * size && moment.norm() < 1e-13 * size, "{force} {moment} {size}");
    assert!(torque.norm() > 1e-3 * size, "the premise: {torque}");

    let mut coupled = crowd(ALL, 1.0, 50);
    coupled.step(1e-4).unwrap();
    let (force, _, _, size) = sums(&coupled);
    let area = 4.0;
    // Stress is positive in compression, and the pores have their own share.
    let (stress, pores) = (coupled.observe().fluid_stress, coupled.storage_flow().unwrap());
    let on_walls = |axis: usize| {
        let of_pores = pores.wall_force()[2 * axis][axis] + pores.wall_force()[2 * axis + 1][axis];
        area * (stress[2 * axis + 1] - stress[2 * axis]) - of_pores
    };
    for axis in 0..3 {
        assert!((force[axis] + on_walls(axis)).abs() < 1e-12 * size, "{axis}: {force} {stress:?}");
    }
    assert!(force.norm() > 1e-4 * size, "the premise: {force}");
}

/// Each effect books its own loss, with networks that come and go: what the spheres have lost in energy
/// is what the films took, to round-off, and each film takes more than it gives.
#[test]
fn energy_is_booked_by_cause() {
    let cases = [
        (EdgeEffects { viscous_shear: true, ..NONE }, 0),
        (EdgeEffects { normal_lubrication: true, ..NONE }, 1),
        (EdgeEffects { shear_lubrication: true, ..NONE }, 2),
        (EdgeEffects { pump_torque: true, ..NONE }, 3),
        (EdgeEffects { twist_torque: true, ..NONE }, 4),
        (ALL, 5),
    ];
    for (edges, cause) in cases {
        let mut coupled = crowd(edges, 0.5, 30);
        // Of a step that tracking begins with, only the half after the forces is booked.
        coupled.step(1e-4).unwrap();
        coupled.controls().track_energy(true);
        let before = coupled.dem().kinetic_energy();
        for _ in 0..800 {
            coupled.step(1e-4).unwrap();
        }
        assert!(coupled.dem().sphere_contact_count() == 0, "the premise");
        let b = coupled.dem().energy_balance().unwrap();
        let causes = [
            b.viscous_shear,
            b.normal_lubrication,
            b.shear_lubrication,
            b.pump_torque,
            b.twist_torque,
        ];
        println!("{causes:?} of {before}, residual {:e}", b.residual);
        for (k, loss) in causes.into_iter().enumerate() {
            let on = cause == 5 || cause == k;
            assert!(if on { loss > 1e-6 * before } else { loss == 0.0 }, "{edges:?}: {causes:?}");
        }
        let lost = before - coupled.dem().kinetic_energy();
        let taken = b.dissipated() + b.film_elastic - b.fluid_work;
        assert!((lost / taken - 1.0).abs() < 1e-10, "{lost} {b:?}");
        assert!(b.residual.abs() < 1e-13 * before, "{b:?}");
    }
}

/// The bound of the time step: neighbours that drag each other in a fluid so viscous that nothing else
/// matters. Just below it a kick dies out, whichever effect is on; at a few times of it the motion grows.
#[test]
fn the_time_step_is_bounded() {
    let cases = [
        EdgeEffects { viscous_shear: true, ..NONE },
        EdgeEffects { normal_lubrication: true, ..NONE },
        EdgeEffects { shear_lubrication: true, ..NONE },
        EdgeEffects { pump_torque: true, ..NONE },
        EdgeEffects { twist_torque: true, ..NONE },
        ALL,
    ];
    for edges in cases {
        let run = |share: f64| {
            let mut coupled = crowd(edges, 1e4, 1000);
            // So slow that nothing moves.
            let mut controls = coupled.controls();
            let (velocity, spin) = controls.storage_velocities_mut();
            velocity.iter_mut().chain(spin).for_each(|v| *v *= 1e-9);
            coupled.update_viscous_mode(true).unwrap();
            let bounds = coupled.time_step_bounds();
            let dt = share * bounds.limit();
            let before = coupled.dem().kinetic_energy();
            for _ in 0..300 {
                // What grows without end leaves the box.
                if coupled.step(dt).is_err() {
                    return (f64::INFINITY, bounds);
                }
            }
            (coupled.dem().kinetic_energy() / before, bounds)
        };
        let (below, bounds) = run(0.95);
        let above: Vec<f64> = [1.5, 2.0, 3.0, 5.0].map(|share| run(share).0).to_vec();
        println!("{edges:?}: {bounds:?} {below:e} {above:?}");
        assert!(below < 1.0, "{edges:?}: {below}");
        assert!(above[3] > 1e6, "{edges:?}: {above:?}");
    }
}
