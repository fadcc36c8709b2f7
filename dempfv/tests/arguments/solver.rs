//! Rows of the linear solvers.

use super::Table;
use dempfv::solver::{
    ConjugateGradients, ErrorGoal, Factor, SolverKind, SymmetricCsc, SystemSize, blas,
    condition_number, forward_error, ordering,
};

/// Three pores in a row between two imposed pressures.
fn row() -> SymmetricCsc {
    SymmetricCsc {
        n: 3,
        col_ptr: vec![0, 2, 4, 5],
        row_idx: vec![0, 1, 1, 2, 2],
        values: vec![2.0, -1.0, 2.0, -1.0, 2.0],
    }
}

/// A matrix of two unknowns.
fn pair() -> SymmetricCsc {
    SymmetricCsc { n: 2, col_ptr: vec![0, 1, 2], row_idx: vec![0, 1], values: vec![1.0; 2] }
}

fn factor(kind: SolverKind) -> Box<dyn Factor> {
    kind.backend().analyze(&row(), None).unwrap().factor(&row()).unwrap()
}

/// Matrices whose arrays do not belong together, with a word of what is said of each.
fn malformed() -> Vec<(&'static str, SymmetricCsc)> {
    vec![
        ("column pointers", SymmetricCsc { n: 4, ..row() }),
        ("column pointers", SymmetricCsc { n: usize::MAX, ..row() }),
        ("column pointer", SymmetricCsc { col_ptr: vec![], ..row() }),
        ("descend", SymmetricCsc { col_ptr: vec![0, 4, 2, 5], ..row() }),
        ("diagonal", SymmetricCsc { row_idx: vec![1, 0, 1, 2, 2], ..row() }),
        ("outside", SymmetricCsc { row_idx: vec![0, 7, 1, 2, 2], ..row() }),
        ("diagonal", SymmetricCsc { row_idx: vec![-1, 1, 1, 2, 2], ..row() }),
        ("values", SymmetricCsc { values: vec![], ..row() }),
    ]
}

const KINDS: [SolverKind; 3] = [SolverKind::Auto, SolverKind::Cholmod, SolverKind::Frontal];

pub fn table() -> Table {
    let mut t = Table::default();
    matrices(&mut t);
    for kind in KINDS {
        factors(&mut t, kind);
        conditions(&mut t, kind);
    }
    gradients(&mut t);
    t.refuses("solver::ordering::order", "coordinates", || ordering::order(&row(), &[[0.0; 3]]));
    t.gives("solver::ordering::order", "points that are none do not count", || {
        [f64::NAN, f64::INFINITY, 1e300].iter().all(|&x| {
            let mut order = ordering::order(&row(), &[[x; 3], [0.0; 3], [-x; 3]]).unwrap();
            order.sort_unstable();
            order == [0, 1, 2]
        })
    });
    for permutation in [vec![], vec![0, 1], vec![0, 1, 1], vec![0, 1, 3], vec![0, 1, -1]] {
        t.refuses("solver::ordering::factor_entries", "order of elimination", || {
            ordering::factor_entries(&row(), &permutation)
        });
    }
    t.gives("solver::Cost::corrections_to", "no end for a tolerance that is not positive", || {
        let cost = SolverKind::default().cost(&SystemSize::of_network(1000, 2));
        [f64::NAN, -1.0, 0.0].iter().all(|&x| cost.corrections_to(x) == u32::MAX)
            && cost.corrections_to(f64::INFINITY) == 1
    });
    t.gives("solver::Backend::cost", "a guess for any size", || {
        let cost = SolverKind::default().backend().cost(&SystemSize::of_network(0, 0));
        cost.is_some_and(|cost| cost.factorization == 0.0)
    });
    t.gives("solver::blas::set_threads", "no thread is none", || !blas::set_threads(0));
    t
}

