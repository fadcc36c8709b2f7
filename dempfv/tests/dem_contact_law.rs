//! Contacts against closed forms.

mod dem_support;

use std::f64::consts::PI;

use dem_support::{frictionless_walls, material};
use dempfv::dem::{Dem, DemOptions, Material, Particles, Partner, WallMaterial};
use dempfv::{Aabb, Vec3, WallId};
use nalgebra::Rotation3;

const BOX: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(10.0, 10.0, 10.0) };

/// Follows the largest overlap of a collision from before the touch to after
/// it: its peak, and the time between the two ends, each found by linear
/// interpolation of the signed overlap between two steps.
fn collide(dem: &mut Dem, dt: f64, overlap: impl Fn(&Dem) -> f64) -> (f64, f64) {
    let (mut peak, mut start, mut time) = (0.0f64, None, 0.0);
    let mut before = overlap(dem);
    assert!(before < 0.0);
    for _ in 0..1_000_000 {
        dem.step(dt).unwrap();
        let now = overlap(dem);
        let crossing = time + dt * before / (before - now);
        time += dt;
        peak = peak.max(now);
        match start {
            None if now > 0.0 => start = Some(crossing),
            Some(start) if now < 0.0 => return (crossing - start, peak),
            _ => {}
        }
        before = now;
    }
    panic!("no collision");
}

/// Two spheres of radii r and masses m₁, m₂ that meet with v: the overlap is
/// a half period of an oscillator of stiffness k and mass m = m₁m₂/(m₁+m₂), so
/// the contact lasts π √(m/k) and is at most v √(m/k) deep; then they part
/// with the velocities of an elastic collision.
#[test]
fn head_on_collision() {
    let (r1, r2) = (0.1, 0.15);
    let spheres = || {
        let centre = [Vec3::new(4.8, 5.0, 5.0), Vec3::new(5.051, 5.0, 5.0)];
        let mut p = Particles::new(centre.to_vec(), vec![r1, r2], 2600.0);
        p.velocity[0].x = 0.5;
        p
    };
    let p = spheres();
    let (m1, m2) = (p.mass[0], p.mass[1]);
    let m = m1 * m2 / (m1 + m2);
    let k = 2.0 * 1e6 * r1 * r2 / (r1 + r2);
    let options = DemOptions::default();
    let mut dem = Dem::new(p, BOX, material(), frictionless_walls(), options).unwrap();
    let apart = |d: &Dem| r1 + r2 - (d.position(1) - d.position(0)).norm();
    // 2000 steps per collision: the leapfrog's frequency is off by (ω Δt)²/24.
    let dt = PI * (m / k).sqrt() / 2000.0;
    let (duration, peak) = collide(&mut dem, dt, apart);
    assert!((duration / (PI * (m / k).sqrt()) - 1.0).abs() < 1e-3, "{duration}");
    assert!((peak / (0.5 * (m / k).sqrt()) - 1.0).abs() < 1e-5, "{peak}");
    for _ in 0..10 {
        dem.step(dt).unwrap();
    }
    let v = [0, 1].map(|i| dem.velocity(i).x);
    assert!((v[0] - 0.5 * (m1 - m2) / (m1 + m2)).abs() < 1e-3, "{v:?}");
    assert!((v[1] - 0.5 * 2.0 * m1 / (m1 + m2)).abs() < 1e-3, "{v:?}");
}

/// A sphere that bounces off a wall: π √(m/k) and v √(m/k) with its own mass
/// and k = E r for equal moduli, 2 E E_w / (E + E_w) r in general.
#[test]
fn sphere_on_a_wall() {
    let (r, wall_young) = (0.1, 3e6);
    for wall in WallId::ALL {
        let normal = wall.inward_normal();
        let centre = BOX.center() - (5.0 - r - 1e-4) * normal;
        let mut p = Particles::new(vec![centre], vec![r], 2600.0);
        p.velocity[0] = -0.5 * normal;
        let m = p.mass[0];
        let k = 2.0 * 1e6 * wall_young / (1e6 + wall_young) * r;
        let walls = WallMaterial { young: wall_young, friction_angle: 0.0 };
        let mut dem = Dem::new(p, BOX, material(), walls, DemOptions::default()).unwrap();
        let plane = BOX.wall(wall);
        let overlap = |d: &Dem| r - (d.position(0)[wall.axis()] - plane) * wall.inward();
        let dt = PI * (m / k).sqrt() / 2000.0;
        let (duration, peak) = collide(&mut dem, dt, overlap);
        assert!((duration / (PI * (m / k).sqrt()) - 1.0).abs() < 1e-3, "{wall} {duration}");
        assert!((peak / (0.5 * (m / k).sqrt()) - 1.0).abs() < 1e-5, "{wall} {peak}");
        assert!((dem.velocity(0) - 0.5 * normal).norm() < 1e-3);
    }
}

