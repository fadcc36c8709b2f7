//! Memory of a GPU that serves one network after another, on the stand-in for
//! CUDA (see `solver_gpu.rs`). Alone in its process: it counts bytes.
#![cfg(feature = "cuda")]

use std::path::Path;

use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::scene::load_packing;
use dempfv::solver::{GpuOptions, Placement, SolverKind, gpus};
use dempfv::{Aabb, Vec3};

/// The network of the spheres where they are, each a little aside in every round.
fn network(position: &[Vec3], radius: &[f64], bounds: Aabb, round: u32) -> Flow {
    let pressure = [None, None, Some(1.0), Some(0.0), None, None].into();
    let boundary = Boundary { pressure, ..Boundary::default() };
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let middle = bounds.min + 0.5 * (bounds.max - bounds.min);
    let shrink = 1.0 - 1e-4 * f64::from(round % 7);
    let moved: Vec<Vec3> = position.iter().map(|x| middle + shrink * (x - middle)).collect();
    let solver = SolverKind::CholmodGpu(GpuOptions::default());
    let flow = Flow::new(&moved, radius, bounds, &fluid, solver).unwrap();
    assert!(matches!(flow.placement(), Placement::Gpu(work) if work.calls() > 0));
    flow
}

/// Two networks, of which one is solved with while another thread makes the next,
/// as in the background; fifty of them. After the first few the device has as
/// much free as at the end, to the byte. The process may hold 240 MB more: the
/// allocator keeps some 20 MB now and then, and a leak of a fifth of each of the
/// forty networks (30 MB) would come to that.
#[test]
fn fifty_remeshes_leave_memory_as_it_was() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../packings/oedometer-5000.txt");
    let (packing, bounds) = load_packing(&file, None).unwrap();
    let next = |round| network(&packing.position, &packing.radius, bounds, round);
    let mut current = next(0);
    let free = || gpus().unwrap()[0].memory_free_bytes;
    let (mut device, mut host) = (0, 0);
    for round in 1..=50 {
        current = std::thread::scope(|scope| {
            let next = scope.spawn(|| next(round));
            current.solve_static().unwrap();
            assert!(current.residual().unwrap() < 1e-12);
            next.join().unwrap()
        });
        if round == 10 {
            (device, host) = (free(), resident());
        }
    }
    assert_eq!(free(), device);
    assert!(resident() < host + 240_000_000, "{} {host}", resident());
}

/// Memory that this process holds (bytes).
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().strip_suffix("kB").unwrap().trim().parse::<u64>().unwrap() * 1024
}
