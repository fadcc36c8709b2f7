//! Walls that move, and the servo.

mod dem_support;

use dem_support::{UNIT, cloud, frictionless_walls, material, settled};
use dempfv::dem::{Dem, DemError, DemOptions, Particles, WallControl};
use dempfv::{PerWall, Vec3, WallId};

const DAMPED: DemOptions = DemOptions { damping: 0.2, gravity: None, rotation: true, skin: 0.2 };

fn run(dem: &mut Dem, dt: f64, steps: usize) {
    for _ in 0..steps {
        dem.step(dt).unwrap();
    }
    dem.compute_contacts().unwrap();
}

/// The servo's promise: its stress, on the wall and across the box.
#[test]
fn the_servo_reaches_its_stress() {
    let mut dem = settled(500, 1, DAMPED);
    let servo = WallControl::Servo { stress: 1.1e4, max_velocity: Some(0.5) };
    dem.set_control(WallId::YMax, servo).unwrap();
    let dt = dem.contact_time_step(0.5).unwrap();
    run(&mut dem, dt, 10_000);
    let top = dem.wall_stress(WallId::YMax);
    let base = dem.wall_stress(WallId::YMin);
    assert!((top / 1.1e4 - 1.0).abs() < 1e-3, "{top}");
    assert!((base / top - 1.0).abs() < 2e-3, "{base} {top}");
    // More stress on the same packing: the wall has come in.
    let displacement = dem.walls()[WallId::YMax].displacement;
    assert!(displacement < 0.0 && displacement > -0.05, "{displacement}");
    assert!((dem.box_().max.y - 1.0 - displacement).abs() < 1e-13);
    // No control acted on the other walls.
    assert_eq!(dem.walls()[WallId::XMax].displacement, 0.0);
}

/// Half of a wanted stress may come from the fluid: the contacts then carry
/// the other half.
#[test]
fn the_fluid_counts_in_the_servo() {
    let mut dem = settled(500, 1, DAMPED);
    let servo = WallControl::Servo { stress: 1e4, max_velocity: Some(0.5) };
    dem.set_control(WallId::YMax, servo).unwrap();
    let dt = dem.contact_time_step(0.5).unwrap();
    let mut fluid = PerWall::<Vec3>::default();
    for _ in 0..10_000 {
        fluid[WallId::YMax].y = 5e3 * dem.box_().wall_area(WallId::YMax);
        dem.compute_contacts().unwrap();
        dem.integrate(dt, None, Some(&fluid)).unwrap();
    }
    dem.compute_contacts().unwrap();
    let stress = dem.wall_stress(WallId::YMax);
    assert!((stress / 5e3 - 1.0).abs() < 2e-3, "{stress}");
}

/// A wall that pushes nothing but fluid of resistance R ends up at the speed
/// σ A / R, from either side, in as many steps as its law needs: one that knows
/// R goes there at once.
#[test]
fn a_servo_on_fluid_finds_its_speed() {
    let lone = Particles::new(vec![Vec3::repeat(0.3)], vec![0.1], 2600.0);
    let mut dem = Dem::new(lone, UNIT, material(), frictionless_walls(), DAMPED).unwrap();
    let (resistance, dt) = (1e6, 1e-4);
    let mut all = PerWall::<PerWall<f64>>::default();
    all[WallId::YMax][WallId::YMax] = resistance;
    dem.set_wall_resistance(all).unwrap();
    for stress in [2e4, 1e4, 3e4] {
        dem.set_control(WallId::YMax, WallControl::Servo { stress, max_velocity: Some(1.0) })
            .unwrap();
        for _ in 0..3 {
            let mut fluid = PerWall::<Vec3>::default();
            fluid[WallId::YMax].y = -resistance * dem.walls()[WallId::YMax].velocity;
            dem.compute_contacts().unwrap();
            dem.integrate(dt, None, Some(&fluid)).unwrap();
        }
        let expected = -stress * dem.box_().wall_area(WallId::YMax) / resistance;
        let speed = dem.walls()[WallId::YMax].velocity;
        assert!((speed / expected - 1.0).abs() < 1e-9, "{speed} {expected}");
    }
}

