//! An effect of one's own: grains that a small magnet pulls through water, in this one file.
//!
//! A paramagnetic sphere of volume V in the field of a pole is drawn to it by F = C V / r⁵, with the
//! energy U = −C V / (4 r⁴). Contacts, fluid and energy ledger go on as they are.
//!
//! Run it with `cargo run --release --example point_magnet`; its tests run with the library's.

use std::f64::consts::PI;

use dempfv::Vec3;
use dempfv::dem::{BodyForce, BodyLoad, SphereState};
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;

/// A magnetic pole.
#[derive(Clone, Copy, Debug)]
struct PointMagnet {
    /// Where it is (m).
    position: Vec3,
    /// C (N m²).
    strength: f64,
}

impl PointMagnet {
    /// C V (N m⁵) of a sphere.
    fn strength_on(&self, radius: f64) -> f64 {
        self.strength * 4.0 / 3.0 * PI * radius.powi(3)
    }
}

impl BodyForce for PointMagnet {
    fn name(&self) -> &str {
        "point magnet"
    }

    fn load(&self, sphere: &SphereState, _time: f64) -> BodyLoad {
        let way = self.position - sphere.position;
        let force = self.strength_on(sphere.radius) / way.norm().powi(6) * way;
        BodyLoad { force, torque: Vec3::zeros() }
    }
}

/// Grains in a box of 20 mm, in water that leaves through the top.
const SCENE: &str = r#"
[box]
min = [0, 0, 0]
max = [0.02, 0.02, 0.02]

[particles]
cloud = { count = 400, porosity = 0.7 }
density = 2600.0
young = 1.0e6
friction_angle = 30.0

[dem]
damping = 0.0

[fluid]
viscosity = 1.0e-3
pressure = { y_max = 0.0 }
remesh_interval = 100


[[stage]]
kind = "run"
dt = "auto"
steps = 2000
"#;

/// Below the middle of the bottom, 5 mm outside.
const MAGNET: PointMagnet =
    PointMagnet { position: Vec3::new(0.01, -0.005, 0.01), strength: 4.0e-6 };

fn scene(text: &str) -> dempfv::Result<Simulation> {
    let mut simulation = Simulation::new(Plan::from_toml(text, None)?)?;
    simulation.controls().add_body_force(Box::new(MAGNET));
    Ok(simulation)
}

/// Mean distance of the grains from the magnet (m).
fn mean_distance(simulation: &Simulation) -> f64 {
    let centres = &simulation.coupled().dem().storage().position;
    let distance = |x: &Vec3| (x - MAGNET.position).norm();
    centres.iter().map(distance).sum::<f64>() / centres.len() as f64
}

