//! The ordering by minimum cuts: always a permutation, the same for any number of
//! threads, and with less fill than METIS on the packings that come along.

use std::path::Path;

use dempfv::WallId;
use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Clamp, Fluid, Network, Operators};
use dempfv::solver::ordering::{factor_entries, order};
use dempfv::solver::{SolverError, SolverKind, SymmetricCsc};

type Points = Vec<[f64; 3]>;

/// A pattern from its edges.
fn pattern(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> SymmetricCsc {
    let mut below = vec![std::collections::BTreeSet::new(); n];
    for (v, w) in edges {
        below[v.min(w)].insert(v.max(w) as i64);
    }
    let mut a = SymmetricCsc { n, col_ptr: vec![0], ..SymmetricCsc::default() };
    for (j, rows) in below.iter().enumerate() {
        a.row_idx.push(j as i64);
        a.row_idx.extend(rows);
        a.values.push(8.0);
        a.values.resize(a.row_idx.len(), -1.0);
        a.col_ptr.push(a.row_idx.len() as i64);
    }
    a.validate().unwrap();
    a
}

/// An m x m x l grid.
fn grid(m: usize, l: usize) -> (SymmetricCsc, Points) {
    let place = |v: usize| [v % m, v / m % m, v / (m * m)];
    let n = m * m * l;
    let edges = (0..n).flat_map(move |v| {
        let [x, y, z] = place(v);
        let steps = [(x + 1 < m, 1), (y + 1 < m, m), (z + 1 < l, m * m)];
        steps.into_iter().filter(|s| s.0).map(move |s| (v, v + s.1))
    });
    (pattern(n, edges), (0..n).map(|v| place(v).map(|x| x as f64)).collect())
}

/// Numbers that look random, the same every time (xorshift, Marsaglia 2003).
fn random(mut state: u64) -> impl FnMut() -> usize {
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 33) as usize
    }
}

fn ordered(a: &SymmetricCsc, points: &[[f64; 3]]) -> u64 {
    factor_entries(a, &order(a, points).unwrap()).unwrap()
}

/// The matrix of a packing that is drained at the top, and its pores' centres.
fn packing(count: usize) -> (SymmetricCsc, Points) {
    let name = format!("../packings/oedometer-{count}.txt");
    let packing = Packing::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let bounds = packing.bounds_or_tight().unwrap();
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let (network, derivatives) =
        Network::new(&packing.position, &packing.radius, bounds, &fluid).unwrap();
    let operators = Operators::new(&network, derivatives, fluid.boundary).unwrap();
    let center = |&i: &u32| network.center[i as usize].into();
    let points = operators.pore_of.iter().map(center).collect();
    (operators.matrix, points)
}

/// What CHOLMOD finds for METIS's ordering.
fn metis(a: &SymmetricCsc) -> u64 {
    let symbolic = SolverKind::Cholmod.backend().analyze(a, None).unwrap();
    assert_eq!(symbolic.analysis().ordering, "metis");
    symbolic.analysis().nnz_l
}

/// The count is CHOLMOD's, which orders by the coordinates if there are any.
#[test]
fn cholmod_takes_the_order() {
    for (a, points) in [grid(9, 30), packing(5_000)] {
        let symbolic = SolverKind::Cholmod.backend().analyze(&a, Some(&points)).unwrap();
        let analysis = symbolic.analysis();
        assert_eq!(analysis.ordering, "minimum cuts");
        assert_eq!(analysis.nnz_l, ordered(&a, &points));
        let mut factor = symbolic.factor(&a).unwrap();
        let b: Vec<f64> = (0..a.n).map(|k| (k % 7) as f64).collect();
        factor.solve_checked(&a, &b, &mut vec![0.0; a.n]).unwrap();
    }
}

/// No more fill than METIS leaves: 0.945 and 0.958 of it here.
#[test]
fn packings_have_less_fill_than_by_metis() {
    for count in [5_000, 20_000] {
        let (a, points) = packing(count);
        let (own, other) = (ordered(&a, &points), metis(&a));
        assert!(own as f64 <= 0.98 * other as f64, "{count}: {own}, METIS {other}");
    }
}

