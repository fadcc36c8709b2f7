//! What the frontal solver promises beyond what every solver does: digits that
//! single precision has no right to, on all threads, and refusals of matrices
//! that are not a network's.

mod solver_systems;

use dempfv::solver::{Factor, SolverError, SolverKind, SymmetricCsc};
use solver_systems::{bar, laplacian, network, numbers, with_conductances};

fn factor_of(a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
    SolverKind::Frontal.backend().analyze(a, None)?.factor(a)
}

fn largest(x: impl Iterator<Item = f64>) -> f64 {
    x.fold(0.0, |m, v| m.max(v.abs()))
}

/// Conductances over nine decades: the condition number is beyond 10⁹, where
/// plain Cholesky factorization in single precision (10⁻⁷) has no digit left.
/// Without cancellation each entry of L is right to some 10⁻⁶, and so is a
/// solution that no sources of both signs take apart: all ones.
#[test]
fn one_correction_has_five_digits_whatever_the_condition_number() {
    for m in [6, 20, 34] {
        let a = network(m, 11);
        let mut b = vec![0.0; a.n];
        a.multiply(&vec![1.0; a.n], &mut b).unwrap();
        // Round-off of the rows whose sum is 1e-16 of their entries is no source.
        let diagonal = |i: usize| a.values[a.col_ptr[i] as usize];
        b.iter_mut().enumerate().for_each(|(i, b)| {
            if b.abs() < 1e-14 * diagonal(i) {
                *b = 0.0;
            }
        });
        let mut x = vec![0.0; a.n];
        factor_of(&a).unwrap().correct(&b, &mut x).unwrap();
        let error = largest(x.iter().map(|x| x - 1.0));
        assert!(error < 1e-5, "{m}: {error:e}");
    }
}

/// A refined solve is as good as CHOLMOD's in double precision, whose own error
/// is round-off (1e-16) times a condition number of some 1e9.
#[test]
fn a_solve_has_the_digits_of_double_precision() {
    for m in [6, 20, 34] {
        let a = network(m, 12);
        let b: Vec<f64> = numbers(a.n, 13);
        let (mut ours, mut theirs) = (vec![0.0; a.n], vec![0.0; a.n]);
        let residual = factor_of(&a).unwrap().solve_checked(&a, &b, &mut ours).unwrap();
        assert!(residual < 1e-15, "{m}: {residual:e}");
        let symbolic = SolverKind::Cholmod.backend().analyze(&a, None).unwrap();
        symbolic.factor(&a).unwrap().solve(&b, &mut theirs).unwrap();
        let difference = largest(ours.iter().zip(&theirs).map(|(a, b)| a - b));
        assert!(difference < 1e-7 * largest(theirs.iter().copied()), "{m}: {difference:e}");
    }
}

/// A bar's separators are 16 columns wide: fronts above the subtrees that are one narrow
/// block each.
#[test]
fn narrow_fronts_above_subtrees() {
    let a = with_conductances(bar(4, 20_000), 17);
    let b = numbers(a.n, 18);
    let solved = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut x = vec![0.0; a.n];
            let residual = factor_of(&a).unwrap().solve_checked(&a, &b, &mut x).unwrap();
            assert!(residual < 1e-15, "{residual:e}");
            x
        })
    };
    assert!(solved(1) == solved(2));
}

/// 34³ unknowns: subtrees, fronts of many tiles, tiles that share their work.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let a = network(34, 14);
    let b = numbers(a.n, 15);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (mut once, mut whole) = (vec![0.0; a.n], vec![0.0; a.n]);
            let mut factor = factor_of(&a).unwrap();
            factor.correct(&b, &mut once).unwrap();
            factor.solve(&b, &mut whole).unwrap();
            once.into_iter().chain(whole).map(f64::to_bits).collect::<Vec<_>>()
        })
    };
    let one = on(1);
    assert!(one == on(2));
    assert!(one == on(5));
}

