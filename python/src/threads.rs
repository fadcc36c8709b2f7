//! The threads that share the work.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;

use crate::errors::{refused, wrong};

/// Stack of a thread (bytes): that of a main thread, on which the same libraries run elsewhere.
const STACK_BYTES: usize = 8 << 20;

/// What [`set_threads`] was told; 0: as many as there are processors, or `RAYON_NUM_THREADS`.
static WANTED: AtomicUsize = AtomicUsize::new(0);
/// Why there are no threads, if there are none.
static STARTED: OnceLock<Result<(), String>> = OnceLock::new();

/// Starts the threads, once.
pub fn start(py: Python<'_>) -> PyResult<()> {
    if STARTED.get().is_none() {
        let threading = py.import("threading")?;
        let main = threading.call_method0("main_thread")?;
        let here = threading.call_method0("current_thread")?.is(&main);
        // Python's main thread is one of them, so that it hands a step to no other. It lives as
        // long as they do.
        let mut pool = rayon::ThreadPoolBuilder::new()
            .stack_size(STACK_BYTES)
            .num_threads(WANTED.load(Ordering::Relaxed));
        if here {
            pool = pool.use_current_thread();
        }
        let _ = STARTED.set(pool.build_global().map_err(|e| e.to_string()));
    }
    match STARTED.get() {
        Some(Err(why)) => Err(wrong(
            py,
            format!("cannot start the threads: {why}"),
            "ask for fewer with dempfv.set_threads before anything is computed",
        )),
        _ => Ok(()),
    }
}

/// Says how many threads share the work of this process.
///
/// Results have the same bits for any number of them. Without this call there are as many as the
/// machine has processors, or as the environment variable ``RAYON_NUM_THREADS`` says.
///
/// Parameters
/// ----------
/// count : int
///     1 or more.
///
/// Raises
/// ------
/// InputError
///     For less than 1.
/// SimulationError
///     After the first computation of the process: the threads are there then.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> dp.set_threads(0)
/// Traceback (most recent call last):
/// dempfv.InputError: 0 threads; give 1 or more
#[pyfunction]
pub fn set_threads(py: Python<'_>, count: usize) -> PyResult<()> {
    if count == 0 {
        return Err(wrong(py, "0 threads", "give 1 or more"));
    }
    if STARTED.get().is_some() {
        let message = "the threads have been started; call set_threads before anything is computed";
        return Err(refused(py, message));
    }
    WANTED.store(count, Ordering::Relaxed);
    Ok(())
}
