//! Hard case 20: long runs. Nothing drifts and nothing grows over many steps.
//!
//! The short form runs with the other tests. The long one, 10⁷ dry and 10⁶ coupled steps:
//! `DEMPFV_LONG=200 cargo test --release -p dempfv --test hard_long -- --nocapture`.

mod coupling_support;
mod dem_support;

use std::sync::{Mutex, MutexGuard, PoisonError};

use coupling_support::{plan, scene};
use dem_support::{UNIT, frictionless_walls, material};
use dempfv::Vec3;
use dempfv::dem::{
    CloudScale, CloudSpec, Dem, DemOptions, Material, Particles, SizeDistribution, random_cloud,
};
use dempfv::simulation::Simulation;

/// By how much runs are longer than in their short form.
fn times() -> u64 {
    std::env::var("DEMPFV_LONG").ok().and_then(|n| n.parse().ok()).unwrap_or(1)
}

/// Memory is the whole process's: one run at a time, or each would count what the other takes.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Kilobytes of memory in use.
fn memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

/// A gas of 40 elastic spheres, without friction and damping, in a closed box: each of its collisions
/// gains 3·10⁻⁷ of its energy on average (docs/time-step.md), and there is one in some ten steps. The
/// kinetic and elastic energy stays within 1 %, from 250,000 steps on within 4 % for each 10⁶ steps.
#[test]
fn an_elastic_gas_keeps_its_energy() {
    let _alone = alone();
    let cloud = random_cloud(&CloudSpec {
        box_: UNIT,
        count: 40,
        sizes: SizeDistribution::Uniform { spread: 0.3333 },
        scale: CloudScale::Porosity(0.85),
        seed: 5,
    })
    .unwrap();
    let (position, radius) = cloud.into_iter().unzip();
    let mut spheres = Particles::new(position, radius, 2600.0);
    for (k, v) in spheres.velocity.iter_mut().enumerate() {
        let angle = 2.4 * k as f64;
        *v = Vec3::new(angle.cos(), angle.sin(), (1.7 * angle).cos());
    }
    let smooth = Material { friction_angle: 0.0, ..material() };
    let options = DemOptions { rotation: false, ..DemOptions::default() };
    let mut dem = Dem::new(spheres, UNIT, smooth, frictionless_walls(), options).unwrap();
    // Velocities are half a step behind: half a step of force brings them to the positions.
    let energy = |dem: &mut Dem, dt: f64| {
        dem.compute_contacts().unwrap();
        let (p, forces) = (dem.storage(), dem.storage_forces());
        let kinetic = |i: usize| {
            let v = p.velocity[i] + 0.5 * dt / p.mass[i] * forces[i];
            0.5 * p.mass[i] * v.norm_squared()
        };
        (0..p.len()).map(kinetic).sum::<f64>() + dem.elastic_energy()
    };
    let start = energy(&mut dem, 0.0);
    let steps = 50_000 * times();
    let mut before = 0;
    let mut most = 0.0f64;
    for step in 0..steps {
        let dt = dem.step_auto(0.8).unwrap();
        if step == steps / 10 {
            before = memory();
        }
        if step % 100 == 0 {
            most = most.max((energy(&mut dem, dt) / start - 1.0).abs());
        }
    }
    let grown = memory().saturating_sub(before);
    println!("{steps} dry steps: energy within {most:.2e}, {grown} kB more");
    assert!(most < 0.01f64.max(0.04 * steps as f64 / 1e6), "{most}");
    assert!(grown < 4_000, "{grown} kB more");
}

/// A packing at rest under a steady flow, with a network from the background every 200 steps: flux,
/// pressure and elastic energy stay what they are when it has come to rest, to 10⁻⁵ (loose spheres
/// still creep), and memory does not grow.
#[test]
fn a_steady_flow_stays_as_it_is() {
    let _alone = alone();
    let steps = 5_000 * times();
    let stages = format!(
        "[[stage]]\nkind = \"compact\"\nstress = 1.0e4\nfriction_angle = 3.0\ndt = \"auto\"\n\
         [[stage]]\nkind = \"run\"\ndt = \"auto\"\nsteps = {}\n",
        10_000 + steps
    );
    let fluid = "remesh_interval = 200\nremesh = \"background\"";
    let text = scene(100, fluid, &stages)
        .replace("y_max = 0.0", "y_max = 0.0, y_min = 10.0")
        .replace("viscosity = 10.0", "viscosity = 0.01");
    let mut simulation = Simulation::new(plan(&text)).unwrap();
    while simulation.stage().unwrap().name != "run" {
        simulation.advance().unwrap();
    }
    for _ in 0..10_000 {
        simulation.advance().unwrap();
    }
    let (start, before) = (simulation.coupled().observe(), memory());
    let mut most = [0.0f64; 3];
    for _ in 0..steps / 100 {
        for _ in 0..100 {
            simulation.advance().unwrap();
        }
        let now = simulation.coupled().observe();
        let off = |a: f64, b: f64| (a / b - 1.0).abs();
        most[0] = most[0].max(off(now.flux[2], start.flux[2]));
        most[1] = most[1].max(off(now.mean_pressure, start.mean_pressure));
        most[2] = most[2].max(off(now.elastic_energy, start.elastic_energy));
    }
    let grown = memory().saturating_sub(before);
    let [flux, pressure, energy] = most;
    println!(
        "{steps} coupled steps: flux within {flux:.1e}, pressure {pressure:.1e}, elastic energy \
         {energy:.1e}, {grown} kB more"
    );
    assert!(start.flux[2] > 0.0, "{start:?}");
    assert!(most.iter().all(|&off| off < 1e-5), "{most:?}");
    assert!(grown < 8_000, "{grown} kB more");
}