/// A regular grid has many equal coordinates, and cuts that are as small as others.
/// The smallest of all run aslant (three quarters of a layer), and METIS finds them;
/// ours run along the layers.
#[test]
fn grids_have_at_most_twice_the_fill_of_metis() {
    for (m, l) in [(20, 20), (12, 60), (5, 5)] {
        let (a, points) = grid(m, l);
        let (own, other) = (ordered(&a, &points), metis(&a));
        assert!(own <= 2 * other, "{m} {l}: {own}, METIS {other}");
    }
}

/// Points that tell nothing: all equal, all on one line across the graph, no numbers.
/// Distances in the graph stand in.
#[test]
fn useless_points_are_overcome() {
    let (a, good) = grid(16, 24);
    let best = ordered(&a, &good);
    let line = |v: usize| [0.0, 1e300 * (v as f64), 0.0];
    for points in [
        vec![[7.0; 3]; a.n],
        vec![[f64::NAN; 3]; a.n],
        (0..a.n).map(line).collect::<Points>(),
        (0..a.n).map(|v| [0.0, 0.0, if v % 1000 == 0 { f64::INFINITY } else { 0.0 }]).collect(),
    ] {
        let own = ordered(&a, &points);
        assert!(own as f64 <= 1.5 * best as f64, "{own}, with points {best}");
    }
}

/// Points that mislead, on graphs of any kind: still a permutation.
#[test]
fn random_graphs_get_permutations() {
    let mut next = random(1);
    for (n, edges) in [(0, 0), (1, 0), (2, 1), (300, 0), (3000, 2500), (3000, 6000), (700, 90_000)]
    {
        let list: Vec<_> =
            (0..edges).map(|_| (next() % n, next() % n)).filter(|e| e.0 != e.1).collect();
        let a = pattern(n, list);
        let points: Points = (0..n).map(|_| [0; 3].map(|_| (next() % 1000) as f64)).collect();
        ordered(&a, &points);
    }
}

/// A hub with many neighbours comes last or nearly so; a complete graph has but one
/// count; parts that are not connected do not fill each other.
#[test]
fn special_graphs() {
    let n = 5000;
    let points: Points = (0..n).map(|v| [v as f64, 0.0, 0.0]).collect();
    assert_eq!(ordered(&pattern(n, (1..n).map(|v| (0, v))), &points), 2 * n as u64 - 1);
    // From one end to the other it would be 2 n - 1; with separators, each vertex may
    // have one on either side.
    assert!(ordered(&pattern(n, (1..n).map(|v| (v - 1, v))), &points) < 3 * n as u64);
    assert_eq!(ordered(&pattern(n, []), &points), n as u64);
    let m = 600;
    let complete = (0..m).flat_map(|v| (0..v).map(move |w| (v, w)));
    assert_eq!(ordered(&pattern(m, complete), &points[..m]), (m * (m + 1) / 2) as u64);
    let pairs = (0..n / 2).map(|v| (v, v + n / 2));
    assert_eq!(ordered(&pattern(n, pairs), &points), (n + n / 2) as u64);
}

/// The bits of everything that follows depend on the order.
#[test]
fn the_order_does_not_depend_on_threads() {
    let (a, points) = packing(20_000);
    let by = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| order(&a, &points))
    };
    let one = by(1);
    assert!(one == by(2) && one == by(3));
}

/// Wrong lengths and orders that are none are told, not panicked about.
#[test]
fn wrong_input_is_an_error() {
    let (a, points) = grid(3, 3);
    let wrong = |what, found| SolverError::WrongSize { what, expected: 27, found };
    assert_eq!(order(&a, &points[1..]), Err(wrong("the list of coordinates", 26)));
    let good = order(&a, &points).unwrap();
    assert_eq!(factor_entries(&a, &good[..9]), Err(wrong("the order of elimination", 9)));
    for unknown in [-1, 27, good[3]] {
        let mut bad = good.clone();
        bad[5] = unknown;
        let expected = SolverError::NoPermutation { place: 5, unknown };
        assert_eq!(factor_entries(&a, &bad), Err(expected));
    }
    let mut malformed = a.clone();
    malformed.row_idx[1] = 99;
    assert!(matches!(order(&malformed, &points), Err(SolverError::InvalidMatrix { .. })));
    let mut no_numbers = a;
    no_numbers.values.fill(f64::NAN);
    assert_eq!(order(&no_numbers, &points), Ok(good));
}