fn matrices(t: &mut Table) {
    let from = "solver::SymmetricCsc::from_triplets";
    t.refuses(from, "lies outside", || SymmetricCsc::from_triplets(2, [(0, 2, 1.0)]));
    t.refuses(from, "lies outside", || SymmetricCsc::from_triplets(0, [(0, 0, 1.0)]));
    for value in [f64::NAN, f64::INFINITY] {
        t.refuses(from, "matrix entry", || SymmetricCsc::from_triplets(2, [(0, 1, value)]));
    }
    let twice = [(0, 0, f64::MAX), (0, 0, f64::MAX)];
    t.refuses(from, "matrix entry", || SymmetricCsc::from_triplets(1, twice));
    for n in [usize::MAX - 1, 1 << 60] {
        t.refuses(from, "out of memory", || SymmetricCsc::from_triplets(n, []));
    }
    let (multiply, residual) = ("solver::SymmetricCsc::multiply", "solver::SymmetricCsc::residual");
    for length in [0, 2, 4] {
        let other = vec![0.0; length];
        t.refuses(multiply, "to multiply", || row().multiply(&other, &mut [0.0; 3]));
        t.refuses(multiply, "product", || row().multiply(&[0.0; 3], &mut other.clone()));
        t.refuses(residual, "right-hand side", || row().residual(&other, &[0.0; 3]));
        t.refuses(residual, "to multiply", || row().residual(&[0.0; 3], &other));
    }
    for (word, a) in malformed() {
        t.refuses(multiply, word, || a.multiply(&[0.0; 3], &mut [0.0; 3]));
        t.refuses("solver::ordering::order", word, || ordering::order(&a, &[[0.0; 3]; 3]));
        t.refuses("solver::ordering::factor_entries", word, || {
            ordering::factor_entries(&a, &[0, 1, 2])
        });
        for kind in KINDS {
            t.refuses("solver::Backend::analyze", word, || kind.backend().analyze(&a, None));
        }
    }
    t.refuses(residual, "descend", || {
        SymmetricCsc { col_ptr: vec![0, 4, 2, 5], ..row() }.residual(&[0.0; 3], &[0.0; 3])
    });
    for kind in KINDS {
        for points in [vec![], vec![[0.0; 3]; 2], vec![[0.0; 3]; 4]] {
            t.refuses("solver::Backend::analyze", "coordinates", || {
                kind.backend().analyze(&row(), Some(&points))
            });
        }
        for value in [f64::NAN, f64::INFINITY] {
            t.refuses("solver::Factor::refactor", "matrix entry", || {
                let values = vec![value, -1.0, 2.0, -1.0, 2.0];
                factor(kind).refactor(&SymmetricCsc { values, ..row() })
            });
        }
        t.refuses("solver::Symbolic::factor", "another pattern", || {
            kind.backend().analyze(&row(), None)?.factor(&pair())
        });
        t.refuses("solver::Factor::refactor", "another pattern", || factor(kind).refactor(&pair()));
    }
}

fn factors(t: &mut Table, kind: SolverKind) {
    let (solve, many) = ("solver::Factor::solve", "solver::Factor::solve_many");
    for length in [0, 2, 4] {
        let other = vec![1.0; length];
        t.refuses(solve, "3 unknowns", || factor(kind).solve(&other, &mut [0.0; 3]));
        t.refuses(solve, "3 unknowns", || factor(kind).solve(&[1.0; 3], &mut other.clone()));
        t.refuses("solver::Factor::correct", "3 unknowns", || {
            factor(kind).correct(&other, &mut [0.0; 3])
        });
        t.refuses("solver::Factor::solve_checked", "3 unknowns", || {
            factor(kind).solve_checked(&row(), &other, &mut [0.0; 3])
        });
        t.refuses("solver::Factor::correct_checked", "3 unknowns", || {
            factor(kind).correct_checked(&row(), &[1.0; 3], &mut other.clone())
        });
    }
    t.refuses("solver::Factor::solve_checked", "2 unknowns", || {
        factor(kind).solve_checked(&pair(), &[1.0; 3], &mut [0.0; 3])
    });
    t.refuses("solver::Factor::correct_checked", "2 unknowns", || {
        factor(kind).correct_checked(&pair(), &[1.0; 3], &mut [0.0; 3])
    });
    for value in [f64::NAN, f64::INFINITY] {
        t.refuses(solve, "right-hand side", || {
            factor(kind).solve(&[1.0, value, 1.0], &mut [0.0; 3])
        });
        t.refuses(many, "right-hand side", || {
            factor(kind).solve_many(&[1.0, value, 1.0], &mut [0.0; 3], 1)
        });
    }
    for (b, x, columns) in [(6, 3, 2), (5, 5, 2), (6, 6, 3), (3, 3, 0), (6, 6, usize::MAX)] {
        t.refuses(many, "entries", || {
            factor(kind).solve_many(&vec![1.0; b], &mut vec![0.0; x], columns)
        });
    }
}

