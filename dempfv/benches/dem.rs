//! One dry step of a settled packing, at three sizes and on one thread and
//! two. Prints the number of contacts of each packing.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dempfv::dem::{
    CloudScale, CloudSpec, Dem, DemError, DemOptions, GrowthCompaction, GrowthOptions, Material,
    Particles, SizeDistribution, WallMaterial, random_cloud,
};
use dempfv::{Aabb, Vec3};

const YOUNG: f64 = 1e6;

/// Spheres settled at 1 kPa in a cube, with friction of 30°.
fn settled(count: usize) -> Result<Dem, DemError> {
    let box_ = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    let cloud = random_cloud(&CloudSpec {
        box_,
        count,
        sizes: SizeDistribution::Uniform { spread: 0.25 },
        scale: CloudScale::Porosity(0.75),
        seed: 1,
    })?;
    let material = Material {
        young: YOUNG,
        stiffness_ratio: 0.5,
        friction_angle: 30f64.to_radians(),
        density: 2600.0,
    };
    let (position, radius) = cloud.into_iter().unzip();
    let spheres = Particles::new(position, radius, material.density);
    let walls = WallMaterial { young: YOUNG, friction_angle: 0.0 };
    let options = DemOptions { damping: 0.3, ..DemOptions::default() };
    let mut dem = Dem::new(spheres, box_, material, walls, options)?;
    GrowthCompaction::new(GrowthOptions::new(1e3, YOUNG))?.run(&mut dem)?;
    dem.sort_spatially()?;
    Ok(dem)
}

fn dry_step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dry step");
    group.sample_size(20);
    for count in [1_000, 5_000, 20_000] {
        let mut dem = settled(count).expect("the packing settles");
        let dt = dem.contact_time_step(0.5).expect("it has contacts");
        println!("{count} spheres: {} contacts", dem.contacts().count());
        group.throughput(Throughput::Elements(count as u64));
        for threads in [1, 2] {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let id = BenchmarkId::new(format!("{threads} threads"), count);
            group.bench_function(id, |bencher| {
                pool.install(|| bencher.iter(|| dem.step(dt).expect("the step")));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, dry_step);
criterion_main!(benches);
