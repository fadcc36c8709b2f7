//! The elimination tree of a pattern and the number of entries in each column
//! of the factor (Liu 1990; Gilbert, Ng and Peyton 1994).

use super::SymmetricCsc;

/// No number.
pub const NONE: u32 = u32::MAX;

/// Lists of numbers, one after the other.
pub struct Lists {
    /// Where each list starts; one more than there are lists.
    pub start: Vec<u32>,
    /// The lists.
    pub items: Vec<u32>,
}

impl Lists {
    /// The list of a number.
    pub fn of(&self, k: usize) -> &[u32] {
        &self.items[self.start[k] as usize..self.start[k + 1] as usize]
    }
}

/// Off-diagonal entries of a matrix whose rows and columns change places:
/// entry (i, j), i > j, of the permuted matrix.
fn off_diagonal<'a>(
    a: &'a SymmetricCsc,
    place: &'a [u32],
) -> impl Iterator<Item = (u32, u32, u32)> + 'a {
    (0..a.n).flat_map(move |column| {
        let range = a.col_ptr[column] as usize + 1..a.col_ptr[column + 1] as usize;
        let j = place[column];
        range.map(move |k| {
            let i = place[a.row_idx[k] as usize];
            (i.max(j), i.min(j), k as u32)
        })
    })
}

/// Groups the off-diagonal entries: `key` picks the list, `item` what it holds.
fn grouped<const N: usize>(
    a: &SymmetricCsc,
    place: &[u32],
    key: impl Fn((u32, u32, u32)) -> u32,
    item: impl Fn((u32, u32, u32)) -> [u32; N],
) -> (Vec<u32>, [Vec<u32>; N]) {
    let mut start = vec![0u32; a.n + 1];
    off_diagonal(a, place).for_each(|e| start[key(e) as usize + 1] += 1);
    for k in 0..a.n {
        start[k + 1] += start[k];
    }
    let mut next = start.clone();
    let mut lists = [(); N].map(|()| vec![0; a.nnz() - a.n]);
    off_diagonal(a, place).for_each(|e| {
        let at = &mut next[key(e) as usize];
        for (list, v) in lists.iter_mut().zip(item(e)) {
            list[*at as usize] = v;
        }
        *at += 1;
    });
    (start, lists)
}

/// The columns before each row that have an entry in it.
pub fn rows(a: &SymmetricCsc, place: &[u32]) -> Lists {
    let (start, [items]) = grouped(a, place, |e| e.0, |e| [e.1]);
    Lists { start, items }
}

/// The rows below the diagonal of each column, and which entry of the matrix
/// each one is.
pub fn columns(a: &SymmetricCsc, place: &[u32]) -> (Lists, Vec<u32>) {
    let (start, [items, source]) = grouped(a, place, |e| e.1, |e| [e.0, e.2]);
    (Lists { start, items }, source)
}

/// The parent of each column in the elimination tree; [`NONE`] at a root.
pub fn parents(rows: &Lists, n: usize) -> Vec<u32> {
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for i in 0..n as u32 {
        for &k in rows.of(i as usize) {
            let mut k = k;
            while k != i {
                let next = std::mem::replace(&mut ancestor[k as usize], i);
                if next == NONE {
                    parent[k as usize] = i;
                    break;
                }
                k = next;
            }
        }
    }
    parent
}

/// The children of each node, ascending.
pub fn children(parent: &[u32]) -> Lists {
    let n = parent.len();
    let mut start = vec![0u32; n + 1];
    parent.iter().filter(|p| **p != NONE).for_each(|&p| start[p as usize + 1] += 1);
    for k in 0..n {
        start[k + 1] += start[k];
    }
    let mut next = start.clone();
    let mut items = vec![0; start[n] as usize];
    for (k, &p) in parent.iter().enumerate().filter(|(_, p)| **p != NONE) {
        items[next[p as usize] as usize] = k as u32;
        next[p as usize] += 1;
    }
    Lists { start, items }
}

/// The nodes of a forest, children before parents and each subtree together.
pub fn postorder(parent: &[u32]) -> Vec<u32> {
    let children = children(parent);
    let mut order = Vec::with_capacity(parent.len());
    let mut stack: Vec<(u32, u32)> = vec![];
    for root in (0..parent.len() as u32).filter(|&k| parent[k as usize] == NONE) {
        stack.push((root, 0));
        while let Some((node, seen)) = stack.last_mut() {
            match children.of(*node as usize).get(*seen as usize) {
                Some(&child) => {
                    *seen += 1;
                    stack.push((child, 0));
                }
                None => {
                    order.push(*node);
                    stack.pop();
                }
            }
        }
    }
    order
}

/// Entries of each column of the factor, the diagonal included, for columns in
/// postorder.
pub fn counts(columns: &Lists, parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut first: Vec<u32> = (0..n as u32).collect();
    let mut delta = vec![1i64; n];
    for k in 0..n {
        if parent[k] != NONE {
            let p = parent[k] as usize;
            first[p] = first[p].min(first[k]);
            // A column with children starts from theirs.
            delta[p] = 0;
        }
    }
    let mut ancestor: Vec<u32> = (0..n as u32).collect();
    let mut last_leaf = vec![NONE; n];
    // One more than the first descendant of the last leaf of each row.
    let mut reached = vec![0u32; n];
    for j in 0..n {
        if parent[j] != NONE {
            delta[parent[j] as usize] -= 1;
        }
        for &i in columns.of(j) {
            let i = i as usize;
            if first[j] < reached[i] {
                continue;
            }
            delta[j] += 1;
            if last_leaf[i] != NONE {
                delta[root_of(&mut ancestor, last_leaf[i]) as usize] -= 1;
            }
            last_leaf[i] = j as u32;
            reached[i] = first[j] + 1;
        }
        if parent[j] != NONE {
            ancestor[j] = parent[j];
        }
    }
    for k in 0..n {
        if parent[k] != NONE {
            delta[parent[k] as usize] += delta[k];
        }
    }
    delta.into_iter().map(|d| d as u32).collect()
}

/// The root of a node's set, which it shortens the way to.
fn root_of(ancestor: &mut [u32], node: u32) -> u32 {
    let mut root = node;
    while ancestor[root as usize] != root {
        root = ancestor[root as usize];
    }
    let mut k = node;
    while k != root {
        k = std::mem::replace(&mut ancestor[k as usize], root);
    }
    root
}
