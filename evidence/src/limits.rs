//! What the machine can do: how fast its memory is read, how fast it multiplies matrices.

use std::cell::RefCell;
use std::hint::black_box;
use std::time::Instant;

use cholmod_sys::blas::{self, Real};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Numbers of 64 bits that are read: far more than any cache holds.
const NUMBERS: usize = 1 << 26;
/// Numbers that a thread reads at a time.
const PART: usize = 1 << 16;
/// Rows of the matrices that are multiplied.
const ROWS: usize = 2048;
/// The best of so many counts.
const REPEATS: usize = 5;

/// The machine's limits, each on one thread and on several.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Limits {
    /// Reading memory (bytes/s).
    pub bandwidth: [f64; 2],
    /// Multiplying matrices in double precision (operations/s).
    pub double: [f64; 2],
    /// The same in single precision.
    pub single: [f64; 2],
}

impl Limits {
    /// Measures them on one thread and on all that share the work here; the rates are NaN
    /// where there is no BLAS. Nothing else of the process may use the BLAS meanwhile.
    pub fn measure() -> Limits {
        Limits { bandwidth: bandwidth(), double: rates::<f64>(), single: rates::<f32>() }
    }

    /// Least time to read so many bytes and do so many operations in double precision, on
    /// several threads (s).
    pub fn floor(&self, bytes: f64, flops: f64) -> f64 {
        (bytes / self.bandwidth[1]).max(flops / self.double[1])
    }
}

/// Seconds of the fastest call.
fn best(run: impl Fn()) -> f64 {
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
    let one = || {
        black_box(sum(&data));
    };
    let all = || {
        black_box(data.par_chunks(PART).map(sum).sum::<f64>());
    };
    let bytes = (NUMBERS * size_of::<f64>()) as f64;
    [bytes / best(one), bytes / best(all)]
}

fn rates<T: Real + Send + Sync>() -> [f64; 2] {
    let (a, b) = (vec![T::ONE; ROWS * ROWS], vec![T::ONE; ROWS * ROWS]);
    let c = RefCell::new(vec![T::default(); ROWS * ROWS]);
    // Keeps CHOLMOD linked, and so the BLAS loaded.
    black_box(cholmod_sys::cholmod_l_factorize as *const ());
    let rates = [1, rayon::current_num_threads()].map(|threads| {
        blas::set_num_threads(threads);
        if !blas::multiply(ROWS, &a, &b, &mut c.borrow_mut()) {
            return f64::NAN;
        }
        let time = best(|| {
            black_box(blas::multiply(ROWS, &a, &b, &mut c.borrow_mut()));
        });
        2.0 * (ROWS as f64).powi(3) / time
    });
    // As the library sets it at first: the bits of a factor depend on it.
    blas::set_num_threads(1);
    rates
}
