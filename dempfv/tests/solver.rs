//! What the solvers promise, on systems whose solutions are known.
//!
//! The grids with 6³ unknowns take CHOLMOD's simplicial path, those with 20³
//! the supernodal one.

mod solver_systems;

use dempfv::solver::{RESIDUAL_LIMIT, SolverError, SolverKind, SymmetricCsc};
use solver_systems::{factor, laplacian, network, numbers, solution_bits};

const GRIDS: [usize; 2] = [6, 20];

/// b = A x for a known x, so that the error of the solution itself is known.
/// The condition number of the 20³ Laplacian is (2/(π/21))² ≈ 180, so its
/// error stays within 180 times the round-off of some 10⁻¹⁶.
#[test]
fn laplacian_is_solved_to_round_off() {
    for m in GRIDS {
        let a = laplacian(m);
        let known = numbers(a.n, 1);
        let (mut b, mut x) = (vec![0.0; a.n], vec![0.0; a.n]);
        a.multiply(&known, &mut b).unwrap();
        let residual = factor(&a).unwrap().solve_checked(&a, &b, &mut x).unwrap();
        assert!(residual < 1e-15, "residual {residual:e}");
        let error = x.iter().zip(&known).map(|(x, k)| (x - k).abs()).fold(0.0, f64::max);
        assert!(error < 1e-13, "error {error:e}");
    }
}

/// Conductances of pores span nine decades; the residual stays at round-off
/// and the checks of pivots let them pass.
#[test]
fn conductances_over_nine_decades_are_solved() {
    for m in GRIDS {
        let a = network(m, 2);
        let mut x = vec![0.0; a.n];
        let residual = factor(&a).unwrap().solve_checked(&a, &numbers(a.n, 3), &mut x).unwrap();
        assert!(residual < 1e-15, "residual {residual:e}");
    }
}

/// A negative diagonal entry leaves every pivot before its own as it was, so
/// the factorization must stop at that very column, whatever the ordering.
#[test]
fn indefinite_matrix_names_the_callers_column() {
    for m in GRIDS {
        let n = m * m * m;
        for column in [0, 1, n / 3, n / 2 + 7, n - 1] {
            let mut a = laplacian(m);
            a.values[a.col_ptr[column] as usize] = -1.0;
            assert_eq!(factor(&a).err(), Some(SolverError::NotPositiveDefinite { column }));
        }
    }
}

/// A refactored indefinite matrix fails alike, after a good one.
#[test]
fn refactoring_an_indefinite_matrix_names_the_column() {
    for m in GRIDS {
        let mut a = laplacian(m);
        let good = factor(&a).unwrap();
        a.values[a.col_ptr[42] as usize] = -1.0;
        assert_eq!(good.refactor(&a).err(), Some(SolverError::NotPositiveDefinite { column: 42 }));
    }
}

/// Without an imposed pressure the network's matrix is singular: round-off
/// decides whether the last pivot comes out positive.
#[test]
fn singular_network_is_refused() {
    for m in GRIDS {
        let mut a = network(m, 4);
        for j in 0..a.n {
            a.values[a.col_ptr[j] as usize] -= 1e-12;
        }
        let mut x = vec![0.0; a.n];
        let error =
            factor(&a).and_then(|mut f| f.solve_checked(&a, &numbers(a.n, 5), &mut x)).err();
        assert!(
            matches!(
                error,
                Some(SolverError::NotPositiveDefinite { .. } | SolverError::NearlySingular { .. })
            ),
            "{error:?}"
        );
    }
}

/// A pivot that loses all digits: [1 1; 1 1+2⁻⁵²] has 2⁻⁵² as its second.
#[test]
fn vanishing_pivot_is_named() {
    let a = SymmetricCsc {
        n: 2,
        col_ptr: vec![0, 2, 3],
        row_idx: vec![0, 1, 1],
        values: vec![1.0, 1.0, 1.0 + f64::EPSILON],
    };
    match factor(&a).err() {
        Some(SolverError::NearlySingular { ratio, .. }) => {
            assert!((ratio / f64::EPSILON - 1.0).abs() < 1e-14);
        }
        other => panic!("{other:?}"),
    }
}

/// Same pattern, other values: refactoring gives the bits of a fresh factor.
#[test]
fn refactor_equals_fresh_factor_bit_for_bit() {
    for m in GRIDS {
        let (old, new) = (network(m, 6), network(m, 7));
        let b = numbers(old.n, 8);
        let mut first = factor(&old).unwrap();
        let bits_old = solution_bits(&mut *first, &b);
        let mut again = first.refactor(&new).unwrap();
        assert_eq!(solution_bits(&mut *again, &b), solution_bits(&mut *factor(&new).unwrap(), &b));
        let mut back = again.refactor(&old).unwrap();
        assert_eq!(solution_bits(&mut *back, &b), bits_old);
    }
}

