//! One solve with the factor: forward substitution up the assembly tree, backward substitution
//! down it, in single precision. Subtrees are one task each, and contributions go from a front's
//! border to its parent's rows as in the multifrontal factorization (Liu 1992).

use std::ops::Range;

use super::kernels::{Halves, TransposedProduct};
use super::numeric::PackedFactor;
use super::packed::{FactorLayout, is_narrow};
use super::schedule::{Schedule, Task};
use super::substitution::{self, Front};
use super::symbolic::Pattern;

/// Tasks with so many entries of the factor are worth another thread.
const PARALLEL_TASK_ENTRIES: usize = 1 << 16;

/// Fronts with so many entries share their chunks between threads.
const PARALLEL_FRONT_ENTRIES: usize = 1 << 19;

/// A factor in use.
pub struct Solve<'a> {
    pub pattern: &'a Pattern,
    pub schedule: &'a Schedule,
    pub layout: &'a FactorLayout,
    pub entries: &'a PackedFactor,
    /// By the caller's numbers; times the factor it is near one.
    pub right_hand_side: &'a [f64],
    pub factor: f64,
}

impl Solve<'_> {
    /// Leaves the solution for the right-hand side times the factor in the tasks' vectors.
    pub fn run(&self, vectors: &mut [f32]) {
        let both = |vectors: &mut [f32]| {
            self.forward(&self.schedule.roots, vectors, 0);
            self.backward(&self.schedule.roots, vectors, 0);
        };
        if self.schedule.is_parallel {
            // A thread from outside waits for the pool once, not for each task.
            rayon::scope(|_| both(vectors));
        } else {
            both(vectors);
        }
    }

    fn entries_of(&self, tasks: &[u32]) -> usize {
        let (Some(first), Some(last)) = (tasks.first(), tasks.last()) else { return 0 };
        let from = self.schedule.tasks[*first as usize].all.start;
        let to = self.schedule.tasks[*last as usize].all.end;
        self.pattern.start[to] - self.pattern.start[from]
    }

    /// Does something with tasks that follow each other and their vectors, which
    /// start at `base`.
    fn for_tasks(
        &self,
        tasks: &[u32],
        vectors: &mut [f32],
        base: usize,
        work: &(impl Fn(&Task, &mut [f32], usize) + Sync),
    ) {
        match tasks {
            [] => {}
            [task] => work(&self.schedule.tasks[*task as usize], vectors, base),
            _ => {
                let (a, b) = tasks.split_at(tasks.len() / 2);
                let middle = self.schedule.tasks[b[0] as usize].vectors_start;
                let (left, right) = vectors.split_at_mut(middle - base);
                if self.entries_of(a) < PARALLEL_TASK_ENTRIES
                    || self.entries_of(b) < PARALLEL_TASK_ENTRIES
                {
                    self.for_tasks(a, left, base, work);
                    self.for_tasks(b, right, middle, work);
                } else {
                    rayon::join(
                        || self.for_tasks(a, left, base, work),
                        || self.for_tasks(b, right, middle, work),
                    );
                }
            }
        }
    }

    fn forward(&self, tasks: &[u32], vectors: &mut [f32], base: usize) {
        self.for_tasks(tasks, vectors, base, &|task, vectors, base| {
            self.forward_task(task, vectors, base)
        });
    }

    fn forward_task(&self, task: &Task, vectors: &mut [f32], base: usize) {
        let (below, own) = vectors.split_at_mut(task.vector.start - base);
        let own = &mut own[..task.vector.len()];
        self.forward(&task.children, below, base);
        self.load_right_hand_side(task, own);
        if task.subtree {
            pulp::Arch::new().dispatch(Subtree::<true> { solve: self, task, own });
            return;
        }
        for &child in &task.children {
            let child = &self.schedule.tasks[child as usize];
            let (border, map) = self.border_of(child);
            let from = child.vector.start - base + border;
            for (&row, v) in map.iter().zip(&below[from..]) {
                own[row as usize] += v;
            }
        }
        let front = self.front(task.own.start);
        let shape = front.shape;
        let (x, border) = own.split_at_mut(shape.width);
        let border = &mut border[..shape.border];
        substitution::forward(front, x, border, shape.len() >= PARALLEL_FRONT_ENTRIES);
    }

    /// Puts the right-hand side into a task's vector, and zeros into the rest.
    fn load_right_hand_side(&self, task: &Task, own: &mut [f32]) {
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
        let from = self.layout.of(task.own.start).column;
        for s in task.own.clone() {
            let front = self.front(s);
            let shape = front.shape;
            let column = (self.layout.of(s).column - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            // The last one's border is the task's.
            let last = s + 1 == task.own.end;
            let local = self.local_of(s);
            match (is_narrow(shape), last) {
                (true, true) => {
                    substitution::forward_narrow(simd, front, x, |rows, v| {
                        v.add_to(&mut rest[rows])
                    });
                }
                (true, false) => {
                    let give = |rows: Range<usize>, v: &Halves| v.add_at(rest, &local[rows]);
                    substitution::forward_narrow(simd, front, x, give);
                }
                (false, true) => substitution::forward(front, x, &mut rest[..shape.border], false),
                (false, false) => {
                    let room = rest.len() - shape.border;
                    let (rest, border) = rest.split_at_mut(room);
                    border.fill(0.0);
                    substitution::forward(front, x, border, false);
                    for (&row, v) in local.iter().zip(&*border) {
                        rest[row as usize] += v;
                    }
                }
            }
        }
    }

    fn backward(&self, tasks: &[u32], vectors: &mut [f32], base: usize) {
        self.for_tasks(tasks, vectors, base, &|task, vectors, base| {
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
        let (x, border) = own.split_at_mut(shape.width);
        let border = &border[..shape.border];
        substitution::backward(front, x, border, shape.len() >= PARALLEL_FRONT_ENTRIES);
        for &child in &task.children {
            let child = &self.schedule.tasks[child as usize];
            let (border, map) = self.border_of(child);
            let from = child.vector.start - base + border;
            for (&row, v) in map.iter().zip(&mut below[from..]) {
                *v = own[row as usize];
            }
        }
        self.backward(&task.children, below, base);
    }

    #[inline(always)]
    fn backward_subtree<S: pulp::Simd>(&self, simd: S, task: &Task, own: &mut [f32]) {
        let from = self.layout.of(task.own.start).column;
        let mut sums_so_far = TransposedProduct::new();
        for s in task.own.clone().rev() {
            let front = self.front(s);
            let shape = front.shape;
            let column = (self.layout.of(s).column - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            let last = s + 1 == task.own.end;
            let local = self.local_of(s);
            match (is_narrow(shape), last) {
                (true, true) => {
                    let take = |rows: Range<usize>| Halves::of(&rest[rows]);
                    substitution::backward_narrow(simd, front, &mut sums_so_far, x, take);
                }
                (true, false) => {
                    let take = |rows: Range<usize>| Halves::at(rest, &local[rows]);
                    substitution::backward_narrow(simd, front, &mut sums_so_far, x, take);
                }
                (false, true) => substitution::backward(front, x, &rest[..shape.border], false),
                (false, false) => {
                    let room = rest.len() - shape.border;
                    let (rest, border) = rest.split_at_mut(room);
                    for (&row, v) in local.iter().zip(border.iter_mut()) {
                        *v = rest[row as usize];
                    }
                    substitution::backward(front, x, border, false);
                }
            }
        }
    }

    /// Where a task's border starts in its vector, and its rows in the parent.
    fn border_of(&self, task: &Task) -> (usize, &[u32]) {
        let first = &self.pattern.first;
        let columns = (first[task.own.end] - first[task.own.start]) as usize;
        (columns, self.pattern.relative_indices(task.own.end - 1))
    }

    fn local_of(&self, s: usize) -> &[u32] {
        let start = &self.pattern.rows.start;
        &self.schedule.local[start[s]..start[s + 1]]
    }

    #[inline(always)]
    fn front(&self, s: usize) -> Front<'_> {
        let PackedFactor { words, triangles, factors, .. } = self.entries;
        let place = self.layout.of(s);
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
