//! The default solver: the fastest for the size, and one that takes the matrix.

mod solver_systems;

use dempfv::solver::{
    Backend, FRONTAL_FROM, Factor, Frontal, SolverError, SolverKind, SymmetricCsc,
};
use solver_systems::{laplacian, network, numbers, solution_bits};

/// Unknowns along a side: fewer in all than [`FRONTAL_FROM`], and as many.
const SIDES: [usize; 2] = [19, 20];

fn factor(kind: SolverKind, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
    kind.backend().analyze(a, None)?.factor(a)
}

fn is_large(a: &SymmetricCsc) -> bool {
    a.n >= FRONTAL_FROM
}

/// Positive definite, with one entry off the diagonal that is positive.
fn with_positive_entry(m: usize) -> SymmetricCsc {
    let mut a = laplacian(m);
    let entry = a.col_ptr[5] as usize + 1;
    a.values[entry] = 0.25;
    a
}

/// Positive definite, with one row of a negative sum: an inner one, of six neighbours.
fn with_negative_row(m: usize) -> SymmetricCsc {
    let mut a = laplacian(m);
    a.values[a.col_ptr[1 + m + m * m] as usize] = 5.5;
    a
}

/// Below the limit CHOLMOD, from there on the frontal solver, with its bits.
#[test]
fn the_size_decides_for_networks() {
    for m in SIDES {
        let a = network(m, 1);
        let mut own = factor(SolverKind::Auto, &a).unwrap();
        let kind = if is_large(&a) { SolverKind::Frontal } else { SolverKind::Cholmod };
        assert_eq!(own.solver(), kind.name());
        let b = numbers(a.n, 2);
        let mut same = factor(kind, &a).unwrap();
        assert!(solution_bits(&mut *own, &b) == solution_bits(&mut *same, &b));
        assert_eq!(own.memory_bytes(), same.memory_bytes());
    }
}

/// A program does not break as it grows past the limit: what the frontal solver refuses,
/// CHOLMOD solves.
#[test]
fn matrices_that_are_no_networks_are_solved_by_cholmod() {
    for m in SIDES {
        for a in [with_positive_entry(m), with_negative_row(m)] {
            if is_large(&a) {
                let refused = Frontal.analyze(&a, None).unwrap().factor(&a).err();
                assert!(matches!(
                    refused,
                    Some(SolverError::PositiveOffDiagonal { .. } | SolverError::NotDominant { .. })
                ));
            }
            let mut own = factor(SolverKind::Auto, &a).unwrap();
            assert_eq!(own.solver(), "cholmod");
            let (b, mut x) = (numbers(a.n, 3), vec![0.0; a.n]);
            assert!(own.solve_checked(&a, &b, &mut x).unwrap() < 1e-15);
            own.correct_checked(&a, &b, &mut x).unwrap();
        }
    }
}

/// What is wrong for both solvers stays an error, with the caller's column.
#[test]
fn matrices_that_are_not_positive_definite_are_refused() {
    for m in SIDES {
        let mut a = with_positive_entry(m);
        a.values[a.col_ptr[4321] as usize] = -1.0;
        let error = factor(SolverKind::Auto, &a).err();
        assert_eq!(error, Some(SolverError::NotPositiveDefinite { column: 4321 }));
    }
}

/// Values may go to and fro on one pattern: each factor has the bits of a fresh one, and
/// memory is held for one of the two only.
#[test]
fn refactoring_changes_the_solver_and_equals_a_fresh_factor() {
    for m in SIDES {
        let (good, other) = (network(m, 4), with_positive_entry(m));
        let b = numbers(good.n, 5);
        let fresh = |a: &SymmetricCsc| {
            let mut factor = factor(SolverKind::Auto, a).unwrap();
            (factor.solver(), factor.memory_bytes(), solution_bits(&mut *factor, &b))
        };
        let expected = [&good, &other].map(fresh);
        let mut own = factor(SolverKind::Auto, &good).unwrap();
        for k in [1, 1, 0, 1, 0, 0] {
            own = own.refactor([&good, &other][k]).unwrap();
            let (solver, bytes, bits) = &expected[k];
            assert_eq!(own.solver(), *solver);
            assert!(solution_bits(&mut *own, &b) == *bits);
            // A common keeps workspaces of a solve.
            let held = own.memory_bytes() as f64;
            assert!(held < 1.1 * *bytes as f64, "{held} {bytes}");
        }
        let error = own.refactor(&network(m - 1, 4)).err();
        assert_eq!(error, Some(SolverError::PatternChanged));
    }
}