/// A sphere that lies on a wall under gravity weighs m g, and with local
/// damping comes to rest at the overlap m g / k.
#[test]
fn a_sphere_at_rest_weighs_what_it_weighs() {
    let p = Particles::new(vec![Vec3::new(5.0, 0.1, 5.0)], vec![0.1], 2600.0);
    let weight = 9.81 * p.mass[0];
    let options = DemOptions {
        damping: 0.3,
        gravity: Some(Vec3::new(0.0, -9.81, 0.0)),
        ..DemOptions::default()
    };
    let mut dem = Dem::new(p, BOX, material(), frictionless_walls(), options).unwrap();
    for _ in 0..20_000 {
        dem.step(1e-3).unwrap();
    }
    dem.compute_contacts().unwrap();
    assert!((dem.wall_force()[WallId::YMin].y / -weight - 1.0).abs() < 1e-6);
    let contact = dem.contacts().next().unwrap();
    assert!((contact.overlap / (weight / 1e5) - 1.0).abs() < 1e-6);
    assert!(dem.unbalanced_force(None).unwrap() < 1e-6);
}

/// A sphere that starts to slide at v₀ without spin on a frictional floor
/// slows down and spins up until it rolls: m (v₀ − v) a = I ω and v = ω a with
/// the arm a = r − overlap/2 give v = v₀ / (1 + I / (m a²)), which is 5/7 v₀
/// for a = r. The shear spring swings on a little: the mean counts.
#[test]
fn sliding_turns_into_rolling() {
    let (r, v0, g, young) = (0.1, 1.0, 10.0, 1e9);
    let stiff = Material { young, ..material() };
    let mut p = Particles::new(vec![Vec3::new(1.0, r, 5.0)], vec![r], 2600.0);
    let k = young * r;
    let overlap = p.mass[0] * g / k;
    p.position[0].y -= overlap;
    p.velocity[0].x = v0;
    let walls = WallMaterial { young, friction_angle: 0.3 };
    let options = DemOptions { gravity: Some(Vec3::new(0.0, -g, 0.0)), ..DemOptions::default() };
    let dt = 0.1 * (p.mass[0] / k).sqrt();
    let mut dem = Dem::new(p, BOX, stiff, walls, options).unwrap();
    // Sliding lasts 2 v₀ / (7 μ g) = 0.092 s.
    let steps = (0.12 / dt) as usize;
    for _ in 0..steps {
        dem.step(dt).unwrap();
    }
    let (mut v, mut spin) = (0.0, 0.0);
    for _ in 0..steps {
        dem.step(dt).unwrap();
        v += dem.velocity(0).x / steps as f64;
        spin += dem.spin(0).z / steps as f64;
    }
    let expected = v0 / (1.0 + 0.4 * r * r / (r - 0.5 * overlap).powi(2));
    assert!((expected / (5.0 / 7.0 * v0) - 1.0).abs() < 1e-5);
    assert!((v / expected - 1.0).abs() < 1e-4, "{v} {expected}");
    assert!((-spin * r / v - 1.0).abs() < 1e-4, "{spin} {v}");
}

/// Two spheres that are pressed and sheared, then carried around as one rigid
/// body by 2 rad in `steps` steps, about an axis that is neither along nor
/// across their normal. They are so heavy that only the motion we give them
/// counts. Returns the error of the shear force against the turned one, as
/// a share of it.
fn carry_around(steps: u32) -> f64 {
    let r = 0.1;
    let centre = vec![Vec3::new(4.9005, 5.0, 5.0), Vec3::new(5.0995, 5.0, 5.0)];
    let mut p = Particles::new(centre, vec![r; 2], 2600.0);
    p.mass.fill(1e30);
    p.velocity[1] = Vec3::new(0.0, 0.3e-3, 0.1e-3);
    let mut dem =
        Dem::new(p, BOX, material(), frictionless_walls(), DemOptions::default()).unwrap();
    let shear = |dem: &mut Dem| {
        dem.compute_contacts().unwrap();
        let contact = dem.contacts().next().unwrap();
        match (contact.i, contact.partner) {
            (0, Partner::Sphere(1)) => contact.shear,
            (1, Partner::Sphere(0)) => -contact.shear,
            other => panic!("{other:?}"),
        }
    };
    for _ in 0..100 {
        dem.step(1e-3).unwrap();
    }
    let before = shear(&mut dem);
    // k_s × slip: 0.5 · 1e6 · 0.1 · 0.1 s · (0.3, 0.1) mm/s
    assert!((before + Vec3::new(0.0, 1.5, 0.5)).norm() < 1e-3, "{before}");

    let (angle, dt) = (2.0 / f64::from(steps), 1e-3);
    let axis = nalgebra::Unit::new_normalize(Vec3::new(1.0, 2.0, -0.5));
    let turn = Rotation3::from_axis_angle(&axis, angle);
    let origin = BOX.center();
    for _ in 0..steps {
        dem.compute_contacts().unwrap();
        for i in 0..2 {
            let x = dem.position(i);
            dem.set_velocity(i, (turn * (x - origin) + origin - x) / dt);
            dem.set_spin(i, axis.into_inner() * (angle / dt));
        }
        dem.integrate(dt, None, None).unwrap();
    }
    let expected = Rotation3::from_axis_angle(&axis, 2.0) * before;
    (shear(&mut dem) - expected).norm() / before.norm()
}

