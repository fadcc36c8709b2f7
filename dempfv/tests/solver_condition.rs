//! Estimates of the condition and of the error, beside the exact ones.

mod solver_systems;

use dempfv::solver::{Factor, SolverKind, SymmetricCsc, condition_number, forward_error};
use solver_systems::{laplacian, numbers};

const KINDS: [SolverKind; 2] = [SolverKind::Cholmod, SolverKind::Frontal];

fn factor(kind: SolverKind, a: &SymmetricCsc) -> Box<dyn Factor> {
    kind.backend().analyze(a, None).unwrap().factor(a).unwrap()
}

/// n unknowns in a row between two that are zero: 2 on the diagonal, -1 beside it.
fn row(n: usize) -> SymmetricCsc {
    let diagonal = (0..n).map(|k| (k, k, 2.0));
    let beside = (1..n).map(|k| (k, k - 1, -1.0));
    SymmetricCsc::from_triplets(n, diagonal.chain(beside)).unwrap()
}

/// n unknowns in a row, the first of which leaks.
fn leaking_row(n: usize, leak: f64) -> SymmetricCsc {
    let throats = (1..n).flat_map(|k| [(k, k, 1.0), (k - 1, k - 1, 1.0), (k, k - 1, -1.0)]);
    SymmetricCsc::from_triplets(n, throats.chain([(0, 0, leak)])).unwrap()
}

/// D A D.
fn scaled(mut a: SymmetricCsc, d: impl Fn(usize) -> f64) -> SymmetricCsc {
    for j in 0..a.n {
        for k in a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize {
            a.values[k] *= d(j) * d(a.row_idx[k] as usize);
        }
    }
    a
}

/// ‖A‖₁ ‖A⁻¹‖₁ from all columns of the inverse.
fn exact_condition(a: &SymmetricCsc) -> f64 {
    let mut factor = factor(SolverKind::Cholmod, a);
    let mut column = vec![0.0; a.n];
    let norms = (0..a.n).map(|j| {
        let mut e = vec![0.0; a.n];
        e[j] = 1.0;
        factor.solve(&e, &mut column).unwrap();
        column.iter().map(|x| x.abs()).sum::<f64>()
    });
    norms.fold(0.0, f64::max) * a.norm_inf()
}

/// ‖A‖₁ is 4, and the largest sum of a row of A⁻¹ is k (n + 1 - k) / 2 in the middle. The inverse has
/// no negative entry, so that the estimate is exact but for round-off, which the condition magnifies.
#[test]
fn rows_of_unknowns_have_their_known_condition() {
    for n in [1usize, 2, 3, 4, 31, 1000, 20_001] {
        let middle = n.div_ceil(2);
        let norm = [2.0, 3.0, 4.0][n.min(3) - 1];
        let exact = norm * (middle * (n + 1 - middle)) as f64 / 2.0;
        for kind in KINDS {
            let found = condition_number(&mut *factor(kind, &row(n)), &row(n)).unwrap();
            let off = (found / exact - 1.0).abs();
            assert!(
                off < 4.0 * f64::EPSILON * (exact + 10.0),
                "{kind:?}, {n}: {found} for {exact}"
            );
        }
    }
}

/// Entries of both signs, where Hager's ascent may end at a column that is not the largest: never
/// above, and within a factor of 3 (1.7 at worst).
#[test]
fn matrices_of_both_signs_are_estimated_from_below() {
    let mut seen = 0;
    for seed in 1..40 {
        let mut a = laplacian(4);
        let random = numbers(a.nnz(), seed);
        for j in 0..a.n {
            let range = a.col_ptr[j] as usize + 1..a.col_ptr[j + 1] as usize;
            a.values[range.clone()].copy_from_slice(&random[range]);
            // Between a matrix that is far from singular and ones that nearly are.
            a.values[a.col_ptr[j] as usize] = 2.6 + 0.05 * seed as f64;
        }
        let Ok(mut factor) = SolverKind::Cholmod.backend().analyze(&a, None).unwrap().factor(&a)
        else {
            continue;
        };
        let ratio = condition_number(&mut *factor, &a).unwrap() / exact_condition(&a);
        assert!(ratio < 1.0 + 1e-9 && ratio > 1.0 / 3.0, "seed {seed}: {ratio}");
        seen += 1;
    }
    assert!(seen > 20, "{seen} of the matrices were positive definite");
}

