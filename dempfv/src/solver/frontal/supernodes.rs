//! Which columns share a front: fundamental supernodes (Liu, Ng and Peyton 1993), amalgamated where
//! the zeros that this adds cost less than a front (Duff and Reid 1983; Ashcraft and Grimes 1989).

use crate::solver::elimination_tree::{self as tree, NONE};

/// A front costs as much time as so many entries, whatever it holds: no more
/// zeros than this are a good price for one front less.
const FRONT_OVERHEAD_ENTRIES: usize = 130;

/// Larger fronts are merged where zeros are no more than this share.
const ZERO_FRACTION: f64 = 0.04;

/// Groups of columns that are eliminated in one front.
pub struct Supernodes {
    /// First column of each, in the new order, and the number of columns.
    pub first: Vec<u32>,
    /// Parent of each; [`NONE`] at a root.
    pub parent: Vec<u32>,
    /// Rows of each front below its columns.
    pub border: Vec<u32>,
    /// The columns in their new order: a supernode's are made to follow each
    /// other.
    pub columns: Vec<u32>,
}

/// A supernode in the making, by its last member.
#[derive(Clone, Copy)]
struct Group {
    width: usize,
    border: usize,
    zeros: usize,
}

impl Group {
    /// Entries of the lower trapezoid.
    fn entries(self) -> usize {
        self.width * (self.width + 1) / 2 + self.width * self.border
    }

    /// The group that a child forms with this one.
    fn with(self, child: Group) -> Group {
        let zeros = child.width * (self.width + self.border - child.border);
        Group {
            width: self.width + child.width,
            border: self.border,
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
        let parent: Vec<u32> = (0..count)
            .map(|s| match parent[first[s + 1] - 1] {
                NONE => NONE,
                column => owner[column as usize],
            })
            .collect();
        let mut groups: Vec<Group> = (0..count)
            .map(|s| Group {
                width: first[s + 1] - first[s],
                border: counts[first[s + 1] - 1] as usize - 1,
                zeros: 0,
            })
            .collect();
        let into = merge(&parent, &mut groups);
        collect(&first, &parent, &groups, &into)
    }
}

/// Merges supernodes with their parents, children first; returns the supernode
/// that each one goes into, itself if it stays.
fn merge(parent: &[u32], groups: &mut [Group]) -> Vec<u32> {
    let children = tree::children(parent);
    let mut into: Vec<u32> = (0..parent.len() as u32).collect();
    let mut candidates: Vec<u32> = vec![];
    for p in 0..parent.len() {
        candidates.clear();
        candidates.extend(children.of(p));
        // Those that lack least of the parent's rows first.
        candidates.sort_by_key(|&c| {
            let c = groups[c as usize];
            c.width * (groups[p].width + groups[p].border - c.border)
        });
        for &c in &candidates {
            let (parent, child) = (groups[p], groups[c as usize]);
            let merged = parent.with(child);
            let added = merged.zeros - parent.zeros - child.zeros;
            if added <= FRONT_OVERHEAD_ENTRIES
                || merged.zeros as f64 <= ZERO_FRACTION * merged.entries() as f64
            {
                groups[p] = merged;
                into[c as usize] = p as u32;
            }
        }
    }
    // Members of members: parents come later.
    for s in (0..parent.len()).rev() {
        into[s] = into[into[s] as usize];
    }
    into
}

/// Numbers the groups by their last members, which keeps children before
/// parents and each subtree together.
fn collect(first: &[usize], parent: &[u32], groups: &[Group], into: &[u32]) -> Supernodes {
    let count = parent.len();
    let mut number = vec![NONE; count];
    let mut out = Supernodes { first: vec![0], parent: vec![], border: vec![], columns: vec![] };
    for s in (0..count).filter(|&s| into[s] as usize == s) {
        number[s] = out.border.len() as u32;
        out.border.push(groups[s].border as u32);
        out.first.push(out.first[out.first.len() - 1] + groups[s].width as u32);
    }
    out.parent = (0..count)
        .filter(|&s| into[s] as usize == s)
        .map(|s| match parent[s] {
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