/// The shear force keeps its size and turns with the contact, to second order
/// in the angle of a step: at 2.5e-4 rad a step, to 1e-4.
#[test]
fn a_contact_carried_around_keeps_its_shear() {
    let [coarse, fine] = [4000, 8000].map(carry_around);
    assert!(fine < 1e-4, "{fine}");
    assert!((3.8..4.2).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// Coulomb: a sphere dragged along a wall at constant speed is held back by
/// k_s × path first and by μ F_n in the end; without friction by nothing.
#[test]
fn friction_is_cut_at_coulombs_limit() {
    let (r, overlap, dt) = (0.1, 1e-4, 1e-3);
    for angle in [0.4f64, 0.0] {
        let mut p = Particles::new(vec![Vec3::new(5.0, r - overlap, 5.0)], vec![r], 2600.0);
        p.mass[0] = 1e30;
        p.velocity[0].x = 1e-3;
        let walls = WallMaterial { young: 1e6, friction_angle: angle };
        let options = DemOptions { rotation: false, ..DemOptions::default() };
        let mut dem = Dem::new(p, BOX, material(), walls, options).unwrap();
        let push = 1e6 * r * overlap;
        for step in 0..200 {
            dem.compute_contacts().unwrap();
            let path = 1e-3 * dt * f64::from(step);
            let expected = (0.5 * 1e6 * r * path).min(angle.tan() * push);
            let force = dem.force(0);
            assert!((force.x + expected).abs() < 1e-9 * push, "{step} {force} {expected}");
            assert!((force.y / push - 1.0).abs() < 1e-9);
            dem.integrate(dt, None, None).unwrap();
        }
    }
}

/// The contact time step of the reference formula for one sphere on a wall:
/// with friction off, k is k_n along y; s √2 √(m/k).
#[test]
fn contact_time_step_of_one_contact() {
    let p = Particles::new(vec![Vec3::new(5.0, 0.0999, 5.0)], vec![0.1], 2600.0);
    let m = p.mass[0];
    let mut dem =
        Dem::new(p, BOX, material(), frictionless_walls(), DemOptions::default()).unwrap();
    assert_eq!(dem.contact_time_step(0.8), None);
    dem.compute_contacts().unwrap();
    let dt = dem.contact_time_step(0.8).unwrap();
    assert!((dt / (0.8 * (2.0 * m / 1e5).sqrt()) - 1.0).abs() < 1e-12);
}

/// Local damping by hand, on a free sphere under gravity g: each component of
/// the acceleration times 1 − λ sign(a (v + a Δt/2)). It takes from what goes
/// along and adds to what goes against; a velocity that the half step turns
/// around (v = −0.4 a Δt) goes along already.
#[test]
fn local_damping_by_hand() {
    let (damping, dt, g) = (0.3, 1e-2, Vec3::new(1.0, -2.0, 4.0));
    let start = Vec3::new(0.1, 0.1, -0.4 * 4.0 * dt);
    let mut p = Particles::new(vec![BOX.center()], vec![0.1], 2600.0);
    p.velocity[0] = start;
    let options = DemOptions { damping, gravity: Some(g), ..DemOptions::default() };
    let mut dem = Dem::new(p, BOX, material(), frictionless_walls(), options).unwrap();
    dem.step(dt).unwrap();
    let expected = start + dt * Vec3::new(0.7 * 1.0, 1.3 * -2.0, 0.7 * 4.0);
    assert!((dem.velocity(0) - expected).norm() < 1e-15);
    let moved = dem.position(0) - BOX.center();
    assert!((moved - dt * expected).norm() < 1e-15);
}
