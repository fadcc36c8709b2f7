//! The symbolic factorization: supernodes, the row structure of their fronts and the relative indices
//! of these in their parents' (George and Liu 1981; Liu 1992), and where each entry of the matrix
//! goes.

use rayon::prelude::*;

use super::shape::Shape;
use super::supernodes::Supernodes;
use crate::solver::SymmetricCsc;
use crate::solver::elimination_tree::{self as tree, Lists, NONE};

/// The pattern of the factor, and the plan of the factorization.
pub struct Pattern {
    pub n: usize,
    /// The unknown that is eliminated as the k-th.
    pub order: Vec<u32>,
    /// When each unknown is eliminated.
    pub place: Vec<u32>,
    /// First column of each supernode, and n.
    pub first: Vec<u32>,
    /// Parent of each supernode; [`NONE`] at a root.
    pub parent: Vec<u32>,
    /// Children of each supernode.
    pub children: Lists,
    /// Rows of each supernode's front below its own columns.
    pub rows: FrontRows,
    /// The same as rows of the parent's front.
    pub map: Vec<u32>,
    /// Where the entries of each supernode start in the factor, and their number.
    pub start: Vec<usize>,
    /// Entries of the matrix in each supernode: which one, and where it goes
    /// within the supernode.
    pub entries: MatrixEntries,
    /// Entries of the factor without the zeros of supernodes.
    pub nnz_l: u64,
    /// Operations of a factorization without those zeros.
    pub flops: f64,
}

/// Lists of rows by supernode.
pub struct FrontRows {
    pub start: Vec<usize>,
    pub items: Vec<u32>,
}

/// Entries of the matrix by supernode.
pub struct MatrixEntries {
    /// By column, from which the supernodes' follow.
    pub column_start: Vec<u32>,
    pub source: Vec<u32>,
    pub target: Vec<u32>,
}

impl Pattern {
    /// Analyzes a pattern for the order of elimination. None where a front has more entries than
    /// [`MatrixEntries::target`] can tell apart.
    pub fn new(a: &SymmetricCsc, order: Vec<u32>) -> Option<Pattern> {
        let n = a.n;
        let place = inverse(&order);
        let parent = tree::parents(&tree::rows(a, &place), n);
        let post = tree::postorder(&parent);
        let order: Vec<u32> = post.iter().map(|&k| order[k as usize]).collect();
        let place = inverse(&order);
        let parent = relabelled(&parent, &post);

        let counts = tree::counts(&tree::columns(a, &place).0, &parent);
        let nnz_l = counts.iter().map(|&c| u64::from(c)).sum();
        let flops = counts.iter().map(|&c| f64::from(c) * f64::from(c)).sum();
        let Supernodes { first, parent: front_parent, border, columns } =
            Supernodes::new(&parent, &counts);
        let order: Vec<u32> = columns.iter().map(|&k| order[k as usize]).collect();
        let place = inverse(&order);
        let count = front_parent.len();
        let mut owner = vec![0u32; n];
        for s in 0..count {
            owner[first[s] as usize..first[s + 1] as usize].fill(s as u32);
        }
        let (columns, source) = tree::columns(a, &place);
        let rows = front_rows(&tree::rows(a, &place), &border, &front_parent, &owner);
        let shape = |s: usize| Shape {
            width: (first[s + 1] - first[s]) as usize,
            border: rows.start[s + 1] - rows.start[s],
        };
        let mut start = vec![0; count + 1];
        for s in 0..count {
            u32::try_from(shape(s).len()).ok()?;
            start[s + 1] = start[s] + shape(s).len();
        }
        let target = targets(&columns, &first, &owner, &rows, &shape);
        let map = relative_rows(&first, &front_parent, &rows);
        let entries = MatrixEntries { column_start: columns.start, source, target };
        let children = tree::children(&front_parent);
        Some(Pattern {
            n,
            order,
            place,
            first,
            parent: front_parent,
            children,
            rows,
            map,
            start,
            entries,
            nnz_l,
            flops,
        })
    }

    /// Number of supernodes.
    pub fn supernodes(&self) -> usize {
        self.parent.len()
    }

    pub fn shape(&self, s: usize) -> Shape {
        Shape {
            width: (self.first[s + 1] - self.first[s]) as usize,
            border: self.rows.start[s + 1] - self.rows.start[s],
        }
    }

    /// Rows of the parent's front that a supernode's border goes to.
    pub fn relative_indices(&self, s: usize) -> &[u32] {
        &self.map[self.rows.start[s]..self.rows.start[s + 1]]
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let words = self.order.len()
            + self.place.len()
            + self.first.len()
            + 2 * self.parent.len()
            + self.children.start.len()
            + self.rows.items.len()
            + self.map.len()
            + self.entries.column_start.len()
            + 2 * self.entries.source.len();
        4 * words + 8 * (self.start.len() + self.rows.start.len())
    }
}

fn inverse(order: &[u32]) -> Vec<u32> {
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(k, &unknown)| place[unknown as usize] = k as u32);
    place
}

fn relabelled(parent: &[u32], post: &[u32]) -> Vec<u32> {
    let new = inverse(post);
    post.iter()
        .map(|&k| match parent[k as usize] {
            NONE => NONE,
            p => new[p as usize],
        })
        .collect()
}

