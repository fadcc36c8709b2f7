//! CHOLMOD's GPU code on the stand-in for CUDA, which does on the CPU what a GPU
//! would do: `make cuda-test` runs this where there is no GPU. It tells nothing
//! about speed.
#![cfg(feature = "cuda")]

mod solver_systems;

use dempfv::solver::{Factor, GpuOptions, GpuWork, Placement, SolverKind, SymmetricCsc, gpus};
use solver_systems::{bar, laplacian, numbers, with_conductances};

/// Its separators are large enough for each of the four kinds of work that
/// CHOLMOD gives to a GPU.
fn system() -> SymmetricCsc {
    bar(26, 52)
}

fn gpu(memory: Option<u64>) -> SolverKind {
    SolverKind::CholmodGpu(GpuOptions { device: 0, memory })
}

fn factor(kind: SolverKind, a: &SymmetricCsc) -> Box<dyn Factor> {
    kind.backend().analyze(a, None).unwrap().factor(a).unwrap()
}

fn work(factor: &dyn Factor) -> GpuWork {
    match factor.placement() {
        Placement::Gpu(work) => work.clone(),
        other => panic!("{other:?}"),
    }
}

fn reason(factor: &dyn Factor) -> String {
    match factor.placement() {
        Placement::Fallback { reason } => reason.clone(),
        other => panic!("{other:?}"),
    }
}

fn solution(factor: &mut dyn Factor, a: &SymmetricCsc) -> Vec<f64> {
    let b = numbers(a.n, 7);
    let mut x = vec![0.0; a.n];
    factor.solve(&b, &mut x).unwrap();
    let residual = a.residual(&b, &x).unwrap();
    assert!(residual <= 1e-12, "{residual}");
    x
}

/// Largest difference relative to the largest entry.
fn apart(x: &[f64], y: &[f64]) -> f64 {
    let off = x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    off / y.iter().map(|y| y.abs()).fold(0.0, f64::max)
}

#[test]
fn these_tests_run_on_the_stand_in() {
    let found = gpus().unwrap();
    assert_eq!(found.len(), 1);
    assert!(found[0].name.contains("stand-in"), "{found:?}");
}

/// The first, second and tenth factorization, each of another matrix: as the
/// CPU's to 1e-12 (the condition number is some 10³), with all counters moving.
#[test]
fn factorizations_are_the_cpus_and_are_counted() {
    let mut a = system();
    let mut on_gpu = factor(gpu(None), &a);
    let mut on_cpu = factor(SolverKind::Cholmod, &a);
    assert_eq!(on_cpu.placement(), &Placement::Cpu);
    for round in 1..=10 {
        let found = work(&*on_gpu);
        assert!(found.name.contains("stand-in"));
        for calls in [found.syrk_calls, found.gemm_calls, found.potrf_calls, found.trsm_calls] {
            assert!(calls > 0, "round {round}: {found:?}");
        }
        assert!(found.share > 0.2 && found.share < 2.0, "{found:?}");
        assert!(found.bytes_to_device > 0 && found.bytes_from_device > 0);
        let (x, y) = (solution(&mut *on_gpu, &a), solution(&mut *on_cpu, &a));
        assert!(apart(&x, &y) < 1e-12, "round {round}: {}", apart(&x, &y));
        for (&start, factor) in a.col_ptr.iter().zip(numbers(a.n, round)) {
            a.values[start as usize] = 6.5 + 0.4 * factor;
        }
        on_gpu = on_gpu.refactor(&a).unwrap();
        on_cpu = on_cpu.refactor(&a).unwrap();
    }
}

/// Conductances over nine decades, as pores have them.
#[test]
fn a_pore_network_is_solved_as_by_the_cpu() {
    let a = with_conductances(system(), 3);
    let mut on_gpu = factor(gpu(None), &a);
    assert!(work(&*on_gpu).calls() > 0);
    solution(&mut *on_gpu, &a);
}

/// With little memory supernodes are cut until they fit; with less there is a
/// message and the CPU.
#[test]
fn memory_is_not_exceeded() {
    let a = system();
    let mut free = factor(gpu(None), &a);
    let whole = work(&*free).memory;
    let expected = solution(&mut *free, &a);
    let limit = whole / 2;
    let mut cut = factor(gpu(Some(limit)), &a);
    let found = work(&*cut);
    assert!(found.memory <= limit && found.calls() > 0, "{found:?} of {limit}");
    assert!(apart(&solution(&mut *cut, &a), &expected) < 1e-12);
    let mut none = factor(gpu(Some(1_000_000)), &a);
    assert!(reason(&*none).contains("1 MB may be taken"), "{}", reason(&*none));
    assert!(apart(&solution(&mut *none, &a), &expected) < 1e-12);
}

/// What a GPU is of no use for stays on the CPU and says so.
#[test]
fn small_matrices_stay_on_the_cpu() {
    for side in [3, 12] {
        let a = laplacian(side);
        let mut small = factor(gpu(None), &a);
        assert!(reason(&*small).contains("large enough") || reason(&*small).contains("too small"));
        solution(&mut *small, &a);
    }
}

/// A bad matrix is named as the CPU names it, and the GPU is well afterwards.
#[test]
fn a_bad_pivot_is_the_matrix_s_fault() {
    let good = system();
    let mut bad = system();
    bad.values[bad.col_ptr[777] as usize] = -1.0;
    let analyze = |kind: SolverKind| kind.backend().analyze(&bad, None).unwrap();
    let by_gpu = analyze(gpu(None)).factor(&bad).err().unwrap();
    let by_cpu = analyze(SolverKind::Cholmod).factor(&bad).err().unwrap();
    assert_eq!(by_gpu, by_cpu);
    assert!(work(&*factor(gpu(None), &good)).calls() > 0);
}
