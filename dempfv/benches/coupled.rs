//! The coupled system by its parts, on settled packings of 1,000, 5,000 and
//! 20,000 spheres: network build, ordering and analysis, factorization, one
//! solve, the operators, one coupled step without a remesh.
//!
//! Beside the times stand the bytes that E, F and the solve must read, so that
//! they can be held against the memory bandwidth, which is measured first.

use std::hint::black_box;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, Network, Operators};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};

/// Water, drained at the top.
fn fluid() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax.index()] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

fn packing(count: usize) -> (Packing, Aabb) {
    let file = format!("../packings/oedometer-{count}.txt");
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    let packing = Packing::read(&path).expect("a shipped packing");
    let bounds = packing.bounds_or_tight().expect("spheres");
    (packing, bounds)
}

/// The paper's specimen (Caulk 2020, section 4), never remeshed.
fn specimen(packing: &Packing, bounds: Aabb) -> Coupled {
    let material = Material {
        young: 1e6,
        stiffness_ratio: 0.5,
        friction_angle: std::f64::consts::FRAC_PI_6,
        density: 2600.0,
    };
    let particles = Particles::new(packing.position.clone(), packing.radius.clone(), 2600.0);
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let dem = Dem::new(particles, bounds, material, walls, DemOptions::default()).expect("a dem");
    let mut coupled = Coupled::new(dem);
    let remesh = RemeshRule::default();
    coupled.saturate(Saturation { fluid: fluid(), solver: SolverKind::default(), remesh });
    coupled
}

/// Memory bandwidth of one thread and of all: the sum of an array far larger
/// than any cache, best of five (GB/s).
fn bandwidth() -> (f64, f64) {
    use rayon::prelude::*;
    let data = vec![1.0f64; 1 << 26];
    let bytes = (data.len() * 8) as f64;
    let best = |run: &dyn Fn() -> f64| {
        let times = (0..5).map(|_| {
            let start = Instant::now();
            black_box(run());
            start.elapsed().as_secs_f64()
        });
        bytes / times.fold(f64::INFINITY, f64::min) / 1e9
    };
    // Eight sums at a time, so that the additions do not wait for each other.
    let sum = |part: &[f64]| {
        let lanes = part.chunks_exact(8).fold([0.0; 8], |mut s, c| {
            s.iter_mut().zip(c).for_each(|(s, c)| *s += c);
            s
        });
        lanes.iter().sum::<f64>()
    };
    (best(&|| sum(&data)), best(&|| data.par_chunks(1 << 16).map(sum).sum()))
}

fn parts(c: &mut Criterion) {
    let (one, all) = bandwidth();
    println!("memory bandwidth: {one:.1} GB/s on one thread, {all:.1} GB/s on all");
    let mut group = c.benchmark_group("coupled");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    for count in [1_000, 5_000, 20_000] {
        let (packing, bounds) = packing(count);
        let (x, r) = (&packing.position, &packing.radius);
        let id = |what| BenchmarkId::new(what, count);
        group.bench_function(id("network"), |b| {
            b.iter(|| {
                let (network, derivatives) =
                    Network::new(x, r, bounds, &fluid()).expect("a network");
                Operators::new(&network, derivatives, fluid().boundary).expect("operators")
            });
        });
        let mut flow = Flow::new(x, r, bounds, &fluid(), SolverKind::default()).expect("a flow");
        let matrix = flow.operators.matrix.clone();
        let backend = SolverKind::default().backend();
        group.bench_function(id("analyze"), |b| {
            b.iter(|| backend.analyze(&matrix, None).expect("an analysis"));
        });
        let mut factor =
            Some(backend.analyze(&matrix, None).and_then(|s| s.factor(&matrix)).expect("a factor"));
        group.bench_function(id("factor"), |b| {
            b.iter(|| factor = factor.take().map(|f| f.refactor(&matrix).expect("a factor")));
        });
        let velocity: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.0, -x.y, 0.0)).collect();
        let walls = [0.0; 6];
        let pores = flow.network.pores();
        println!(
            "{count}: {pores} pores, nnz(L) {}; bytes read: E {:.1} MB, F {:.1} MB, a solve {:.1} MB",
            flow.nnz_l(),
            (pores * 4 * 28) as f64 / 1e6,
            (pores * 4 * 28) as f64 / 1e6,
            flow.nnz_l() as f64 * 16.0 / 1e6,
        );
        group.bench_function(id("volume_rates"), |b| {
            b.iter(|| flow.update_volume_rate(&velocity, &walls));
        });
        group.bench_function(id("solve"), |b| b.iter(|| flow.update_pressure().expect("p")));
        group.bench_function(id("forces"), |b| b.iter(|| flow.update_force()));

        let mut coupled = specimen(&packing, bounds);
        coupled.step(1e-6).expect("the first step, with its network");
        group.bench_function(id("coupled_step"), |b| {
            b.iter(|| coupled.step(1e-6).expect("a step"));
        });
    }
    group.finish();
}

criterion_group!(benches, parts);
criterion_main!(benches);
