//! Memory of a GPU that serves one network after another, on the stand-in for
//! CUDA (see `solver_gpu.rs`). Alone in its process: it counts bytes.
#![cfg(feature = "cuda")]

mod solver_systems;

use dempfv::solver::{Factor, GpuOptions, Placement, SolverKind, SymmetricCsc, gpus};
use solver_systems::laplacian;

fn factor(a: &SymmetricCsc) -> Box<dyn Factor> {
    let kind = SolverKind::CholmodGpu(GpuOptions::default());
    let factor = kind.backend().analyze(a, None).unwrap().factor(a).unwrap();
    assert!(matches!(factor.placement(), Placement::Gpu(work) if work.calls() > 0));
    factor
}

fn solve(factor: &mut dyn Factor, a: &SymmetricCsc) {
    let (b, mut x) = (vec![1.0; a.n], vec![0.0; a.n]);
    assert!(factor.solve_checked(a, &b, &mut x).unwrap() < 1e-12);
}

/// Two factors, of which one is solved with while another thread makes the
/// next, as with networks from the background; fifty of them, of two sizes.
/// After the first few the device has as much free as at the end, to the byte,
/// and the process no more than a part of one factor (40 MB) on top.
#[test]
fn fifty_factors_beside_another_leave_memory_as_it_was() {
    let sizes = [laplacian(26), laplacian(25)];
    let mut current = (factor(&sizes[0]), 0);
    let free = || gpus().unwrap()[0].memory_free_bytes;
    let (mut device, mut host) = (0, 0);
    for round in 1..=50 {
        let next = std::thread::scope(|scope| {
            let next = scope.spawn(|| factor(&sizes[round % 2]));
            solve(&mut *current.0, &sizes[current.1]);
            next.join().unwrap()
        });
        current = (next, round % 2);
        if round == 10 {
            (device, host) = (free(), resident());
        }
    }
    assert_eq!(free(), device);
    assert!(resident() < host + 20_000_000, "{} {host}", resident());
}

/// Memory that this process holds (bytes).
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.trim().strip_suffix("kB").unwrap().trim().parse::<u64>().unwrap() * 1024
}