/// METIS draws random numbers from the C library; an analysis must not depend
/// on what was drawn before it, nor on analyses on other threads.
#[test]
fn concurrent_analyses_and_factors_give_the_same_bits() {
    let a = network(20, 9);
    let b = numbers(a.n, 10);
    let alone = solution_bits(&mut *factor(&a).unwrap(), &b);
    let work = |a: &SymmetricCsc| solution_bits(&mut *factor(a).unwrap(), &b);
    for _ in 0..3 {
        let other = network(12, 11);
        let (one, two) = std::thread::scope(|scope| {
            let one = scope.spawn(|| work(&a));
            let disturb = scope.spawn(|| factor(&other).map(drop).unwrap());
            let two = scope.spawn(|| work(&a));
            disturb.join().unwrap();
            (one.join().unwrap(), two.join().unwrap())
        });
        assert!(one == alone && two == alone);
    }
}

/// The coupling factors in the background and solves in the foreground.
#[test]
fn factor_moves_between_threads() {
    let a = network(20, 12);
    let b = numbers(a.n, 13);
    let mut made_elsewhere =
        std::thread::scope(|s| s.spawn(|| factor(&a).unwrap()).join().unwrap());
    let here = solution_bits(&mut *factor(&a).unwrap(), &b);
    assert_eq!(solution_bits(&mut *made_elsewhere, &b), here);
}

#[test]
fn entries_that_are_no_numbers_are_named() {
    let good = laplacian(6);
    let mut a = good.clone();
    let k = a.col_ptr[10] as usize + 1;
    a.values[k] = f64::NAN;
    let row = a.row_idx[k] as usize;
    for error in [factor(&a).err(), factor(&good).unwrap().refactor(&a).err()] {
        assert!(
            matches!(error, Some(SolverError::MatrixNotFinite { row: r, column: 10, value })
                if r == row && value.is_nan()),
            "{error:?}"
        );
    }
    let mut b = vec![1.0; good.n];
    b[77] = f64::NEG_INFINITY;
    assert_eq!(
        factor(&good).unwrap().solve(&b, &mut vec![0.0; good.n]),
        Err(SolverError::RightHandSideNotFinite { row: 77, value: f64::NEG_INFINITY })
    );
}

#[test]
fn another_pattern_is_refused() {
    let a = laplacian(6);
    let mut other = a.clone();
    // Moves one entry to another row of its column.
    let k = other.col_ptr[0] as usize + 3;
    other.row_idx[k] += 1;
    assert_eq!(other.validate(), Ok(()));
    let symbolic = SolverKind::Cholmod.backend().analyze(&a, None).unwrap();
    assert_eq!(symbolic.factor(&other).err(), Some(SolverError::PatternChanged));
    assert_eq!(factor(&a).unwrap().refactor(&other).err(), Some(SolverError::PatternChanged));
}

#[test]
fn wrong_sizes_are_refused() {
    let a = laplacian(6);
    let mut f = factor(&a).unwrap();
    let (b, mut short) = (vec![1.0; a.n], vec![0.0; 3]);
    let wrong = |what, found| SolverError::WrongSize { what, expected: 216, found };
    assert_eq!(f.solve(&b, &mut short), Err(wrong("the solution", 3)));
    assert_eq!(f.solve(&short, &mut vec![0.0; a.n]), Err(wrong("the right-hand side", 3)));
    let error = SolverKind::Cholmod.backend().analyze(&a, Some(&[[0.0; 3]; 2])).err();
    assert_eq!(error, Some(wrong("the list of coordinates", 2)));
}

#[test]
fn malformed_matrices_are_named() {
    type Fault = fn(&mut SymmetricCsc);
    let faults: [(usize, Fault); 6] = [
        (0, |a| a.col_ptr[0] = 1),
        (216, |a| a.values.push(1.0)),
        (3, |a| a.col_ptr[4] = a.col_ptr[3] - 1),
        (5, |a| a.row_idx[a.col_ptr[5] as usize] = 4),
        (5, |a| a.row_idx[a.col_ptr[5] as usize + 1] = 200),
        (7, |a| a.row_idx[a.col_ptr[8] as usize - 1] = 216),
    ];
    for (at, fault) in faults {
        let mut a = laplacian(6);
        fault(&mut a);
        match factor(&a).err() {
            Some(SolverError::InvalidMatrix { column, .. }) => assert_eq!(column, at),
            other => panic!("column {at}: {other:?}"),
        }
    }
}

/// No unknowns, one, and unknowns that are not coupled.
#[test]
fn degenerate_systems_are_solved() {
    for n in [0usize, 1, 5] {
        let a = SymmetricCsc {
            n,
            col_ptr: (0..=n as i64).collect(),
            row_idx: (0..n as i64).collect(),
            values: (1..=n).map(|k| k as f64).collect(),
        };
        let (b, mut x) = (vec![1.0; n], vec![0.0; n]);
        let mut f = factor(&a).unwrap();
        assert!(f.solve_checked(&a, &b, &mut x).unwrap() < 1e-15);
        for (k, x) in x.iter().enumerate() {
            assert!((x * (k + 1) as f64 - 1.0).abs() < 1e-15);
        }
        f.refactor(&a).unwrap();
    }
}