/// Same pattern, other values, of which other columns of the factor are kept in fewer bits:
/// refactoring in the same memory gives the bits of a fresh factor.
#[test]
fn refactor_equals_fresh_factor_bit_for_bit() {
    let (old, new) = (network(34, 14), network(34, 16));
    let b = numbers(old.n, 15);
    let solved = |factor: &mut dyn Factor| {
        let mut x = vec![0.0; b.len()];
        factor.correct(&b, &mut x).unwrap();
        x.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let mut first = factor_of(&old).unwrap();
    let with_old = solved(&mut *first);
    let mut again = first.refactor(&new).unwrap();
    assert!(solved(&mut *again) == solved(&mut *factor_of(&new).unwrap()));
    let mut back = again.refactor(&old).unwrap();
    assert!(solved(&mut *back) == with_old);
}

/// The entries of L that the pattern calls for are CHOLMOD's, for the same
/// ordering, whatever zeros fronts hold besides.
#[test]
fn fill_is_counted_as_cholmod_counts_it() {
    for m in [3, 6, 20] {
        let a = laplacian(m);
        let count = |kind: SolverKind| kind.backend().analyze(&a, None).unwrap().analysis();
        let (ours, theirs) = (count(SolverKind::Frontal), count(SolverKind::Cholmod));
        assert_eq!(ours.nnz_l, theirs.nnz_l);
        assert!((ours.flops / theirs.flops - 1.0).abs() < 1e-12);
    }
}

/// Some 3.9 million entries of L: half of CHOLMOD's bytes, and the fronts' zeros.
#[test]
fn memory_is_well_below_that_of_double_precision() {
    let a = network(34, 16);
    let bytes = |kind: SolverKind| {
        let symbolic = kind.backend().analyze(&a, None).unwrap();
        symbolic.factor(&a).unwrap().memory_bytes() as f64
    };
    let ratio = bytes(SolverKind::Frontal) / bytes(SolverKind::Cholmod);
    assert!(ratio < 0.65, "{ratio}");
}

/// A matrix that is not a network's is refused with the entry or the row.
#[test]
fn other_matrices_are_refused() {
    let mut a = laplacian(4);
    let entry = a.col_ptr[5] as usize + 1;
    a.values[entry] = 0.25;
    let row = a.row_idx[entry] as usize;
    let expected = SolverError::PositiveOffDiagonal { row, column: 5, value: 0.25 };
    assert_eq!(factor_of(&a).err(), Some(expected));

    let mut a = laplacian(4);
    // An inner unknown with six neighbours.
    let inner = (1 + 4 + 16) as usize;
    a.values[a.col_ptr[inner] as usize] = 5.5;
    let expected = SolverError::NotDominant { row: inner, sum: -0.5, diagonal: 5.5 };
    assert_eq!(factor_of(&a).err(), Some(expected));
}

/// The diagonal entry is a sum of many, rounded at each addition: what a row lacks
/// by that is round-off, and no negative sum. Here ten units in the last place are lacking
/// of a sum of 40, which may differ by as many as it has terms.
#[test]
fn round_off_of_long_rows_is_no_negative_sum() {
    let spokes = 40usize;
    let weights: Vec<f64> = (1..=spokes).map(|k| 1.0 / (3.0 * k as f64)).collect();
    let sum = weights.iter().sum::<f64>();
    for hub in [sum * (1.0 - 10.0 * f64::EPSILON), sum] {
        let mut a = SymmetricCsc { n: spokes + 1, col_ptr: vec![0], ..Default::default() };
        a.row_idx = (0..=spokes as i64).collect();
        a.values = std::iter::once(hub).chain(weights.iter().map(|w| -w)).collect();
        a.col_ptr.push(a.row_idx.len() as i64);
        for (k, w) in weights.iter().enumerate() {
            a.row_idx.push(k as i64 + 1);
            // The spokes' ends leak.
            a.values.push(w + 1e-3);
            a.col_ptr.push(a.row_idx.len() as i64);
        }
        let mut x = vec![0.0; a.n];
        let b = vec![1.0; a.n];
        let residual = factor_of(&a).unwrap().solve_checked(&a, &b, &mut x).unwrap();
        assert!(residual < 1e-14, "{residual:e}");
    }
}

/// A network that nothing flows out of has no solution.
#[test]
fn a_closed_network_is_singular() {
    let mut a = laplacian(5);
    let mut sums = vec![0.0; a.n];
    a.multiply(&vec![1.0; a.n], &mut sums).unwrap();
    for (i, sum) in sums.iter().enumerate() {
        a.values[a.col_ptr[i] as usize] -= sum;
    }
    assert!(matches!(factor_of(&a).err(), Some(SolverError::NearlySingular { .. })));
}

/// Networks apart from each other, and unknowns without neighbours.
#[test]
fn a_matrix_in_pieces_is_solved() {
    let (a, b) = (network(9, 17), network(7, 18));
    let mut both = a.clone();
    both.n += b.n + 1;
    both.col_ptr.pop();
    both.col_ptr.extend(b.col_ptr.iter().map(|p| p + a.nnz() as i64));
    both.col_ptr.push((a.nnz() + b.nnz() + 1) as i64);
    both.row_idx.extend(b.row_idx.iter().map(|r| r + a.n as i64));
    both.values.extend(&b.values);
    both.row_idx.push(both.n as i64 - 1);
    both.values.push(2.0);
    let rhs = numbers(both.n, 19);
    let mut x = vec![0.0; both.n];
    let residual = factor_of(&both).unwrap().solve_checked(&both, &rhs, &mut x).unwrap();
    assert!(residual < 1e-15, "{residual:e}");
}
