//! Threads of the pool that spin, rather than sleep, while a step is worked at.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A thread that has found nothing to do for so long goes to sleep after all: longer than
/// what one thread does alone within a step, shorter than anyone waits for.
const PATIENCE: Duration = Duration::from_micros(300);

/// Looks at the clock once in so many attempts.
const ATTEMPTS: usize = 16;

/// Does the work while the other threads of the pool look for parts of it without going
/// to sleep, from which they take longer to wake up than a small loop takes. Leaves them
/// alone where there are more threads than processors.
pub fn spinning<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static PROCESSORS: OnceLock<usize> = OnceLock::new();
    let threads = rayon::current_num_threads();
    let processors =
        *PROCESSORS.get_or_init(|| thread::available_parallelism().map_or(1, usize::from));
    if threads == 1 || threads > processors {
        return work();
    }
    let done = AtomicBool::new(false);
    rayon::scope(|scope| {
        let caller = rayon::current_thread_index();
        for _ in 1..threads {
            let done = &done;
            scope.spawn(move |_| {
                // The one who works may come here while it waits for others.
                if rayon::current_thread_index() != caller {
                    wait(done);
                }
            });
        }
        let _done = Done(&done);
        work()
    })
}

/// Tells those who wait, also when the work panics.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Takes what parts there are until the work is done, or nothing came for a while. That
/// bound is not for thrift alone: whoever waits inside of a part of the work holds it up.
fn wait(done: &AtomicBool) {
    let mut idle = Instant::now();
    loop {
        for _ in 0..ATTEMPTS {
            if done.load(Ordering::Acquire) {
                return;
            }
            match rayon::yield_now() {
                Some(rayon::Yield::Executed) => idle = Instant::now(),
                _ => std::hint::spin_loop(),
            }
        }
        if idle.elapsed() > PATIENCE {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    /// From inside and outside of the pool, whatever the threads that wait are busy with,
    /// the work is done and comes back; when it panics, so does the caller, and nobody
    /// waits for ever. Two threads: fewer than any machine's processors but one.
    #[test]
    fn the_work_comes_back() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let sum = |n: u64| {
            let halves = || rayon::join(|| (0..n).into_par_iter().sum::<u64>(), || n);
            (0..20).map(|_| halves().0).sum::<u64>()
        };
        for n in 0..200u64 {
            let expected = 20 * n * n.saturating_sub(1) / 2;
            assert_eq!(pool.install(|| spinning(|| sum(n))), expected);
            assert_eq!(pool.install(|| spinning(|| spinning(|| sum(n)))), expected);
            assert_eq!(spinning(|| sum(n)), expected);
        }
        let fails = || pool.install(|| spinning(|| assert!(sum(3) == 0, "on purpose")));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(fails)).is_err());
        assert_eq!(pool.install(|| spinning(|| sum(9))), 20 * 36);
    }
}