fn conditions(t: &mut Table, kind: SolverKind) {
    let (condition, error) = ("solver::condition_number", "solver::forward_error");
    let ones = [1.0; 3];
    t.refuses(condition, "3 unknowns", || condition_number(&mut *factor(kind), &pair()));
    t.refuses(error, "3 unknowns", || {
        forward_error(&mut *factor(kind), &pair(), &[1.0; 2], &[1.0; 2])
    });
    for (word, a) in malformed() {
        t.refuses(condition, word, || condition_number(&mut *factor(kind), &a));
        t.refuses(error, word, || forward_error(&mut *factor(kind), &a, &ones, &ones));
    }
    for length in [0, 2, 4] {
        let other = vec![1.0; length];
        t.refuses(error, "right-hand side", || {
            forward_error(&mut *factor(kind), &row(), &other, &ones)
        });
        t.refuses(error, "the solution", || {
            forward_error(&mut *factor(kind), &row(), &ones, &other)
        });
    }
    for value in [f64::NAN, f64::INFINITY] {
        t.refuses(error, "right-hand side", || {
            forward_error(&mut *factor(kind), &row(), &[1.0, value, 1.0], &ones)
        });
        t.gives(error, "infinite for a solution that is no number", || {
            let x = [1.0, value, 1.0];
            forward_error(&mut *factor(kind), &row(), &ones, &x) == Ok(f64::INFINITY)
        });
    }
}

fn gradients(t: &mut Table) {
    const SOLVE: &str = "solver::ConjugateGradients::solve";
    let run = |a: &SymmetricCsc, x: &mut [f64], residual: &mut [f64], goal: ErrorGoal| {
        let mut gradients = ConjugateGradients::default();
        gradients.solve(&mut &*a, &mut *factor(SolverKind::Cholmod), x, residual, &goal)
    };
    let goal = ErrorGoal { relative_error: 1e-9, ..ErrorGoal::default() };
    t.refuses(SOLVE, "the residual", || run(&row(), &mut [0.0; 3], &mut [0.0; 2], goal));
    t.refuses(SOLVE, "the solution", || run(&row(), &mut [0.0; 4], &mut [0.0; 3], goal));
    t.refuses(SOLVE, "right-hand side", || run(&row(), &mut [0.0; 3], &mut [f64::NAN; 3], goal));
    t.refuses(SOLVE, "the solution", || run(&row(), &mut [f64::NAN; 3], &mut [1.0; 3], goal));
    for bad in [
        ErrorGoal { relative_error: f64::NAN, ..goal },
        ErrorGoal { relative_error: -1.0, ..goal },
        ErrorGoal { datum: f64::INFINITY, ..goal },
        ErrorGoal { round_off: f64::NAN, ..goal },
    ] {
        t.refuses(SOLVE, "is no goal", || run(&row(), &mut [0.0; 3], &mut [1.0; 3], bad));
    }
    for (word, a) in malformed().into_iter().filter(|(_, a)| a.n == 3) {
        t.refuses(SOLVE, word, || run(&a, &mut [0.0; 3], &mut [1.0; 3], goal));
    }
}
