//! Packing by growth of the radii.

use dempfv::dem::{
    CloudScale, CloudSpec, Dem, DemOptions, GrowthCompaction, GrowthOptions, Material,
    Particles, SizeDistribution, WallMaterial, random_cloud,
};
use dempfv::{Aabb, Vec3};

const UNIT: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };

/// The larger twin of the oedometer: unit box, E = 1 MPa, k_s/k_n = 0.5,
/// 30° of friction, 2600 kg/m³, frictionless walls.
fn twin(count: usize, seed: u64) -> Dem {
    let material = Material {
        young: 1e6,
        stiffness_ratio: 0.5,
        friction_angle: 30f64.to_radians(),
        density: 2600.0,
    };
    let cloud = random_cloud(&CloudSpec {
        box_: UNIT,
        count,
        sizes: SizeDistribution::Uniform { spread: 0.3333 },
        scale: CloudScale::Porosity(0.95),
        seed,
    })
    .unwrap();
    let (position, radius) = cloud.into_iter().unzip();
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let spheres = Particles::new(position, radius, material.density);
    Dem::new(spheres, UNIT, material, walls, options).unwrap()
}

#[test]
fn growth_settles_at_its_stress() {
    let mut dem = twin(1000, 1);
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
    let status = growth.run(&mut dem).unwrap();
    assert!(status.done);
    assert!((dem.mean_wall_stress() / 1e4 - 1.0).abs() < 1e-3);
}
