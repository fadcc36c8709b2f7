//! What an ordering fills in.

use super::super::SymmetricCsc;

const NONE: u32 = u32::MAX;

/// Entries of the factor L of a matrix whose unknowns are eliminated in an order, the
/// diagonal included. Rows are followed along the elimination tree (Liu 1990): the time
/// is proportional to the result.
///
/// # Panics
/// If the matrix is malformed, or the order is no permutation of its unknowns.
pub fn factor_entries(a: &SymmetricCsc, permutation: &[i64]) -> u64 {
    assert_eq!(permutation.len(), a.n, "the order must have one entry per unknown");
    let mut place = vec![NONE; a.n];
    for (k, &v) in (0..).zip(permutation) {
        assert_eq!(place[v as usize], NONE, "unknown {v} must come once");
        place[v as usize] = k;
    }
    let (start, before) = rows(a, &place);
    let mut parent = vec![NONE; a.n];
    let mut seen = vec![NONE; a.n];
    let mut count = a.n as u64;
    for i in 0..a.n as u32 {
        seen[i as usize] = i;
        for &first in &before[start[i as usize]..start[i as usize + 1]] {
            let mut k = first as usize;
            while seen[k] != i {
                seen[k] = i;
                count += 1;
                if parent[k] == NONE {
                    parent[k] = i;
                }
                k = parent[k] as usize;
            }
        }
    }
    count
}

/// Of each row of the permuted matrix, the columns left of the diagonal.
fn rows(a: &SymmetricCsc, place: &[u32]) -> (Vec<usize>, Vec<u32>) {
    let pairs = || {
        (0..a.n).flat_map(|j| {
            let below = &a.row_idx[a.col_ptr[j] as usize + 1..a.col_ptr[j + 1] as usize];
            below.iter().map(move |&i| {
                let (p, q) = (place[i as usize], place[j]);
                (p.max(q) as usize, p.min(q))
            })
        })
    };
    let mut start = vec![0; a.n + 2];
    pairs().for_each(|(row, _)| start[row + 2] += 1);
    for row in 0..a.n {
        start[row + 2] += start[row + 1];
    }
    let mut before = vec![0; a.nnz() - a.n];
    for (row, column) in pairs() {
        before[start[row + 1]] = column;
        start[row + 1] += 1;
    }
    (start, before)
}
