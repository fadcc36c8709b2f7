//! Minimum degree for a small part: rows of bits, with what is around it.

use super::part::Part;

/// Writes the order of a part: always the vertex with the fewest neighbours among
/// those that are left and those around, the first of several. Exact, since every
/// elimination joins the neighbours at once.
pub(super) fn order(part: &Part, out: &mut [i64]) {
    let (n, all) = (part.len(), part.len() + part.halo());
    let words = all.div_ceil(64);
    let mut rows = vec![0u64; n * words];
    for v in 0..n {
        for &w in part.neighbors(v) {
            rows[v * words + w as usize / 64] |= 1 << (w % 64);
        }
    }
    let degree_of = |row: &[u64]| row.iter().map(|w| w.count_ones()).sum::<u32>();
    let mut degree: Vec<u32> = rows.chunks(words.max(1)).map(degree_of).collect();
    let mut left: Vec<u32> = (0..n as u32).collect();
    let mut pivot = vec![0u64; words];
    for place in out.iter_mut() {
        let Some(at) = (0..left.len()).min_by_key(|&k| (degree[left[k] as usize], left[k])) else {
            return;
        };
        let v = left.swap_remove(at) as usize;
        *place = i64::from(part.unknown(v));
        pivot.copy_from_slice(&rows[v * words..][..words]);
        for k in 0..words {
            let mut bits = pivot[k];
            while bits != 0 {
                let u = 64 * k + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                if u >= n {
                    break;
                }
                let row = &mut rows[u * words..][..words];
                for (own, other) in row.iter_mut().zip(&pivot) {
                    *own |= other;
                }
                row[u / 64] &= !(1 << (u % 64));
                row[v / 64] &= !(1 << (v % 64));
                degree[u] = degree_of(row);
            }
        }
    }
}
