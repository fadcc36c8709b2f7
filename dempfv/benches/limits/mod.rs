//! The machine's limits, measured in the same run, and how far from them the code is.

use std::hint::black_box;
use std::time::{Duration, Instant};

use cholmod_sys::blas;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId};
use rayon::ThreadPool;
use rayon::prelude::*;

/// Numbers of 64 bits that are read: far more than any cache holds.
const NUMBERS: usize = 1 << 26;
/// Rows of the matrices that are multiplied.
const ROWS: usize = 2048;
/// The best of so many counts.
const REPEATS: usize = 5;

/// Every phase has at least so many samples.
const LAST: usize = 10;

/// What the machine can do, on one thread and on all.
pub struct Limits {
    /// Reading memory (bytes/s).
    bandwidth: [f64; 2],
    /// Multiplying matrices in double precision (operations/s).
    rate: [f64; 2],
}

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

impl Limits {
    /// Measures them, and says so.
    pub fn measure() -> Limits {
        let limits = Limits { bandwidth: bandwidth(), rate: rate() };
        let Limits { bandwidth: [b1, b], rate: [r1, r] } = limits;
        let threads = rayon::current_num_threads();
        println!(
            "the machine: reads {:.1} GB/s on one thread, {:.1} on {threads}; multiplies matrices with \
             {:.1} GFLOP/s on one thread, {:.1} on {threads}\n",
            1e-9 * b1,
            1e-9 * b,
            1e-9 * r1,
            1e-9 * r
        );
        limits
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
        let [reading, computing] =
            [bytes / self.bandwidth[which], flops / self.rate[which]].map(|t| *count as f64 * t);
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

/// Seconds of the fastest call.
fn best(mut run: impl FnMut()) -> f64 {
    let times = (0..REPEATS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn bandwidth() -> [f64; 2] {
    let data = vec![1.0f64; NUMBERS];
    // Eight sums at a time, so that the additions do not wait for each other.
    let sum = |part: &[f64]| {
        let lanes = part.chunks_exact(8).fold([0.0; 8], |mut s, c| {
            s.iter_mut().zip(c).for_each(|(s, c)| *s += c);
            s
        });
        lanes.iter().sum::<f64>()
    };
    let one = best(|| {
        black_box(sum(&data));
    });
    let all = best(|| {
        black_box(data.par_chunks(1 << 16).map(sum).sum::<f64>());
    });
    let bytes = (NUMBERS * size_of::<f64>()) as f64;
    [bytes / one, bytes / all]
}

fn rate() -> [f64; 2] {
    let (a, b) = (vec![1.0f64; ROWS * ROWS], vec![1.0f64; ROWS * ROWS]);
    let mut c = vec![0.0; ROWS * ROWS];
    // Keeps CHOLMOD linked, and so the BLAS loaded.
    black_box(cholmod_sys::cholmod_l_factorize as *const ());
    assert!(blas::multiply(ROWS, &a, &b, &mut c), "there is no BLAS");
    let rates = [1, rayon::current_num_threads()].map(|threads| {
        blas::set_num_threads(threads);
        let time = best(|| {
            black_box(blas::multiply(ROWS, &a, &b, &mut c));
        });
        2.0 * (ROWS as f64).powi(3) / time
    });
    // As the library sets it at first.
    blas::set_num_threads(1);
    rates
}