/// The rows of each front below its columns, ascending: row by row, each climbs
/// from the columns that have it in the matrix.
fn front_rows(
    matrix_rows: &Lists,
    border: &[u32],
    front_parent: &[u32],
    owner: &[u32],
) -> FrontRows {
    let supernodes = front_parent.len();
    let mut start = vec![0usize; supernodes + 1];
    for s in 0..supernodes {
        start[s + 1] = start[s] + border[s] as usize;
    }
    let mut next = start.clone();
    let mut items = vec![0u32; start[supernodes]];
    let mut reached = vec![NONE; supernodes];
    for i in 0..owner.len() as u32 {
        let end = owner[i as usize];
        for &k in matrix_rows.of(i as usize) {
            let mut s = owner[k as usize];
            while s != end && reached[s as usize] != i {
                reached[s as usize] = i;
                items[next[s as usize]] = i;
                next[s as usize] += 1;
                s = front_parent[s as usize];
            }
        }
    }
    FrontRows { start, items }
}

/// Where each entry of the matrix goes within its supernode.
fn targets(
    columns: &Lists,
    first: &[u32],
    owner: &[u32],
    rows: &FrontRows,
    shape: &(impl Fn(usize) -> Shape + Sync),
) -> Vec<u32> {
    let mut target = vec![0u32; columns.items.len()];
    let mut parts = Vec::with_capacity(first.len());
    let mut rest = target.as_mut_slice();
    for s in 0..first.len() - 1 {
        let entries = columns.start[first[s + 1] as usize] - columns.start[first[s] as usize];
        let (part, after) = rest.split_at_mut(entries as usize);
        parts.push(part);
        rest = after;
    }
    parts.par_iter_mut().with_min_len(256).enumerate().for_each(|(s, part)| {
        let shape = shape(s);
        let border = &rows.items[rows.start[s]..rows.start[s + 1]];
        let mut out = part.iter_mut();
        for column in first[s]..first[s + 1] {
            for &row in columns.of(column as usize) {
                let local = if owner[row as usize] as usize == s {
                    (row - first[s]) as usize
                } else {
                    shape.width + border.partition_point(|&r| r < row)
                };
                if let Some(target) = out.next() {
                    *target = shape.index(local, (column - first[s]) as usize) as u32;
                }
            }
        }
    });
    target
}

/// Where the rows of each front lie in its parent's front.
fn relative_rows(first: &[u32], front_parent: &[u32], rows: &FrontRows) -> Vec<u32> {
    let mut map = vec![0u32; rows.items.len()];
    let mut parts = Vec::with_capacity(front_parent.len());
    let mut rest = map.as_mut_slice();
    for s in 0..front_parent.len() {
        let (part, after) = rest.split_at_mut(rows.start[s + 1] - rows.start[s]);
        parts.push(part);
        rest = after;
    }
    parts.par_iter_mut().with_min_len(256).enumerate().for_each(|(s, part)| {
        if front_parent[s] == NONE {
            return;
        }
        let p = front_parent[s] as usize;
        let width = first[p + 1] - first[p];
        let border = &rows.items[rows.start[p]..rows.start[p + 1]];
        let mut k = 0;
        for (at, &row) in part.iter_mut().zip(&rows.items[rows.start[s]..rows.start[s + 1]]) {
            *at = if row < first[p + 1] {
                row - first[p]
            } else {
                while border[k] != row {
                    k += 1;
                }
                width + k as u32
            };
        }
    });
    map
}

#[cfg(test)]
mod tests {
    use super::super::packed::FactorLayout;
    use super::*;

    /// One unknown that is joined to all others, which are joined to nothing else.
    fn hub(n: usize) -> SymmetricCsc {
        let joined = (1..n).flat_map(|k| [(k, k, 1.0), (k, 0, -1.0)]);
        SymmetricCsc::from_triplets(n, joined.chain([(0, 0, n as f64)])).unwrap()
    }

    /// The hub first: then all of L fills in, n (n + 1) / 2 entries.
    fn filled(n: u32) -> Option<Pattern> {
        Pattern::new(&hub(n as usize), (0..n).collect())
    }

    /// 2.45e9 entries of L, more than 2³¹, in one front.
    #[test]
    fn factors_beyond_31_bits_are_counted() {
        let n = 70_000;
        let pattern = filled(n).unwrap();
        let entries = u64::from(n) * u64::from(n + 1) / 2;
        assert_eq!((pattern.supernodes(), pattern.nnz_l), (1, entries));
        assert!(pattern.start[1] as u64 > entries);
        // Two entries a word, rounded up to whole blocks of rows.
        let words = FactorLayout::new(&pattern).end().words as u64;
        assert!(words > entries / 2 - 16 * u64::from(n) && words < entries, "{words}");
        // The last entry of the hub's column lies in the last tile of the first panel.
        let last = pattern.shape(0).index(n as usize - 1, 0);
        assert!(pattern.entries.target.contains(&u32::try_from(last).unwrap()));
    }

    /// 93,000 columns in one front are 4.3e9 entries, more than 2³²: places in it would start again
    /// from zero. The same pattern with the hub last fills nothing in.
    #[test]
    fn a_front_beyond_32_bits_is_refused() {
        let n = 93_000;
        assert!(filled(n).is_none());
        let sparse = Pattern::new(&hub(n as usize), (0..n).rev().collect()).unwrap();
        assert_eq!(sparse.nnz_l, 2 * u64::from(n) - 1);
    }
}