/// A solve against another matrix than the one factored is caught.
#[test]
fn residual_above_the_limit_is_an_error() {
    let a = laplacian(6);
    let mut changed = a.clone();
    changed.values[0] += 1.0;
    let mut x = vec![0.0; a.n];
    match factor(&changed).unwrap().solve_checked(&a, &vec![1.0; a.n], &mut x) {
        Err(SolverError::ResidualTooLarge { residual, limit }) => {
            assert!(residual > 1e-3 && limit == RESIDUAL_LIMIT);
        }
        other => panic!("{other:?}"),
    }
}

/// A residual that is no number must not pass as a small one.
#[test]
fn residual_of_no_number_is_no_number() {
    let a = laplacian(2);
    let mut x = vec![0.0; 8];
    x[3] = f64::NAN;
    assert!(a.residual(&[1.0; 8], &x).unwrap().is_nan());
    assert_eq!(a.residual(&[0.0; 8], &[0.0; 8]), Ok(0.0));
}

/// nnz(L) and the operations of a dense matrix are known: n(n+1)/2 and
/// Σ k² = n(n+1)(2n+1)/6.
#[test]
fn counts_of_a_dense_matrix() {
    let n = 10usize;
    let mut a = SymmetricCsc { n, col_ptr: vec![0], ..Default::default() };
    for j in 0..n {
        for i in j..n {
            a.row_idx.push(i as i64);
            a.values.push(if i == j { n as f64 } else { -0.5 });
        }
        a.col_ptr.push(a.row_idx.len() as i64);
    }
    let f = factor(&a).unwrap();
    assert_eq!(f.analysis().nnz_l, 55);
    assert_eq!(f.analysis().flops, 385.0);
    assert!(f.memory_bytes() >= 55 * 8);
}

/// Many right-hand sides have the solutions of one after the other, to the last bit, by every
/// solver; and lengths that do not fit are told.
#[test]
fn many_right_hand_sides_are_solved_as_one_by_one() {
    let a = network(20, 14);
    let columns = 3;
    let b = numbers(columns * a.n, 15);
    for kind in SolverKind::ALL {
        let mut f = kind.backend().analyze(&a, None).unwrap().factor(&a).unwrap();
        let mut x = vec![0.0; b.len()];
        f.solve_many(&b, &mut x, columns).unwrap();
        for (b, x) in b.chunks(a.n).zip(x.chunks(a.n)) {
            let bits: Vec<u64> = x.iter().map(|v| v.to_bits()).collect();
            assert!(solution_bits(&mut *f, b) == bits, "{kind}");
        }
        assert_eq!(f.solve_many(&[], &mut [], 0), Ok(()));
        let wrong = |what, expected, found| Err(SolverError::WrongSize { what, expected, found });
        assert_eq!(
            f.solve_many(&b, &mut x[1..], columns),
            wrong("the block of solutions", b.len(), b.len() - 1)
        );
        assert_eq!(
            f.solve_many(&b[1..], &mut x[1..], columns),
            wrong("the block of right-hand sides", b.len() - columns, b.len() - 1)
        );
        assert_eq!(
            f.solve_many(&b[..6], &mut x[..6], columns),
            wrong("the right-hand side", a.n, 2)
        );
        assert!(f.solve_many(&b, &mut x, 0).is_err());
    }
}

/// Entries of either triangle in any order, with throats that come twice, give the matrix that
/// was written down by columns.
#[test]
fn triplets_make_the_matrix() {
    let a = network(6, 16);
    let mut entries = vec![];
    for j in 0..a.n {
        for k in a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize {
            let (i, half) = (a.row_idx[k] as usize, 0.5 * a.values[k]);
            // Halves are exact, and so is their sum.
            entries.extend([(i, j, half), (j, i, half)]);
        }
    }
    entries.reverse();
    assert_eq!(SymmetricCsc::from_triplets(a.n, entries), Ok(a));
    let error = |entry| SymmetricCsc::from_triplets(3, [(0, 0, 1.0), entry]).err();
    assert_eq!(error((1, 3, 1.0)), Some(SolverError::EntryOutside { row: 1, column: 3, n: 3 }));
    let infinite = SolverError::MatrixNotFinite { row: 2, column: 1, value: f64::INFINITY };
    assert_eq!(error((2, 1, f64::INFINITY)), Some(infinite));
    let empty = SymmetricCsc::from_triplets(2, []).unwrap();
    assert_eq!((empty.nnz(), empty.validate()), (2, Ok(())));
}

/// What a program may print of a solver names it.
#[test]
fn solvers_have_a_debug_form() {
    let a = laplacian(3);
    let backend = SolverKind::Cholmod.backend();
    assert_eq!(format!("{backend:?}"), "Backend(cholmod)");
    let symbolic = backend.analyze(&a, None).unwrap();
    assert!(format!("{symbolic:?}").contains("metis"));
    assert!(format!("{:?}", symbolic.factor(&a).unwrap()).contains("\"cholmod\""));
}