/// One sphere and a servo wall: the law by hand. Wanted outward shift
/// (F − F_goal)/k, cut at 3 v Δt L_z / (L_x + L_y + L_z); shift = 0.75 wanted +
/// 0.8 previous.
#[test]
fn the_servo_law_by_hand() {
    let (overlap, stress, fastest) = (1e-4, 5.0, 1e-3);
    let (dt, k) = (1e-4, 1e5);
    for wall in [WallId::ZMin, WallId::ZMax] {
        let mut centre = Vec3::repeat(0.5);
        centre.z = UNIT.wall(wall) + wall.inward() * (0.1 - overlap);
        let p = Particles::new(vec![centre], vec![0.1], 2600.0);
        let mut dem = Dem::new(p, UNIT, material(), frictionless_walls(), DAMPED).unwrap();
        dem.set_control(wall, WallControl::Servo { stress, max_velocity: Some(fastest) }).unwrap();
        let mut previous = 0.0;
        for step in 0..2 {
            let before = dem.walls()[wall];
            let gap = (dem.position(0).z - before.position) * wall.inward();
            let height = dem.box_().size().z;
            let limit = fastest * dt * 3.0 * height / (2.0 + height);
            // The contact pushes with 10 N, the goal is 5 N: the cut acts.
            let wanted = ((k * (0.1 - gap) - stress) / k).min(limit);
            let shift = 0.75 * wanted + 0.8 * previous;
            previous = shift;
            dem.step(dt).unwrap();
            let now = dem.walls()[wall];
            let moved = -wall.inward() * (now.displacement - before.displacement);
            assert!((moved / shift - 1.0).abs() < 1e-9, "{wall} {step}: {moved} {shift}");
            assert!((now.velocity * dt / (-wall.inward() * shift) - 1.0).abs() < 1e-9);
        }
    }
}

/// A wall at constant velocity v meets a sphere at rest: in the wall's frame
/// the sphere comes with −v, so it leaves with 2v.
#[test]
fn a_moving_wall_kicks() {
    let mut dem =
        Dem::new(cloud(1, 3), UNIT, material(), frictionless_walls(), DemOptions::default())
            .unwrap();
    dem.set_control(WallId::XMin, WallControl::Velocity(1.0)).unwrap();
    let radius = dem.radius(0);
    let gap = dem.position(0).x - radius;
    let dt = 1e-4;
    let mut steps = 0;
    while dem.velocity(0).x < 1.999 && steps < 100_000 {
        dem.step(dt).unwrap();
        steps += 1;
    }
    assert!((dem.velocity(0).x - 2.0).abs() < 1e-3, "gap {gap}, {steps} steps");
    assert!((dem.walls()[WallId::XMin].displacement - dt * steps as f64).abs() < 1e-12);
}

#[test]
fn walls_that_meet_are_an_error() {
    let p = Particles::new(Vec::new(), Vec::new(), 2600.0);
    let mut dem = Dem::new(p, UNIT, material(), frictionless_walls(), DAMPED).unwrap();
    dem.set_control(WallId::XMax, WallControl::Velocity(-1.0)).unwrap();
    let error = dem.step(1.5).unwrap_err();
    assert_eq!(error, DemError::WallsMet { lower: WallId::XMin, upper: WallId::XMax });
}

/// Fixed after servo: the wall stays where it is.
#[test]
fn a_wall_can_be_stopped() {
    let mut dem = settled(300, 1, DAMPED);
    let servo = WallControl::Servo { stress: 2e4, max_velocity: Some(0.5) };
    dem.set_control(WallId::YMax, servo).unwrap();
    run(&mut dem, 1e-4, 100);
    dem.set_control(WallId::YMax, WallControl::Fixed).unwrap();
    let before = dem.box_();
    run(&mut dem, 1e-4, 100);
    assert_eq!(before, dem.box_());
}
