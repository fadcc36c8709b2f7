//! Which columns share a front.

use crate::solver::tree::{self, NONE};

/// A front costs as much time as so many entries, whatever it holds: no more
/// zeros than this are a good price for one front less.
const PRICE: usize = 130;

/// Larger fronts are merged where zeros are no more than this share.
const SHARE: f64 = 0.04;

/// Groups of columns that are eliminated in one front.
pub struct Supernodes {
    /// First column of each, in the new order, and the number of columns.
    pub first: Vec<u32>,
    /// Parent of each; [`NONE`] at a root.
    pub above: Vec<u32>,
    /// Rows of each front below its columns.
    pub edge: Vec<u32>,
    /// The columns in their new order: a supernode's are made to follow each
    /// other.
    pub columns: Vec<u32>,
}

/// A supernode in the making, by its last member.
#[derive(Clone, Copy)]
struct Group {
    width: usize,
    edge: usize,
    zeros: usize,
}

impl Group {
    /// Entries of the lower trapezoid.
    fn entries(self) -> usize {
        self.width * (self.width + 1) / 2 + self.width * self.edge
    }

    /// The group that a child forms with this one.
    fn with(self, child: Group) -> Group {
        let zeros = child.width * (self.width + self.edge - child.edge);
        Group {
            width: self.width + child.width,
            edge: self.edge,
            zeros: self.zeros + child.zeros + zeros,
        }
    }
}

impl Supernodes {
    /// From the elimination tree of columns in postorder, and the number of
    /// entries of each column of the factor.
    pub fn new(parent: &[u32], counts: &[u32]) -> Supernodes {
        let n = parent.len();
        // Columns of one pattern.
        let starts =
            |j: usize| j == 0 || parent[j - 1] as usize != j || counts[j - 1] != counts[j] + 1;
        let mut first: Vec<usize> = (0..n).filter(|&j| starts(j)).collect();
        first.push(n);
        let count = first.len() - 1;
        let mut owner = vec![0u32; n];
        for s in 0..count {
            owner[first[s]..first[s + 1]].fill(s as u32);
        }
        let above: Vec<u32> = (0..count)
            .map(|s| match parent[first[s + 1] - 1] {
                NONE => NONE,
                column => owner[column as usize],
            })
            .collect();
        let mut groups: Vec<Group> = (0..count)
            .map(|s| Group {
                width: first[s + 1] - first[s],
                edge: counts[first[s + 1] - 1] as usize - 1,
                zeros: 0,
            })
            .collect();
        let into = merge(&above, &mut groups);
        collect(&first, &above, &groups, &into)
    }
}

/// Merges supernodes with their parents, children first; returns the supernode
/// that each one goes into, itself if it stays.
fn merge(above: &[u32], groups: &mut [Group]) -> Vec<u32> {
    let children = tree::children(above);
    let mut into: Vec<u32> = (0..above.len() as u32).collect();
    let mut candidates: Vec<u32> = vec![];
    for p in 0..above.len() {
        candidates.clear();
        candidates.extend(children.of(p));
        // Those that lack least of the parent's rows first.
        candidates.sort_by_key(|&c| {
            let c = groups[c as usize];
            c.width * (groups[p].width + groups[p].edge - c.edge)
        });
        for &c in &candidates {
            let (parent, child) = (groups[p], groups[c as usize]);
            let merged = parent.with(child);
            let added = merged.zeros - parent.zeros - child.zeros;
            if added <= PRICE || merged.zeros as f64 <= SHARE * merged.entries() as f64 {
                groups[p] = merged;
                into[c as usize] = p as u32;
            }
        }
    }
    // Members of members: parents come later.
    for s in (0..above.len()).rev() {
        into[s] = into[into[s] as usize];
    }
    into
}

/// Numbers the groups by their last members, which keeps children before
/// parents and each subtree together.
fn collect(first: &[usize], above: &[u32], groups: &[Group], into: &[u32]) -> Supernodes {
    let count = above.len();
    let mut number = vec![NONE; count];
    let mut out = Supernodes { first: vec![0], above: vec![], edge: vec![], columns: vec![] };
    for s in (0..count).filter(|&s| into[s] as usize == s) {
        number[s] = out.edge.len() as u32;
        out.edge.push(groups[s].edge as u32);
        out.first.push(out.first[out.first.len() - 1] + groups[s].width as u32);
    }
    out.above = (0..count)
        .filter(|&s| into[s] as usize == s)
        .map(|s| match above[s] {
            NONE => NONE,
            p => number[into[p as usize] as usize],
        })
        .collect();
    let mut next = out.first.clone();
    out.columns = vec![0; first[count]];
    for s in 0..count {
        let at = &mut next[number[into[s] as usize] as usize];
        for column in first[s]..first[s + 1] {
            out.columns[*at as usize] = column as u32;
            *at += 1;
        }
    }
    out
}
