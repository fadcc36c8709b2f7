//! Memory that runs out. A process of its own: the limit holds for all of it.
#![cfg(target_os = "linux")]

mod solver_systems;

use std::process::Command;

use dempfv::solver::{SolverError, SolverKind};
use solver_systems::laplacian;

/// Address space of this process, in bytes.
fn address_space() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split(' ').next().unwrap().parse::<u64>().unwrap() * 4096
}

/// Caps the address space (soft limit) of this process.
fn limit_address_space(bytes: &str) {
    let pid = std::process::id().to_string();
    let status = Command::new("prlimit").args(["--pid", &pid, &format!("--as={bytes}:")]).status();
    assert!(status.unwrap().success());
}

/// The factor of the 48³ Laplacian needs over 200 MB, and some 100 MB are
/// asked for METIS: more than the 64 MB that the C library reserves for a
/// thread. With 16 MB left either runs out of memory and says so; with the
/// limit gone the same process solves.
#[test]
fn running_out_of_memory_is_an_error_of_its_own() {
    let a = laplacian(48);
    let backend = SolverKind::Cholmod.backend();
    let limited = || limit_address_space(&(address_space() + (16 << 20)).to_string());
    let unlimited = || limit_address_space("unlimited");
    let out = |phase| Some(SolverError::OutOfMemory { solver: "cholmod", phase, n: 110_592 });

    limited();
    let starved = backend.analyze(&a, None).err();
    unlimited();
    assert_eq!(starved, out("analyze"));

    let symbolic = backend.analyze(&a, None).unwrap();
    assert!(symbolic.analysis().nnz_l > 10_000_000);
    limited();
    let starved = symbolic.factor(&a).err();
    unlimited();
    assert_eq!(starved, out("factor"));

    let a = laplacian(20);
    let mut x = vec![0.0; a.n];
    let mut factor = backend.analyze(&a, None).unwrap().factor(&a).unwrap();
    assert!(factor.solve_checked(&a, &vec![1.0; a.n], &mut x).unwrap() < 1e-15);
}
