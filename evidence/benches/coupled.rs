//! The coupled system by its parts, on settled packings of 1,000, 5,000 and
//! 20,000 spheres: network build, ordering and analysis, factorization, one
//! solve, the operators, one coupled step without a remesh.
//!
//! Below each time stand the bytes and operations that it takes at least, and
//! how long they take at the machine's limits, which are measured first. What
//! fits into the caches may be faster than the memory.

mod floor;

use std::path::PathBuf;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, Network, Operators};
use dempfv::solver::{Factor, SolverKind};
use dempfv::{Aabb, Vec3, WallId};
use floor::{Floor, Work};

/// Four corners of a pore and a vector for each, and a number.
const GRADIENT: f64 = 4.0 * (4.0 + 24.0) + 8.0;

/// Water, drained at the top.
fn fluid() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
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

/// What the parts must do, by pore, unknown and entry of the factor.
struct Works {
    network: Work,
    analyze: Work,
    factor: Work,
    operator: Work,
    solve: Work,
    step: Work,
}

impl Works {
    fn new(flow: &Flow, factor: &dyn Factor, contacts: usize) -> Works {
        let (pores, unknowns) = (flow.network().pores(), flow.operators().unknowns());
        let analysis = factor.analysis();
        let each = |total: f64| total / unknowns as f64;
        let entries = each(flow.operators().matrix.nnz() as f64);
        let (l, nnz) = (each(factor.memory_bytes() as f64), each(analysis.nnz_l as f64));
        let of_pores = |bytes, flops| Work { count: pores, unit: "pores", bytes, flops };
        let of_unknowns = |bytes, flops| Work { count: unknowns, unit: "unknowns", bytes, flops };
        // Per pore: its corners, neighbours, centre and volume, two vectors for each
        // corner, and two throats with a number each; and some 400 operations a throat.
        let built = 4.0 * (4.0 + 4.0 + 24.0 + 24.0) + 32.0 + 2.0 * (8.0 + 8.0) + 16.0 * entries;
        // L twice, E and F, and what a dry step takes for its contacts.
        let steps = (2.0 * l + 2.0 * GRADIENT) * unknowns as f64 + 56.0 * contacts as f64;
        let computed = (4.0 * nnz + 48.0) * unknowns as f64 + 150.0 * contacts as f64;
        Works {
            network: of_pores(built, 800.0),
            // The pattern is read, an order written.
            analyze: of_unknowns(8.0 * entries + 16.0, 0.0),
            factor: of_unknowns(l + 16.0 * entries, each(analysis.flops)),
            operator: of_pores(GRADIENT, 24.0),
            solve: of_unknowns(2.0 * l, 4.0 * nnz),
            step: of_unknowns(each(steps), each(computed)),
        }
    }
}

fn parts(c: &mut Criterion) {
    let floor = Floor::measure();
    let pool = rayon::ThreadPoolBuilder::new().build().expect("a pool");
    for count in [1_000, 5_000, 20_000] {
        let mut group = c.benchmark_group("coupled");
        group.sample_size(10).measurement_time(Duration::from_secs(3));
        group.warm_up_time(Duration::from_secs(1));
        let (packing, bounds) = packing(count);
        let (x, r) = (&packing.position, &packing.radius);
        let id = |what| BenchmarkId::new(what, count);
        let mut flow = Flow::new(x, r, bounds, &fluid(), SolverKind::default()).expect("a flow");
        let mut coupled = specimen(&packing, bounds);
        coupled.step(1e-6).expect("the first step, with its network");
        let matrix = flow.operators().matrix.clone();
        let centers = flow.operators().pore_of.iter().map(|&i| flow.network().center[i as usize]);
        let points: Vec<[f64; 3]> = centers.map(Into::into).collect();
        let backend = SolverKind::default().backend();
        let analyze = || backend.analyze(&matrix, Some(&points)).expect("an analysis");
        let factor = analyze().factor(&matrix).expect("a factor");
        let works = Works::new(&flow, &*factor, coupled.dem().contacts().count());
        println!("{count} spheres: {} pores, nnz(L) {}", flow.network().pores(), flow.nnz_l());

        floor.bench(&mut group, id("network"), &works.network, &pool, || {
            let (network, derivatives) = Network::new(x, r, bounds, &fluid()).expect("a network");
            Operators::new(&network, derivatives, fluid().boundary).unwrap();
        });
        floor.bench(&mut group, id("analyze"), &works.analyze, &pool, || drop(analyze()));
        let mut factor = Some(factor);
        floor.bench(&mut group, id("factor"), &works.factor, &pool, || {
            factor = factor.take().map(|f| f.refactor(&matrix).expect("a factor"));
        });
        drop(factor);
        let velocity: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.0, -x.y, 0.0)).collect();
        let walls = [0.0; 6];
        floor.bench(&mut group, id("volume_rates"), &works.operator, &pool, || {
            flow.update_volume_rate(&velocity, &walls).expect("volume rates");
        });
        floor.bench(&mut group, id("solve"), &works.solve, &pool, || {
            flow.update_pressure().expect("pressures");
        });
        floor.bench(&mut group, id("forces"), &works.operator, &pool, || flow.update_force());
        floor.bench(&mut group, id("coupled_step"), &works.step, &pool, || {
            coupled.step(1e-6).expect("a step");
        });
        group.finish();
    }
}

criterion_group!(benches, parts);
criterion_main!(benches);
