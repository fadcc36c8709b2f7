//! OpenBLAS in a limited address space.

use std::env;
use std::os::unix::process::CommandExt;
use std::process::Command;

use dempfv::solver::address_space_limit;

/// What OpenBLAS takes its number of threads from when it is loaded.
const THREADS: &str = "OPENBLAS_NUM_THREADS";

/// Where the address space is limited, starts the program anew with OpenBLAS on one thread, unless it
/// is. OpenBLAS starts its threads before `main`, and each takes 128 MiB that no solver here uses; one
/// that does not get them asks for them without end, and the process waits for it when it exits.
pub fn start_without_blas_threads() {
    if address_space_limit().is_none() || env::var_os(THREADS).is_some_and(|n| n == "1") {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // Returns only where that was not possible: the program then goes on as it is.
        let _ = Command::new(program).args(env::args_os().skip(1)).env(THREADS, "1").exec();
    }
}
