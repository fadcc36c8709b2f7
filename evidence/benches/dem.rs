//! One dry step of a settled packing, at three sizes and on one thread and
//! two, beside what the machine needs at least.

mod floor;

use std::path::PathBuf;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::io::packing::Packing;
use floor::{Floor, Work};

/// Of a contact: two spheres, and the shear force, which is read and written. Of a sphere:
/// place, velocity, spin, force and torque, each read and written, radius and mass.
const CONTACT: f64 = 2.0 * 4.0 + 2.0 * 24.0;
const SPHERE: f64 = 10.0 * 24.0 + 2.0 * 8.0;
/// Operations of the contact law, and of a sphere's motion.
const LAW: f64 = 150.0;
const MOTION: f64 = 60.0;

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
    let floor = Floor::measure();
    let mut group = criterion.benchmark_group("dry step");
    group.sample_size(20).measurement_time(Duration::from_secs(3));
    group.warm_up_time(Duration::from_secs(1));
    for count in [1_000, 5_000, 20_000] {
        let mut dem = specimen(count);
        dem.compute_contacts().expect("contacts");
        let dt = dem.contact_time_step(0.5).expect("it has contacts");
        let contacts = dem.contacts().count();
        let each = |contact: f64, sphere: f64| contact + sphere * count as f64 / contacts as f64;
        let (bytes, flops) = (each(CONTACT, SPHERE), each(LAW, MOTION));
        let work = Work { count: contacts, unit: "contacts", bytes, flops };
        group.throughput(Throughput::Elements(count as u64));
        for threads in [1, 2] {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let id = BenchmarkId::new(format!("{threads} threads"), count);
            floor.bench(&mut group, id, &work, &pool, || dem.step(dt).expect("the step"));
        }
    }
    group.finish();
}

criterion_group!(benches, dry_step);
criterion_main!(benches);
