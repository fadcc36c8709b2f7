//! The same bits for any number of threads that the machine offers to the
//! BLAS and to OpenMP. Processes of their own: both are told by environment.

mod solver_systems;

use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use dempfv::solver::blas;
use solver_systems::{factor, network, numbers, solution_bits};

const NAME: &str = "factor_bits_do_not_depend_on_threads";
const CHILD: &str = "DEMPFV_TEST_SOLVER_CHILD";

/// A grid large enough that OpenBLAS shares its work out: with two threads of
/// its own the bits differ.
fn fingerprint() -> String {
    let a = network(28, 1);
    let mut f = factor(&a).unwrap();
    let mut hasher = DefaultHasher::new();
    solution_bits(&mut *f, &numbers(a.n, 2)).hash(&mut hasher);
    format!("bits {:x} with {:?} BLAS threads", hasher.finish(), blas::threads())
}

fn in_a_process_with(threads: &str) -> String {
    let output = Command::new(std::env::current_exe().unwrap())
        .args([NAME, "--exact", "--nocapture"])
        .envs([CHILD, "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"].map(|key| (key, threads)))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.contains("bits ")).expect("the child prints its bits");
    line[line.find("bits ").unwrap()..].to_owned()
}

#[test]
fn factor_bits_do_not_depend_on_threads() {
    if std::env::var_os(CHILD).is_some() {
        println!("{}", fingerprint());
        return;
    }
    let one = in_a_process_with("1");
    assert_eq!(in_a_process_with("2"), one);
    assert_eq!(in_a_process_with("4"), one);
}
