//! How many entries an ordering fills in.

use super::super::elimination_tree::{self as tree, NONE};
use super::super::{SolverError, SymmetricCsc, require_size};

/// Entries of the factor L of a matrix whose unknowns are eliminated in an order, the
/// diagonal included. Rows are followed along the elimination tree (Liu 1990): the time
/// is proportional to the result.
///
/// # Errors
/// The matrix is malformed ([`SymmetricCsc::validate`]; its values do not matter), or the
/// order is no permutation of its unknowns, or the matrix has over 2³¹ entries, which are not
/// counted.
pub fn factor_entries(a: &SymmetricCsc, permutation: &[i64]) -> Result<u64, SolverError> {
    a.validate_pattern()?;
    require_size("the order of elimination", a.n, permutation.len())?;
    if !a.counts_in_32_bits() {
        return Err(SolverError::TooLarge { solver: "the ordering", n: a.n });
    }
    let mut place = vec![NONE; a.n];
    for (k, &unknown) in permutation.iter().enumerate() {
        let free = usize::try_from(unknown).ok().and_then(|v| place.get_mut(v));
        match free {
            Some(place) if *place == NONE => *place = k as u32,
            _ => return Err(SolverError::NoPermutation { place: k, unknown }),
        }
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
    Ok(count)
}
