//! The threads of the BLAS, which are the whole process's.
//!
//! OpenBLAS cuts its work by the number of its threads and so rounds
//! differently with each. The library promises results that do not depend on
//! the number of threads, so the BLAS runs on one unless [`set_threads`] says
//! otherwise.

use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};

static CHOSEN: Once = Once::new();

/// What OpenBLAS maps for each thread that calls it, as Debian builds it (bytes).
const BUFFER: usize = 1 << 27;
/// Threads whose buffers have been found room for.
static ROOM: AtomicUsize = AtomicUsize::new(0);

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

/// Whether there is room for the buffers of so many threads, beside so many bytes. OpenBLAS asks
/// for a buffer again and again, without end, where the system refuses one.
pub(super) fn has_room(callers: usize, bytes: usize) -> bool {
    if threads().is_none() || ROOM.load(Ordering::Relaxed) >= callers {
        return true;
    }
    let reserve = |bytes: usize| {
        let mut piece: Vec<u8> = Vec::new();
        piece.try_reserve_exact(bytes).map(|()| piece)
    };
    // One by one, as they will be asked for: together they may be more than systems lend at once.
    let buffers = std::iter::repeat_n(BUFFER, callers).chain([bytes]);
    let pieces: Result<Vec<Vec<u8>>, _> = buffers.map(reserve).collect();
    if pieces.is_ok() {
        ROOM.fetch_max(callers, Ordering::Relaxed);
    }
    pieces.is_ok()
}

/// Sets one thread, once, unless the user has chosen.
pub(super) fn choose_default() {
    CHOSEN.call_once(|| {
        cholmod_sys::blas::set_num_threads(1);
    });
}