fn main() -> dempfv::Result<()> {
    let mut simulation = scene(SCENE)?;
    println!("time (ms)  mean distance from the magnet (mm)  work of the magnet (µJ)");
    loop {
        if simulation.step() % 250 == 0 {
            let work = simulation.coupled().dem().energy_balance().map_or(0.0, |e| e.external_work);
            let (time, distance) = (1e3 * simulation.time(), 1e3 * mean_distance(&simulation));
            println!("{time:9.2}  {distance:34.3}  {:23.3}", 1e6 * work);
        }
        if !simulation.advance()? {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use dempfv::Aabb;
    use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};

    use super::*;

    const MATERIAL: Material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };

    /// Spheres of 1 mm in a box of 1 m around the magnet, at these places relative to it (m).
    fn around_the_magnet(places: Vec<Vec3>, strength: f64) -> (Dem, PointMagnet) {
        let magnet = PointMagnet { position: Vec3::repeat(0.5), strength };
        let centres: Vec<Vec3> = places.into_iter().map(|x| x + magnet.position).collect();
        let radii = vec![1e-3; centres.len()];
        let spheres = Particles::new(centres, radii, MATERIAL.density);
        let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
        let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
        let mut dem = Dem::new(spheres, unit, MATERIAL, walls, DemOptions::default()).unwrap();
        dem.add_body_force(Box::new(magnet));
        (dem, magnet)
    }

    /// A sphere that falls from rest gains what U falls by: to the error of the leapfrog, whose
    /// velocity is half a step behind: a Δt / 2 v, 1e-4 here. The ledger has it to the last digits.
    #[test]
    fn a_falling_sphere_gains_the_energy_of_the_field() {
        let start = 0.1;
        let (mut dem, magnet) = around_the_magnet(vec![Vec3::new(start, 0.0, 0.0)], 1e-3);
        dem.track_energy(true);
        let (mut distance, dt) = (start, 1e-4);
        while distance > 0.05 {
            dem.step(dt).unwrap();
            distance = dem.position(0).x - 0.5;
        }
        let gained = 0.5 * dem.storage().mass[0] * dem.velocity(0).norm_squared();
        let field = |r: f64| -magnet.strength_on(1e-3) / (4.0 * r.powi(4));
        let expected = field(start) - field(distance);
        assert!((gained / expected - 1.0).abs() < 2e-3, "{gained} {expected}");
        let balance = dem.energy_balance().unwrap();
        assert!((balance.external_work / gained - 1.0).abs() < 1e-12, "{balance:?}");
        assert!(balance.residual.abs() < 1e-12 * gained, "{balance:?}");
    }

    /// It stays through sorting, ends when it is taken away, and its numbers are the user's.
    #[test]
    fn it_acts_until_it_is_taken_away() {
        let places: Vec<Vec3> = (1..600)
            .map(|k| 0.3 * Vec3::new((0.1 * f64::from(k)).sin(), 0.0, f64::from(k) / 600.0))
            .collect();
        let (mut dem, magnet) = around_the_magnet(places, 1e-3);
        dem.sort_spatially().unwrap();
        let dt = 1e-6;
        dem.step(dt).unwrap();
        for number in [0, 300, 598] {
            let way = magnet.position - dem.position(number);
            let mass = dem.storage().mass[0];
            let expected = magnet.strength_on(1e-3) / way.norm().powi(6) * way * dt / mass;
            let off = (dem.velocity(number) - expected).norm() / expected.norm();
            assert!(off < 1e-6, "{number}: {off}");
        }
        assert_eq!(dem.take_body_forces().len(), 1);
        let before = dem.velocity(300);
        dem.step(dt).unwrap();
        assert_eq!(dem.velocity(300), before);
    }

    /// One in the magnet's centre would be pulled without limit: the message names it, and nothing has
    /// moved.
    #[test]
    fn a_force_that_is_not_finite_is_named() {
        let (mut dem, _) =
            around_the_magnet(vec![-0.1 * Vec3::x(), Vec3::zeros(), 0.1 * Vec3::x()], 1e-3);
        let before = dem.state();
        let error = dem.step(1e-6).unwrap_err();
        let expected = "particle 1: the force or torque of `point magnet` is not finite";
        assert_eq!(error.to_string(), expected);
        assert_eq!(dem.state().particles, before.particles);
        // Nothing of the step that failed is left for the next.
        dem.take_body_forces();
        dem.step(1e-6).unwrap();
        assert_eq!([0, 2].map(|k| dem.velocity(k)), [Vec3::zeros(); 2]);
    }

    /// In a scene with fluid the grains come nearer, energy stays in balance, and no number of threads
    /// changes a bit.
    #[test]
    fn grains_in_water_gather_at_the_magnet() {
        let text = SCENE.replace("steps = 2000", "steps = 300");
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut simulation = scene(&text).unwrap();
                let before = mean_distance(&simulation);
                while simulation.advance().unwrap() {}
                let energy = simulation.coupled().dem().energy_balance().unwrap();
                (simulation.state_hash(), before - mean_distance(&simulation), energy)
            })
        };
        let (hash, nearer, energy) = run(1);
        assert!(nearer > 0.0, "{nearer}");
        assert!(energy.external_work > 0.0 && energy.fluid_work < 0.0, "{energy:?}");
        assert!(energy.residual.abs() < 1e-4 * energy.moved(), "{energy:?}");
        assert_eq!(run(2).0, hash);
    }
}