/// In rows whose first unknown alone leaks, the leak decides the solution, and it is the difference
/// of numbers near 1. The largest column of the inverse is the last, with 1 / leak + k in row k from 0
/// on, and ‖A‖₁ = 4. CHOLMOD's true error, with the solution all ones,
/// is below the estimate, and the estimate not more than a few tens of it.
#[test]
fn estimated_errors_are_those_that_solutions_have() {
    for (n, leak) in [(100, 1e-6), (20_000, 1e-8), (100, 4e-13), (1000, 4e-12), (3000, 1e-12)] {
        let a = leaking_row(n, leak);
        let mut factor = factor(SolverKind::Cholmod, &a);
        let (mut b, mut x) = (vec![0.0; n], vec![0.0; n]);
        a.multiply(&vec![1.0; n], &mut b).unwrap();
        factor.solve_checked(&a, &b, &mut x).unwrap();
        let error = x.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max);
        let estimate = forward_error(&mut *factor, &a, &b, &x).unwrap();
        assert!(error < estimate && estimate < 50.0 * error, "{n}, {leak}: {error}, {estimate}");
        // As much as round-off leaves of it.
        let exact = 4.0 * n as f64 * (1.0 / leak + (n - 1) as f64 / 2.0);
        let ratio = condition_number(&mut *factor, &a).unwrap() / exact;
        assert!(ratio > 1.0 / 3.0 && ratio < 1.0 + estimate, "{n}, {leak}: {ratio}");
    }
}

/// Unknowns in other units: the condition grows to where it would leave two digits, and no digit
/// is lost, for the factorization is the same but for its units.
#[test]
fn other_units_of_unknowns_raise_the_condition_and_not_the_error() {
    let n = 31;
    let unit = |k: usize| 10f64.powi(k as i32 % 8 - 4);
    let a = scaled(row(n), unit);
    let mut factor = factor(SolverKind::Cholmod, &a);
    let ratio = condition_number(&mut *factor, &a).unwrap() / exact_condition(&a);
    assert!(ratio < 1.0 + 1e-9 && ratio > 1.0 / 3.0, "{ratio}");
    assert!(condition_number(&mut *factor, &a).unwrap() > 1e14);
    let known: Vec<f64> = (0..n).map(|k| 1.0 / unit(k)).collect();
    let (mut b, mut x) = (vec![0.0; n], vec![0.0; n]);
    a.multiply(&known, &mut b).unwrap();
    factor.solve_checked(&a, &b, &mut x).unwrap();
    let error = x.iter().zip(&known).map(|(x, k)| ((x - k) / k).abs()).fold(0.0, f64::max);
    let estimate = forward_error(&mut *factor, &a, &b, &x).unwrap();
    assert!(error < 1e-12 && estimate < 1e-12, "{error}, {estimate}");
}

/// Neither norm leaves double precision on the way, and the bits are the same each time.
#[test]
fn units_of_the_matrix_change_nothing() {
    for kind in KINDS {
        let estimates = [1.0, 2f64.powi(-900), 2f64.powi(900)].map(|unit| {
            let mut a = row(1000);
            a.values.iter_mut().for_each(|v| *v *= unit);
            let mut factor = factor(kind, &a);
            let (b, mut x) = (vec![unit; a.n], vec![0.0; a.n]);
            factor.solve(&b, &mut x).unwrap();
            let condition = condition_number(&mut *factor, &a).unwrap();
            (condition, forward_error(&mut *factor, &a, &b, &x).unwrap())
        });
        assert!(estimates.iter().all(|e| *e == estimates[0]), "{kind:?}: {estimates:?}");
    }
}

/// No unknowns have the condition of a matrix that changes nothing, and one has it too.
#[test]
fn no_unknowns_and_one() {
    for n in [0, 1] {
        let a = SymmetricCsc::from_triplets(n, (0..n).map(|k| (k, k, 7.0))).unwrap();
        let mut factor = factor(SolverKind::Cholmod, &a);
        assert!((condition_number(&mut *factor, &a).unwrap() - 1.0).abs() < 1e-15);
        assert!(forward_error(&mut *factor, &a, &vec![7.0; n], &vec![1.0; n]).unwrap() < 1e-15);
    }
}
