//! Which thread works at what: small subtrees of the assembly tree as one task each, the fronts above
//! them one by one (subtree to task mapping: George, Liu and Ng 1989; Geist and Ng 1989). The schedule
//! depends on the pattern alone, never on the number of threads, and so do the bits of what follows
//! it.

use std::ops::Range;

use super::symbolic::Pattern;
use crate::solver::elimination_tree::NONE;

/// A factor of fewer entries is worked through by one thread: it is done before
/// another has woken up.
const PARALLEL_FACTOR_ENTRIES: usize = 1 << 19;

/// A larger one is cut into subtrees of about this part of it.
const SUBTREE_COUNT: usize = 48;

/// Factors of fewer unknowns have no blocks kept as low-rank sums: with 118,000 a correction
/// took 3.3 ms instead of 3.5, but left so much more that third ones cost twice that.
const LOW_RANK_UNKNOWNS: usize = 200_000;

/// Chains of fronts are followed by recursion, which the stack must bear.
const RECURSION_DEPTH: usize = 400;

/// A subtree that one thread works through, or one front above such subtrees.
pub struct Task {
    /// Supernodes in the order of their elimination.
    pub own: Range<usize>,
    /// True for a subtree of several; a front of its own has only one.
    pub subtree: bool,
    /// Tasks that must come first.
    pub children: Vec<u32>,
    /// Supernodes of this task and of all below it.
    pub all: Range<usize>,
    /// Where the task's own vector lies among those of all tasks; those below it come
    /// directly before.
    pub vector: Range<usize>,
    /// Where the vectors of this task and all below it start.
    pub vectors_start: usize,
}

/// Tasks in postorder, and where each supernode's rows lie in its task's vector.
pub struct Schedule {
    pub tasks: Vec<Task>,
    pub roots: Vec<u32>,
    /// For supernodes of subtrees: the rows of the border as places in the
    /// task's vector, less the place after the supernode's own columns.
    pub local: Vec<u32>,
    /// Where each unknown lies among the vectors, by the caller's numbers.
    pub place: Vec<u32>,
    /// Length of all vectors together.
    pub vectors: usize,
    /// True where there is enough to do for several threads.
    pub is_parallel: bool,
    /// True where blocks of the factor may be kept as low-rank sums.
    pub low_rank: bool,
}

impl Schedule {
    pub fn new(pattern: &Pattern) -> Schedule {
        let total = pattern.start[pattern.supernodes()];
        let small =
            if total <= PARALLEL_FACTOR_ENTRIES { usize::MAX } else { total / SUBTREE_COUNT };
        let schedule = Schedule::cut(pattern, small);
        let schedule = if schedule.depth() <= RECURSION_DEPTH {
            schedule
        } else {
            Schedule::cut(pattern, usize::MAX)
        };
        Schedule {
            is_parallel: total > PARALLEL_FACTOR_ENTRIES && schedule.tasks.len() > 1,
            low_rank: pattern.n >= LOW_RANK_UNKNOWNS,
            ..schedule
        }
    }

    /// Entries of the factor in a range of supernodes.
    fn cut(pattern: &Pattern, small: usize) -> Schedule {
        let count = pattern.supernodes();
        // First supernode of each one's subtree.
        let mut lowest: Vec<usize> = (0..count).collect();
        for (s, &parent) in pattern.parent.iter().enumerate().filter(|(_, p)| **p != NONE) {
            lowest[parent as usize] = lowest[parent as usize].min(lowest[s]);
        }
        let entries = |s: usize| pattern.start[s + 1] - pattern.start[lowest[s]];
        let mut tasks: Vec<Task> = vec![];
        let mut roots = vec![];
        // Tasks whose parent is still to come.
        let mut open: Vec<u32> = vec![];
        let mut vectors = 0;
        for (s, &below) in lowest.iter().enumerate() {
            let parent = pattern.parent[s];
            let is_small = entries(s) <= small;
            if is_small && parent != NONE && entries(parent as usize) <= small {
                continue;
            }
            let children = match is_small {
                true => vec![],
                false => {
                    let from = open.partition_point(|&t| tasks[t as usize].all.start < below);
                    open.split_off(from)
                }
            };
            let vectors_start =
                children.first().map_or(vectors, |&c| tasks[c as usize].vectors_start);
            let own = if is_small { below..s + 1 } else { s..s + 1 };
            let len = vector_len(pattern, &own);
            let vector = vectors..vectors + len;
            vectors += len;
            let id = tasks.len() as u32;
            tasks.push(Task {
                own,
                subtree: is_small,
                children,
                all: below..s + 1,
                vector,
                vectors_start,
            });
            if parent == NONE {
                roots.push(id);
            } else {
                open.push(id);
            }
        }
        let (local, place) = layout(pattern, &tasks);
        Schedule { tasks, roots, local, place, vectors, is_parallel: false, low_rank: false }
    }

    /// Longest way from a root.
    fn depth(&self) -> usize {
        let mut depth = vec![1usize; self.tasks.len()];
        for (t, task) in self.tasks.iter().enumerate() {
            let below = task.children.iter().map(|&c| depth[c as usize]).max();
            depth[t] = 1 + below.unwrap_or(0);
        }
        depth.into_iter().max().unwrap_or(0)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        4 * (self.local.len() + self.place.len()) + self.tasks.len() * size_of::<Task>()
    }
}

/// A task's vector: its columns, the rows of its last supernode's border, and
/// room for the longest border of any of its supernodes.
fn vector_len(pattern: &Pattern, own: &Range<usize>) -> usize {
    let columns = (pattern.first[own.end] - pattern.first[own.start]) as usize;
    let border = pattern.shape(own.end - 1).border;
    let longest = own.clone().map(|s| pattern.shape(s).border).max().unwrap_or(0);
    columns + border + if own.len() > 1 { longest } else { 0 }
}

fn layout(pattern: &Pattern, tasks: &[Task]) -> (Vec<u32>, Vec<u32>) {
    let mut local = vec![0u32; pattern.rows.items.len()];
    let mut place = vec![0u32; pattern.n];
    for task in tasks {
        let (from, to) = (pattern.first[task.own.start], pattern.first[task.own.end]);
        for k in from..to {
            let unknown = pattern.order[k as usize] as usize;
            place[unknown] = (task.vector.start + (k - from) as usize) as u32;
        }
        let rows = |s: usize| pattern.rows.start[s]..pattern.rows.start[s + 1];
        let border = &pattern.rows.items[rows(task.own.end - 1)];
        for s in task.own.clone() {
            let after = pattern.first[s + 1] - from;
            let mut k = 0;
            for at in rows(s) {
                let row = pattern.rows.items[at];
                local[at] = if row < to {
                    row - from
                } else {
                    while border[k] != row {
                        k += 1;
                    }
                    to - from + k as u32
                } - after;
            }
        }
    }
    (local, place)
}
