//! Phases timed by criterion, beside the least time that the machine needs for them.

use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId};
use dempfv_evidence::limits::Limits;
use rayon::ThreadPool;

/// Every phase has at least so many samples.
const LAST: usize = 10;

/// What a phase must do at least.
pub struct Work {
    /// How often: pores, contacts, spheres, unknowns.
    pub count: usize,
    /// What is counted.
    pub unit: &'static str,
    /// For each: bytes that are read and written, and floating point operations.
    pub bytes: f64,
    pub flops: f64,
}

/// The limits of this machine, which phases are held against.
pub struct Floor(Limits);

impl Floor {
    /// Measures them, and says so.
    pub fn measure() -> Floor {
        let limits = Limits::measure();
        let Limits { bandwidth: [b1, b], double: [r1, r], .. } = limits;
        let threads = rayon::current_num_threads();
        println!(
            "the machine: reads {:.1} GB/s on one thread, {:.1} on {threads}; multiplies matrices with \
             {:.1} GFLOP/s on one thread, {:.1} on {threads}\n",
            1e-9 * b1,
            1e-9 * b,
            1e-9 * r1,
            1e-9 * r
        );
        Floor(limits)
    }

    /// Times a phase by criterion on the threads of a pool, and holds it against the limits
    /// of one thread or of all.
    pub fn bench(
        &self,
        group: &mut BenchmarkGroup<WallTime>,
        id: BenchmarkId,
        work: &Work,
        pool: &ThreadPool,
        mut run: impl FnMut() + Send,
    ) {
        let mut samples = vec![];
        group.bench_function(id, |b| {
            b.iter_custom(|n| {
                let spent: Duration = pool.install(|| {
                    let start = Instant::now();
                    (0..n).for_each(|_| run());
                    start.elapsed()
                });
                samples.push(spent.as_secs_f64() / n as f64);
                spent
            });
        });
        // The median of what came after the warm-up.
        let last = samples.len().saturating_sub(LAST);
        let samples = &mut samples[last..];
        samples.sort_by(f64::total_cmp);
        let taken = samples[samples.len() / 2];
        let Work { count, unit, bytes, flops } = work;
        let which = usize::from(pool.current_num_threads() > 1);
        let [reading, computing] = [bytes / self.0.bandwidth[which], flops / self.0.double[which]]
            .map(|t| *count as f64 * t);
        println!(
            "    {count} {unit}: {bytes:.0} B and {flops:.0} operations each take {:.4} and {:.4} ms at \
             the limits; taken {:.4} ms, {:.1} times the larger\n",
            1e3 * reading,
            1e3 * computing,
            1e3 * taken,
            taken / reading.max(computing)
        );
    }
}
