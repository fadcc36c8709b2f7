//! One solve with the factor: forward through the tree, and back.

use std::ops::Range;

use super::block::{Collected, Halves};
use super::numeric::Entries;
use super::plan::{Plan, Task};
use super::shares::{Places, is_narrow};
use super::sweep::{self, Front};
use super::symbolic::Pattern;

/// Tasks with so many entries of the factor are worth another thread.
const WORTH: usize = 1 << 16;

/// Fronts with so many entries share their chunks between threads.
const SHARED: usize = 1 << 19;

/// A factor in use.
pub struct Solve<'a> {
    pub pattern: &'a Pattern,
    pub plan: &'a Plan,
    pub places: &'a Places,
    pub entries: &'a Entries,
    /// By the caller's numbers; times the factor it is near one.
    pub right_hand_side: &'a [f64],
    pub factor: f64,
}

impl Solve<'_> {
    /// Leaves the solution for the right-hand side times the factor in the tasks' vectors.
    pub fn run(&self, vectors: &mut [f32]) {
        let both = |vectors: &mut [f32]| {
            self.forward(&self.plan.roots, vectors, 0);
            self.backward(&self.plan.roots, vectors, 0);
        };
        if self.plan.is_shared {
            // A thread from outside waits for the pool once, not for each task.
            rayon::scope(|_| both(vectors));
        } else {
            both(vectors);
        }
    }

    fn entries_of(&self, tasks: &[u32]) -> usize {
        let (Some(first), Some(last)) = (tasks.first(), tasks.last()) else { return 0 };
        let from = self.plan.tasks[*first as usize].all.start;
        let to = self.plan.tasks[*last as usize].all.end;
        self.pattern.start[to] - self.pattern.start[from]
    }

    /// Does something with tasks that follow each other and their vectors, which
    /// start at `base`.
    fn over(
        &self,
        tasks: &[u32],
        vectors: &mut [f32],
        base: usize,
        work: &(impl Fn(&Task, &mut [f32], usize) + Sync),
    ) {
        match tasks {
            [] => {}
            [task] => work(&self.plan.tasks[*task as usize], vectors, base),
            _ => {
                let (a, b) = tasks.split_at(tasks.len() / 2);
                let middle = self.plan.tasks[b[0] as usize].vectors_start;
                let (left, right) = vectors.split_at_mut(middle - base);
                if self.entries_of(a) < WORTH || self.entries_of(b) < WORTH {
                    self.over(a, left, base, work);
                    self.over(b, right, middle, work);
                } else {
                    rayon::join(
                        || self.over(a, left, base, work),
                        || self.over(b, right, middle, work),
                    );
                }
            }
        }
    }

    fn forward(&self, tasks: &[u32], vectors: &mut [f32], base: usize) {
        self.over(tasks, vectors, base, &|task, vectors, base| {
            self.forward_task(task, vectors, base)
        });
    }

    fn forward_task(&self, task: &Task, vectors: &mut [f32], base: usize) {
        let (below, own) = vectors.split_at_mut(task.vector.start - base);
        let own = &mut own[..task.vector.len()];
        self.forward(&task.children, below, base);
        self.begin(task, own);
        if task.subtree {
            pulp::Arch::new().dispatch(Subtree::<true> { solve: self, task, own });
            return;
        }
        for &child in &task.children {
            let child = &self.plan.tasks[child as usize];
            let (edge, map) = self.edge_of(child);
            let from = child.vector.start - base + edge;
            for (&row, v) in map.iter().zip(&below[from..]) {
                own[row as usize] += v;
            }
        }
        let front = self.front(task.own.start);
        let shape = front.shape;
        let (x, edge) = own.split_at_mut(shape.width);
        let edge = &mut edge[..shape.edge];
        sweep::forward(front, x, edge, shape.len() >= SHARED);
    }

    /// Puts the right-hand side into a task's vector, and zeros into the rest.
    fn begin(&self, task: &Task, own: &mut [f32]) {
        let Range { start, end } = task.own;
        let first = &self.pattern.first;
        let unknowns = &self.pattern.order[first[start] as usize..first[end] as usize];
        let (x, rest) = own.split_at_mut(unknowns.len());
        for (x, &unknown) in x.iter_mut().zip(unknowns) {
            *x = (self.right_hand_side[unknown as usize] * self.factor) as f32;
        }
        rest.fill(0.0);
    }

    #[inline(always)]
    fn forward_subtree<S: pulp::Simd>(&self, simd: S, task: &Task, own: &mut [f32]) {
        let from = self.places.of(task.own.start).column;
        for s in task.own.clone() {
            let front = self.front(s);
            let shape = front.shape;
            let column = (self.places.of(s).column - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            // The last one's edge is the task's.
            let last = s + 1 == task.own.end;
            let local = self.local_of(s);
            match (is_narrow(shape), last) {
                (true, true) => {
                    sweep::forward_narrow(simd, front, x, |rows, v| v.add_to(&mut rest[rows]));
                }
                (true, false) => {
                    let give = |rows: Range<usize>, v: &Halves| v.add_at(rest, &local[rows]);
                    sweep::forward_narrow(simd, front, x, give);
                }
                (false, true) => sweep::forward(front, x, &mut rest[..shape.edge], false),
                (false, false) => {
                    let room = rest.len() - shape.edge;
                    let (rest, edge) = rest.split_at_mut(room);
                    edge.fill(0.0);
                    sweep::forward(front, x, edge, false);
                    for (&row, v) in local.iter().zip(&*edge) {
                        rest[row as usize] += v;
                    }
                }
            }
        }
    }

    fn backward(&self, tasks: &[u32], vectors: &mut [f32], base: usize) {
        self.over(tasks, vectors, base, &|task, vectors, base| {
            self.backward_task(task, vectors, base)
        });
    }

    fn backward_task(&self, task: &Task, vectors: &mut [f32], base: usize) {
        let (below, own) = vectors.split_at_mut(task.vector.start - base);
        let own = &mut own[..task.vector.len()];
        if task.subtree {
            pulp::Arch::new().dispatch(Subtree::<false> { solve: self, task, own });
            return;
        }
        let front = self.front(task.own.start);
        let shape = front.shape;
        let (x, edge) = own.split_at_mut(shape.width);
        let edge = &edge[..shape.edge];
        sweep::backward(front, x, edge, shape.len() >= SHARED);
        for &child in &task.children {
            let child = &self.plan.tasks[child as usize];
            let (edge, map) = self.edge_of(child);
            let from = child.vector.start - base + edge;
            for (&row, v) in map.iter().zip(&mut below[from..]) {
                *v = own[row as usize];
            }
        }
        self.backward(&task.children, below, base);
    }

    #[inline(always)]
    fn backward_subtree<S: pulp::Simd>(&self, simd: S, task: &Task, own: &mut [f32]) {
        let from = self.places.of(task.own.start).column;
        let mut collected = Collected::new();
        for s in task.own.clone().rev() {
            let front = self.front(s);
            let shape = front.shape;
            let column = (self.places.of(s).column - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            let last = s + 1 == task.own.end;
            let local = self.local_of(s);
            match (is_narrow(shape), last) {
                (true, true) => {
                    let take = |rows: Range<usize>| Halves::of(&rest[rows]);
                    sweep::backward_narrow(simd, front, &mut collected, x, take);
                }
                (true, false) => {
                    let take = |rows: Range<usize>| Halves::at(rest, &local[rows]);
                    sweep::backward_narrow(simd, front, &mut collected, x, take);
                }
                (false, true) => sweep::backward(front, x, &rest[..shape.edge], false),
                (false, false) => {
                    let room = rest.len() - shape.edge;
                    let (rest, edge) = rest.split_at_mut(room);
                    for (&row, v) in local.iter().zip(edge.iter_mut()) {
                        *v = rest[row as usize];
                    }
                    sweep::backward(front, x, edge, false);
                }
            }
        }
    }

    /// Where a task's edge starts in its vector, and its rows in the parent.
    fn edge_of(&self, task: &Task) -> (usize, &[u32]) {
        let first = &self.pattern.first;
        let columns = (first[task.own.end] - first[task.own.start]) as usize;
        (columns, self.pattern.map_of(task.own.end - 1))
    }

    fn local_of(&self, s: usize) -> &[u32] {
        let start = &self.pattern.rows.start;
        &self.plan.local[start[s]..start[s + 1]]
    }

    #[inline(always)]
    fn front(&self, s: usize) -> Front<'_> {
        let Entries { words, triangles, factors, .. } = self.entries;
        let place = self.places.of(s);
        Front {
            shape: place.shape(),
            words: &words[place.words..],
            triangles: &triangles[place.triangles..],
            factors: &factors[place.column as usize..],
        }
    }
}

/// A subtree's part of a solve, compiled for the processor's vectors as a whole.
struct Subtree<'a, const FORWARD: bool> {
    solve: &'a Solve<'a>,
    task: &'a Task,
    own: &'a mut [f32],
}

impl<const FORWARD: bool> pulp::WithSimd for Subtree<'_, FORWARD> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        if FORWARD {
            self.solve.forward_subtree(simd, self.task, self.own);
        } else {
            self.solve.backward_subtree(simd, self.task, self.own);
        }
    }
}
