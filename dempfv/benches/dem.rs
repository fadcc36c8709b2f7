//! One dry step of a settled packing, at three sizes and on one thread and
//! two. Prints the number of contacts of each packing.

use std::path::PathBuf;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::io::packing::Packing;

/// The spheres of a packing file at rest, with friction of 30° and damping:
/// every effect of the contact law acts.
fn specimen(count: usize) -> Dem {
    let file = format!("../packings/oedometer-{count}.txt");
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    let packing = Packing::read(&path).expect("a shipped packing");
    let bounds = packing.bounds_or_tight().expect("spheres");
    let material = Material {
        young: 1e6,
        stiffness_ratio: 0.5,
        friction_angle: std::f64::consts::FRAC_PI_6,
        density: 2600.0,
    };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let options = DemOptions { damping: 0.2, ..DemOptions::default() };
    let spheres = Particles::new(packing.position, packing.radius, material.density);
    Dem::new(spheres, bounds, material, walls, options).expect("a valid packing")
}

fn dry_step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dry step");
    group.sample_size(20);
    for count in [1_000, 5_000, 20_000] {
        let mut dem = specimen(count);
        dem.compute_contacts().expect("contacts");
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
