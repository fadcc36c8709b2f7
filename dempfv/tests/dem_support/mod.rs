//! What the tests of the mechanics share.
#![allow(dead_code)] // each test file uses its part

use dempfv::dem::{
    CloudScale, CloudSpec, Dem, DemOptions, GrowthCompaction, GrowthOptions, Material, Particles,
    SizeDistribution, WallMaterial, random_cloud,
};
use dempfv::{Aabb, Vec3};

pub const UNIT: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };

/// The larger twin of the oedometer: E = 1 MPa, k_s/k_n = 0.5, 30° of
/// friction, 2600 kg/m³.
pub fn material() -> Material {
    Material {
        young: 1e6,
        stiffness_ratio: 0.5,
        friction_angle: 30f64.to_radians(),
        density: 2600.0,
    }
}

pub fn frictionless_walls() -> WallMaterial {
    WallMaterial { young: 1e6, friction_angle: 0.0 }
}

/// A cloud in the unit box at porosity 0.95, radii within a third of the mean.
pub fn cloud(count: usize, seed: u64) -> Particles {
    let cloud = random_cloud(&CloudSpec {
        box_: UNIT,
        count,
        sizes: SizeDistribution::Uniform { spread: 0.3333 },
        scale: CloudScale::Porosity(0.95),
        seed,
    })
    .unwrap();
    let (position, radius) = cloud.into_iter().unzip();
    Particles::new(position, radius, material().density)
}

/// The twin's cloud in its box.
pub fn twin(count: usize, seed: u64, options: DemOptions) -> Dem {
    Dem::new(cloud(count, seed), UNIT, material(), frictionless_walls(), options).unwrap()
}

/// The twin settled at 10 kPa.
pub fn settled(count: usize, seed: u64, options: DemOptions) -> Dem {
    let mut dem = twin(count, seed, options);
    GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap().run(&mut dem).unwrap();
    dem.sort_spatially().unwrap();
    dem
}

/// The bits of everything that a checkpoint holds.
pub fn bits(dem: &Dem) -> Vec<u8> {
    postcard::to_stdvec(&dem.state()).unwrap()
}
