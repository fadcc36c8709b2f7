//! Systems whose solutions are known.
#![allow(dead_code, reason = "not every test that shares this file needs all of it")]

use dempfv::solver::{Factor, SolverError, SolverKind, SymmetricCsc};

/// The seven-point Laplacian on an m x m x m grid with zero pressure around
/// it: 6 on the diagonal, -1 for each neighbour.
pub fn laplacian(m: usize) -> SymmetricCsc {
    bar(m, m)
}

/// The same on an m x m x l grid.
pub fn bar(m: usize, l: usize) -> SymmetricCsc {
    let mut a = SymmetricCsc { n: m * m * l, col_ptr: vec![0], ..Default::default() };
    for j in 0..a.n {
        let (x, y, z) = (j % m, j / m % m, j / (m * m));
        a.row_idx.push(j as i64);
        a.values.push(6.0);
        for (inside, stride) in [(x + 1 < m, 1), (y + 1 < m, m), (z + 1 < l, m * m)] {
            if inside {
                a.row_idx.push((j + stride) as i64);
                a.values.push(-1.0);
            }
        }
        a.col_ptr.push(a.row_idx.len() as i64);
    }
    a
}

/// The same pattern with conductances over nine decades, as pores have them:
/// the row sums vanish but for a small leak from each unknown.
pub fn network(m: usize, seed: u64) -> SymmetricCsc {
    with_conductances(laplacian(m), seed)
}

/// Conductances as those of [`network`] in a pattern.
pub fn with_conductances(mut a: SymmetricCsc, seed: u64) -> SymmetricCsc {
    let exponents = numbers(a.nnz(), seed);
    let mut diagonal = vec![1e-12; a.n];
    for j in 0..a.n {
        for k in a.col_ptr[j] as usize + 1..a.col_ptr[j + 1] as usize {
            let g = 10f64.powf(-7.0 + 4.5 * exponents[k]);
            a.values[k] = -g;
            diagonal[j] += g;
            diagonal[a.row_idx[k] as usize] += g;
        }
    }
    for (&start, value) in a.col_ptr.iter().zip(diagonal) {
        a.values[start as usize] = value;
    }
    a
}

/// Numbers in (-1, 1) that are the same everywhere (xorshift64).
pub fn numbers(n: usize, seed: u64) -> Vec<f64> {
    let mut s = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let next = |_| {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        (s >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(next).collect()
}

/// Analyzes and factors with CHOLMOD.
pub fn factor(a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
    SolverKind::Cholmod.backend().analyze(a, None)?.factor(a)
}

/// The solution for one right-hand side, as bits.
pub fn solution_bits(factor: &mut dyn Factor, b: &[f64]) -> Vec<u64> {
    let mut x = vec![0.0; b.len()];
    factor.solve(b, &mut x).unwrap();
    x.into_iter().map(f64::to_bits).collect()
}
