//! What an ordering fills in.

use super::super::SymmetricCsc;
use super::super::tree::{self, NONE};

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
    let rows = tree::rows(a, &place);
    let mut parent = vec![NONE; a.n];
    let mut seen = vec![NONE; a.n];
    let mut count = a.n as u64;
    for i in 0..a.n as u32 {
        seen[i as usize] = i;
        for &first in rows.of(i as usize) {
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
