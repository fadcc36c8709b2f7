//! Loops and sums of a fixed shape: each part is computed by one thread, in order, and parts are
//! joined in their order. Results have the same bits for any number of threads.

use rayon::prelude::*;

/// Below this many entries one thread is faster than handing work over.
pub const SERIAL: usize = 16_384;
/// Entries that one task takes.
pub const TASK: usize = 4_096;

/// Calls a function for each entry of an array, on several threads if the
/// array is long enough to pay for it.
pub fn for_each<T: Send>(out: &mut [T], set: &(impl Fn(usize, &mut T) + Sync)) {
    in_tasks(out, SERIAL, TASK, set);
}

/// [`for_each`] in tasks of so many entries, on one thread if there are fewer than `serial`.
pub fn in_tasks<T: Send>(
    out: &mut [T],
    serial: usize,
    task: usize,
    set: &(impl Fn(usize, &mut T) + Sync),
) {
    if out.len() < serial {
        out.iter_mut().enumerate().for_each(|(i, v)| set(i, v));
    } else {
        out.par_chunks_mut(task).enumerate().for_each(|(k, chunk)| {
            let first = k * task;
            chunk.iter_mut().enumerate().for_each(|(k, v)| set(first + k, v));
        });
    }
}

/// Works through vectors over the unknowns and the pressures of all pores part by part,
/// each with the pores of its unknowns; the first pressure of a part is that of its first
/// unknown's pore. Returns what comes of the parts, joined.
pub fn with_pores<const K: usize, T: Send>(
    pore_of: &[u32],
    vectors: [&mut [f64]; K],
    pressure: &mut [f64],
    work: &(impl Fn([&mut [f64]; K], &[u32], &mut [f64]) -> T + Sync),
    join: &(impl Fn(T, T) -> T + Sync),
) -> T {
    let first = pore_of.first().map_or(0, |&pore| pore as usize);
    let pressure = &mut pressure[first..];
    if pore_of.len() < SERIAL {
        work(vectors, pore_of, pressure)
    } else {
        halves(pore_of, vectors, pressure, work, join)
    }
}

fn halves<const K: usize, T: Send>(
    pore_of: &[u32],
    vectors: [&mut [f64]; K],
    pressure: &mut [f64],
    work: &(impl Fn([&mut [f64]; K], &[u32], &mut [f64]) -> T + Sync),
    join: &(impl Fn(T, T) -> T + Sync),
) -> T {
    if pore_of.len() <= TASK {
        return work(vectors, pore_of, pressure);
    }
    let middle = pore_of.len() / 2;
    let (left, right) = pore_of.split_at(middle);
    let (before, after) = pressure.split_at_mut((right[0] - left[0]) as usize);
    let mut both = vectors.map(|vector| vector.split_at_mut(middle));
    let lower = both.each_mut().map(|both| std::mem::take(&mut both.0));
    let upper = both.map(|both| both.1);
    let (a, b) = rayon::join(
        || halves(left, lower, before, work, join),
        || halves(right, upper, after, work, join),
    );
    join(a, b)
}

/// Takes a vector part by part and joins what comes of the parts, in their order: the
/// same for any number of threads.
pub fn parts<T: Copy + Send + Sync>(
    x: &[f64],
    one: impl Fn(&[f64]) -> T + Sync,
    none: T,
    join: impl Fn(T, T) -> T,
) -> T {
    const PARTS: usize = 64;
    let size = x.len().div_ceil(PARTS).max(1);
    let mut found = [none; PARTS];
    if x.len() < SERIAL {
        found.iter_mut().zip(x.chunks(size)).for_each(|(found, part)| *found = one(part));
    } else {
        let each = found.par_iter_mut().zip(x.par_chunks(size));
        each.with_min_len(4).for_each(|(found, part)| *found = one(part));
    }
    found.into_iter().fold(none, join)
}

/// Σ f(k) of 0 ≤ k < `n`: task by task, and the sums of tasks in their order.
pub fn sum_of(n: usize, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    let one = |task: usize| (task * TASK..n.min((task + 1) * TASK)).map(&f).sum::<f64>();
    let tasks = n.div_ceil(TASK);
    if n < SERIAL {
        (0..tasks).map(one).sum()
    } else {
        let sums: Vec<f64> = (0..tasks).into_par_iter().map(one).collect();
        sums.into_iter().sum()
    }
}

/// Cuts what belongs to rows, which start where `start` says, into what
/// belongs to each [`TASK`] of them.
pub fn runs<T>(mut rest: &mut [T], rows: usize, start: impl Fn(usize) -> usize) -> Vec<&mut [T]> {
    let mut runs = Vec::with_capacity(rows / TASK + 1);
    for first in (0..rows).step_by(TASK) {
        let end = start(rows.min(first + TASK));
        let (run, after) = rest.split_at_mut(end - start(first));
        runs.push(run);
        rest = after;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each entry is set once and by its own number, on one thread or in tasks, the last of
    /// which may be short.
    #[test]
    fn tasks_know_their_entries() {
        for n in [0, 1, 99, 100, 128, 1000] {
            let mut out = vec![0; n];
            in_tasks(&mut out, 100, 64, &|i, v| *v += 1 + i);
            assert!(out.iter().enumerate().all(|(i, &v)| v == 1 + i), "{n}");
        }
    }

    /// Every number counts once, few or many, and sums do not depend on threads.
    #[test]
    fn sums_are_whole() {
        for n in [0, 1, TASK - 1, TASK, TASK + 1, SERIAL + 77] {
            assert_eq!(sum_of(n, |k| k as f64), (n * n.saturating_sub(1) / 2) as f64);
        }
        let term = |k: usize| 1.0 / (1.0 + k as f64);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sum_of(SERIAL + 77, term)).to_bits()
        };
        assert_eq!(on(1), on(3));
    }

    /// Every number counts once, few or many: 0 + 1 + … + (n − 1) = n (n − 1) / 2, exactly.
    #[test]
    fn parts_are_the_whole() {
        for n in [0, 1, 63, 64, 65, SERIAL - 1, SERIAL, SERIAL + 77] {
            let x: Vec<f64> = (0..n).map(|k| k as f64).collect();
            let sum = parts(&x, |part| part.iter().sum(), 0.0, |a: f64, b| a + b);
            assert_eq!(sum, (n * n.saturating_sub(1) / 2) as f64);
        }
    }
}
