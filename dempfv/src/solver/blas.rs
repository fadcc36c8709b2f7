//! The threads of the BLAS, which are the whole process's.
//!
//! OpenBLAS cuts its work by the number of its threads and so rounds
//! differently with each. The library promises results that do not depend on
//! the number of threads, so the BLAS runs on one unless [`set_threads`] says
//! otherwise.

use std::sync::Once;

static CHOSEN: Once = Once::new();

/// Lets the BLAS use this many threads, for the whole process, and gives up
/// the promise that results are the same bits for any number of threads.
/// Returns false for no thread at all, and where the loaded BLAS is not OpenBLAS: nothing was set
/// then.
///
/// Not to be called while another thread factors or solves.
pub fn set_threads(threads: usize) -> bool {
    if threads == 0 {
        return false;
    }
    CHOSEN.call_once(|| {});
    cholmod_sys::blas::set_num_threads(threads)
}

/// Number of threads that the BLAS uses; `None` where it is not OpenBLAS.
pub fn threads() -> Option<usize> {
    cholmod_sys::blas::num_threads()
}

/// Which BLAS is loaded: OpenBLAS's own words, else the library's file.
pub fn description() -> String {
    cholmod_sys::blas::description()
}

/// Sets one thread, once, unless the user has chosen.
pub(super) fn choose_default() {
    CHOSEN.call_once(|| {
        cholmod_sys::blas::set_num_threads(1);
    });
}
