//! When the pore network is built anew, and what it matters.

mod common;
mod coupling_support;

use common::{Random, cubic};
use coupling_support::{COMPACT, MEASURE, advance_to, finish, scene, start};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

fn saturation(remesh: RemeshRule) -> Saturation {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-9, slip_walls: true, clamp: Clamp::None, boundary };
    Saturation { fluid, solver: SolverKind::default(), remesh }
}

fn frictionless() -> (Material, WallMaterial) {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.0, density: 2600.0 };
    (material, WallMaterial { young: 1e6, friction_angle: 0.0 })
}

/// Spheres that do not touch and the upper wall approach the lower wall
/// evenly, in a fluid too thin to disturb them: every pore loses 1e-4 of its
/// volume a step.
fn shrinking(remesh: RemeshRule) -> Coupled {
    let mut s = cubic(5, 0.1);
    s.r.iter_mut().for_each(|r| *r *= 0.6);
    let (material, walls) = frictionless();
    let particles = Particles::new(s.x, s.r, material.density);
    let mut dem = Dem::new(particles, s.bounds, material, walls, DemOptions::default()).unwrap();
    let height = s.bounds.size().y;
    dem.set_control(WallId::YMax, WallControl::Velocity(-1e-4 * height)).unwrap();
    let positions = dem.storage().position.clone();
    for (v, x) in dem.storage_velocities_mut().0.iter_mut().zip(positions) {
        *v = Vec3::new(0.0, -1e-4 * x.y, 0.0);
    }
    // A dry step gives the wall its velocity.
    dem.step(1.0).unwrap();
    let mut coupled = Coupled::new(dem);
    coupled.saturate(saturation(remesh));
    coupled
}

/// At 1e-4 a step, a limit of 9.5e-4 is passed after ten steps, also when the
/// box has become 1 % lower and the rate 1 % higher; an interval counts steps;
/// of both, the first counts.
#[test]
fn the_rule_remeshes_when_it_should() {
    let rule = |interval, strain| RemeshRule { interval, strain };
    for (remesh, expected) in [
        (rule(None, Some(9.5e-4)), 10),
        (rule(None, Some(1.0)), 1),
        (rule(Some(10), None), 10),
        (rule(Some(1), None), 100),
        (rule(Some(1000), None), 1),
        (rule(Some(5), Some(9.5e-4)), 20),
        (rule(Some(20), Some(9.5e-4)), 10),
    ] {
        let mut coupled = shrinking(remesh);
        for _ in 0..100 {
            coupled.step(1.0).unwrap();
        }
        assert_eq!(coupled.remeshes(), expected, "{remesh:?}");
        // The premise: everything has moved as it was told to.
        let lost = 1.0 - coupled.dem().box_().size().y / 5.0;
        assert!((lost - 0.0101).abs() < 1e-10, "{lost}");
        assert_eq!(coupled.dem().sphere_contact_count(), 0);
    }
}

/// Between remeshes the conductances are those of the last one: an error of
/// first order in the strain since then. Here the box strains by 4e-5 in ten
/// steps, and conductances go with the cube of the throats' width, so pressures
/// and settlement must agree with a remesh at every step to some ten times
/// that (1e-3; found: 6e-5), and over 80 steps be off by about eight times as
/// much.
#[test]
fn a_slowly_deforming_packing_needs_few_networks() {
    let stage = r#"
        [[stage]]
        kind = "consolidate"
        wall = "y_max"
        stress = 1.1e4
        until_tv = 0.1
        max_velocity = 0.1
    "#;
    let run = |interval: u64| {
        let text = scene(
            150,
            &format!("remesh_interval = {interval}"),
            &format!("{COMPACT}{MEASURE}{stage}"),
        );
        let mut simulation = start(&text);
        advance_to(&mut simulation, "consolidate");
        let (step, height) = (simulation.step(), simulation.observe().size[1]);
        finish(&mut simulation);
        let seen = simulation.observe();
        let steps = simulation.step() - step;
        assert_eq!(simulation.remeshes(), steps.div_ceil(interval));
        (height - seen.size[1], seen.mean_pressure)
    };
    let every = run(1);
    let difference = |interval: u64| {
        let (settlement, pressure) = run(interval);
        f64::max((settlement / every.0 - 1.0).abs(), (pressure / every.1 - 1.0).abs())
    };
    let (ten, eighty) = (difference(10), difference(80));
    assert!(ten < 1e-3, "{ten:e}");
    assert!((0.05..0.25).contains(&(ten / eighty)), "{ten:e} over 10 steps, {eighty:e} over 80");
}

/// A small sphere that is squeezed into the lens where two large ones overlap
/// has an empty power cell: it is no vertex of any pore, and the fluid does
/// not push it. Contacts do.
#[test]
fn a_hidden_sphere_still_carries_contacts() {
    let mut s = cubic(3, 1e-3);
    s.r.iter_mut().for_each(|r| *r *= 1.04);
    s.x.push(s.x[13] + Vec3::new(0.505, 0.0, 0.0));
    s.r.push(0.01);
    let hidden = s.x.len() as u32 - 1;
    let mut random = Random(1);
    let (material, walls) = frictionless();
    let particles = Particles::new(s.x, s.r, material.density);
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let mut dem = Dem::new(particles, s.bounds, material, walls, options).unwrap();
    for v in dem.storage_velocities_mut().0 {
        *v = 1e-3 * random.vector();
    }
    let mut coupled = Coupled::new(dem);
    coupled.saturate(saturation(RemeshRule { interval: Some(5), strain: None }));
    let id = coupled.dem().storage().id.clone();
    let at = id.iter().position(|&i| i == hidden).unwrap();
    let before = coupled.dem().storage().position[at];
    for step in 0..20 {
        coupled.step(1e-5).unwrap();
        let flow = coupled.storage_flow().unwrap();
        assert_eq!(flow.network().tessellation.hidden, [at as u32], "step {step}");
        assert_eq!(flow.force()[at], Vec3::zeros());
        let touching = coupled.dem().contacts().filter(|c| {
            let other = match c.partner {
                dempfv::dem::Partner::Sphere(j) => j,
                dempfv::dem::Partner::Wall(_) => u32::MAX,
            };
            c.i == hidden || other == hidden
        });
        assert!(touching.count() == 2, "step {step}");
    }
    assert!(coupled.dem().storage_forces()[at].norm() > 0.0);
    assert!(coupled.dem().storage().position[at] != before);
}
