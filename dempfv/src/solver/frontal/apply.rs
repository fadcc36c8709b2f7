//! One solve with the factor: forward through the tree, and back.

use rayon::prelude::*;

use super::dense;
use super::lanes;
use super::narrow;
use super::numeric::Entries;
use super::plan::{Plan, Task};
use super::shape::{Shape, TILE};
use super::symbolic::Pattern;

/// Tasks with so many entries of the factor are worth another thread.
const WORTH: usize = 1 << 16;

/// Fronts with so many entries share their tiles between threads.
const SHARED: usize = 1 << 19;

/// Columns of a panel that one task reads on the way back.
const COLUMNS: usize = 32;

/// Entries of the next front that are asked for ahead.
const AHEAD: usize = 1024;

/// A factor in use.
pub struct Solve<'a> {
    pub pattern: &'a Pattern,
    pub plan: &'a Plan,
    pub entries: &'a Entries,
}

impl Solve<'_> {
    /// Solves for right-hand sides that lie in the tasks' vectors, the rest of
    /// which is zero.
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
        let s = task.own.start;
        let shape = self.pattern.shape(s);
        let (x, edge) = own.split_at_mut(shape.width);
        let l = self.front(s);
        let edge = &mut edge[..shape.edge];
        if narrow::is_narrow(shape) {
            pulp::Arch::new().dispatch(Narrow::<true> { shape, l, x, edge });
        } else {
            forward_front(shape, l, x, edge, shape.len() >= SHARED);
        }
    }

    #[inline(always)]
    fn forward_subtree<S: pulp::Simd>(&self, simd: S, task: &Task, own: &mut [f32]) {
        let pattern = self.pattern;
        let from = pattern.first[task.own.start];
        for s in task.own.clone() {
            let shape = pattern.shape(s);
            let l = self.front(s);
            if s + 1 < task.own.end {
                self.ask_for(s + 1);
            }
            let column = (pattern.first[s] - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            let last = s + 1 == task.own.end;
            if narrow::is_small::<S>(shape) {
                let l = &self.entries.l[pattern.start[s]..];
                let out = narrow::forward_small(simd, shape.height(), l, x);
                x.iter_mut().zip(&out).for_each(|(x, v)| *x = -v);
                let edge = &out[shape.width..shape.height()];
                if last {
                    rest.iter_mut().zip(edge).for_each(|(e, v)| *e += v);
                } else {
                    for (&row, v) in self.local_of(s).iter().zip(edge) {
                        rest[row as usize] += v;
                    }
                }
                continue;
            }
            if last {
                // The last one's edge is the task's.
                forward_alone(simd, shape, l, x, &mut rest[..shape.edge]);
                continue;
            }
            let room = rest.len() - shape.edge;
            let (rest, edge) = rest.split_at_mut(room);
            edge.fill(0.0);
            forward_alone(simd, shape, l, x, edge);
            for (&row, v) in self.local_of(s).iter().zip(&*edge) {
                rest[row as usize] += v;
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
        let s = task.own.start;
        let shape = self.pattern.shape(s);
        let (x, edge) = own.split_at_mut(shape.width);
        let l = self.front(s);
        if narrow::is_narrow(shape) {
            let edge = &mut edge[..shape.edge];
            pulp::Arch::new().dispatch(Narrow::<false> { shape, l, x, edge });
        } else {
            backward_front(shape, l, x, &edge[..shape.edge], shape.len() >= SHARED);
        }
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
        let pattern = self.pattern;
        let from = pattern.first[task.own.start];
        for s in task.own.clone().rev() {
            let shape = pattern.shape(s);
            let l = self.front(s);
            if s > task.own.start {
                self.ask_for(s - 1);
            }
            let column = (pattern.first[s] - from) as usize;
            let (x, rest) = own[column..].split_at_mut(shape.width);
            let last = s + 1 == task.own.end;
            if narrow::is_small::<S>(shape) {
                let mut y = narrow::NOTHING;
                y.iter_mut().zip(&*x).for_each(|(y, x)| *y = -x);
                let edge = &mut y[shape.width..shape.height()];
                if last {
                    edge.copy_from_slice(&rest[..shape.edge]);
                } else {
                    for (&row, v) in self.local_of(s).iter().zip(edge) {
                        *v = rest[row as usize];
                    }
                }
                let l = &self.entries.l[pattern.start[s]..];
                narrow::backward_small(simd, shape.height(), l, &y, x);
                continue;
            }
            if last {
                backward_alone(simd, shape, l, x, &rest[..shape.edge]);
                continue;
            }
            let room = rest.len() - shape.edge;
            let (rest, edge) = rest.split_at_mut(room);
            for (&row, v) in self.local_of(s).iter().zip(edge.iter_mut()) {
                *v = rest[row as usize];
            }
            backward_alone(simd, shape, l, x, edge);
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

    /// Has a front brought near that comes next.
    #[inline(always)]
    fn ask_for(&self, s: usize) {
        let l = self.front(s);
        dense::prefetch(&l[..l.len().min(AHEAD)]);
        dense::prefetch(self.local_of(s));
    }

    fn front(&self, s: usize) -> &[f32] {
        let start = &self.pattern.start;
        &self.entries.l[start[s]..start[s + 1]]
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

/// A narrow front's part of a solve.
struct Narrow<'a, const FORWARD: bool> {
    shape: Shape,
    l: &'a [f32],
    x: &'a mut [f32],
    edge: &'a mut [f32],
}

impl<const FORWARD: bool> pulp::WithSimd for Narrow<'_, FORWARD> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Narrow { shape, l, x, edge } = self;
        if FORWARD {
            narrow::forward(simd, shape, l, x, edge);
        } else {
            narrow::backward(simd, shape, l, x, edge);
        }
    }
}

/// [`forward_front`] by one thread.
#[inline(always)]
fn forward_alone<S: pulp::Simd>(simd: S, shape: Shape, l: &[f32], x: &mut [f32], edge: &mut [f32]) {
    if narrow::is_narrow(shape) {
        narrow::forward(simd, shape, l, x, edge);
        return;
    }
    let mut at = 0;
    for panel in 0..shape.panels() {
        let (first, width) = (panel * TILE, shape.panel_width(panel));
        let (own, later) = x[first..].split_at_mut(width);
        lanes::solve_lower(simd, own, &l[at..at + width * width]);
        at += width * width;
        for y in later.chunks_mut(TILE).chain(edge.chunks_mut(TILE)) {
            let end = at + y.len() * width;
            lanes::subtract_times(simd, y, &l[at..end], y.len(), own);
            at = end;
        }
    }
}

/// [`backward_front`] by one thread.
#[inline(always)]
fn backward_alone<S: pulp::Simd>(simd: S, shape: Shape, l: &[f32], x: &mut [f32], edge: &[f32]) {
    if narrow::is_narrow(shape) {
        narrow::backward(simd, shape, l, x, edge);
        return;
    }
    for panel in (0..shape.panels()).rev() {
        let (first, width) = (panel * TILE, shape.panel_width(panel));
        let start = shape.panel_start(panel);
        let (own, later) = x[first..].split_at_mut(width);
        let mut at = start + width * width;
        for y in later.chunks(TILE).chain(edge.chunks(TILE)) {
            let end = at + y.len() * width;
            lanes::subtract_transposed(simd, own, &l[at..end], y.len(), y);
            at = end;
        }
        let diagonal = &l[start..start + width * width];
        lanes::solve_upper(simd, own, diagonal);
    }
}

/// x = L₁⁻¹ x, edge = edge - L₂ x for the two parts of a front's columns.
fn forward_front(shape: Shape, l: &[f32], x: &mut [f32], edge: &mut [f32], shared: bool) {
    for panel in 0..shape.panels() {
        let (first, width) = (panel * TILE, shape.panel_width(panel));
        let l = &l[shape.panel_start(panel)..];
        let (own, later) = x[first..].split_at_mut(width);
        dense::solve_lower(own, &l[..width * width]);
        let own = &*own;
        let tile = |row: usize, y: &mut [f32]| {
            let at = shape.tile_start(panel, row);
            dense::subtract_times(y, &l[at..at + y.len() * width], own);
        };
        let pivots = |(k, y): (usize, &mut [f32])| tile((panel + 1 + k) * TILE, y);
        let beyond = |(k, y): (usize, &mut [f32])| tile(shape.width + k * TILE, y);
        if shared {
            rayon::join(
                || later.par_chunks_mut(TILE).enumerate().for_each(pivots),
                || edge.par_chunks_mut(TILE).enumerate().for_each(beyond),
            );
        } else {
            later.chunks_mut(TILE).enumerate().for_each(pivots);
            edge.chunks_mut(TILE).enumerate().for_each(beyond);
        }
    }
}

/// x = L₁⁻ᵀ (x - L₂ᵀ edge) for the two parts of a front's columns.
fn backward_front(shape: Shape, l: &[f32], x: &mut [f32], edge: &[f32], shared: bool) {
    for panel in (0..shape.panels()).rev() {
        let (first, width) = (panel * TILE, shape.panel_width(panel));
        let l = &l[shape.panel_start(panel)..];
        let (own, later) = x[first..].split_at_mut(width);
        let later = &*later;
        let columns = |from: usize, own: &mut [f32]| {
            let tile = |row: usize, y: &[f32], own: &mut [f32]| {
                let at = shape.tile_start(panel, row) + from * y.len();
                dense::subtract_transposed(own, &l[at..at + own.len() * y.len()], y);
            };
            for (k, y) in later.chunks(TILE).enumerate() {
                tile((panel + 1 + k) * TILE, y, own);
            }
            for (k, y) in edge.chunks(TILE).enumerate() {
                tile(shape.width + k * TILE, y, own);
            }
        };
        if shared {
            let share = |(k, own): (usize, &mut [f32])| columns(k * COLUMNS, own);
            own.par_chunks_mut(COLUMNS).enumerate().for_each(share);
        } else {
            columns(0, own);
        }
        dense::solve_upper(own, &l[..width * width]);
    }
}
