//! A fill-reducing ordering for networks whose unknowns have coordinates.
//!
//! Nested dissection (George 1973) by minimum cuts: a part is cut across its longest side by
//! the smallest set of vertices that separates its first from its last, found as
//! a maximum flow inside a band around the median (Schild and Sommer 2015 cut
//! road networks so). What lies apart is ordered apart, then the separator. Small
//! parts are ordered by minimum degree, counting also what is ordered later.
//!
//! The same ordering for any number of threads, and no random numbers.

mod band;
mod dissection;
mod fill;
mod graph;
mod max_flow;
mod minimum_degree;

use super::{SolverError, SymmetricCsc, require_size};
use dissection::Dissection;
pub use fill::factor_entries;
use graph::Graph;

/// Parts of no more vertices than this are ordered by one thread, in place.
const SERIAL_VERTICES: usize = 8192;

/// Orders the unknowns of a matrix by its pattern and one point each (any unit):
/// entry k of the result is the unknown that is eliminated as the k-th.
///
/// The points only decide where a part is cut. Where they do not help (all in one
/// place, or no numbers), distances in the graph take their place.
///
/// ```
/// use dempfv::solver::{SymmetricCsc, ordering};
/// // Three pores in a row.
/// let a = SymmetricCsc {
///     n: 3,
///     col_ptr: vec![0, 2, 4, 5],
///     row_idx: vec![0, 1, 1, 2, 2],
///     values: vec![2.0, -1.0, 2.0, -1.0, 2.0],
/// };
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
/// // An end first: it fills nothing in.
/// assert_eq!(ordering::order(&a, &points)?, [0, 1, 2]);
/// # Ok::<(), dempfv::solver::SolverError>(())
/// ```
///
/// # Errors
/// The matrix is malformed ([`SymmetricCsc::validate`]; its values do not matter), or the
/// points are not one per unknown, or the matrix has over 2³¹ entries, which 32 bits do not count.
pub fn order(a: &SymmetricCsc, points: &[[f64; 3]]) -> Result<Vec<i64>, SolverError> {
    a.validate_pattern()?;
    if !a.counts_in_32_bits() {
        return Err(SolverError::TooLarge { solver: "the ordering", n: a.n });
    }
    require_size("the list of coordinates", a.n, points.len())?;
    Ok(minimum_cuts(a, points))
}

/// [`order`] for a matrix that has been validated and whose entries 32 bits count, with one point per unknown.
pub(super) fn minimum_cuts(a: &SymmetricCsc, points: &[[f64; 3]]) -> Vec<i64> {
    let graph = Graph::whole(a, points);
    let mut permutation = vec![0; graph.len()];
    dissect(graph, &mut permutation);
    permutation
}

/// Writes the order of a part: both sides of a cut, then the cut.
fn dissect(graph: Graph, out: &mut [i64]) {
    let mut dissection = Dissection::new(graph);
    let cut = if out.len() > SERIAL_VERTICES { dissection.cut_whole(out) } else { None };
    let Some((left, right)) = cut else {
        dissection.order(out);
        return;
    };
    let (first, rest) = out.split_at_mut(left.len());
    let second = &mut rest[..right.len()];
    let (left, right) = rayon::join(|| dissection.extract(&left), || dissection.extract(&right));
    drop(dissection);
    rayon::join(|| dissect(left, first), || dissect(right, second));
}
