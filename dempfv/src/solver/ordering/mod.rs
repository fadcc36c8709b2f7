//! A fill-reducing ordering for networks whose unknowns have coordinates.
//!
//! Nested dissection by minimum cuts: a part is cut across its longest side by
//! the smallest set of vertices that separates its first from its last, found as
//! a maximum flow inside a band around the median (Schild and Sommer 2015 cut
//! road networks so). What lies apart is ordered apart, then the separator. Small
//! parts are ordered by minimum degree, counting also what is ordered later.
//!
//! The same ordering for any number of threads, and no random numbers.

mod cut;
mod degree;
mod part;

use super::SymmetricCsc;
use part::Part;

/// Parts of no more vertices than this are not cut.
const LEAF: usize = 256;

/// Parts of fewer vertices than this are not worth another thread.
const ALONE: usize = 4096;

/// Orders the unknowns of a matrix by the pattern and one point each (any unit):
/// entry k of the result is the unknown that is eliminated as the k-th.
pub fn order(a: &SymmetricCsc, points: &[[f64; 3]]) -> Vec<i64> {
    let part = Part::whole(a, points);
    let mut permutation = vec![0; a.n];
    dissect(part, &mut permutation);
    permutation
}

/// Writes the order of a part: both sides of a cut, then the cut.
fn dissect(part: Part, out: &mut [i64]) {
    let cut = (part.len() > LEAF).then(|| cut::separate(&part)).flatten();
    let Some(sides) = cut else {
        degree::order(&part, out);
        return;
    };
    let (left, right, separator) = part.split(&sides);
    let (own, last) = out.split_at_mut(left.own() + right.own());
    let (first, second) = own.split_at_mut(left.own());
    for (place, unknown) in last.iter_mut().zip(separator) {
        *place = i64::from(unknown);
    }
    let alone = part.len() < ALONE;
    drop(part);
    if alone {
        dissect(left, first);
        dissect(right, second);
    } else {
        rayon::join(|| dissect(left, first), || dissect(right, second));
    }
}
